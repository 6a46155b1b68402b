// The run key: 32 secret bytes that coordinator and workers share; every message carries a digest made with it.
//
// digest = the first 16 bytes of HMAC-SHA256(key, encoded message with its digest zeroed) [RFC 2104, FIPS 198-1].
// Without a key file everyone uses a fixed, public key: then digests catch corruption and strangers by accident, not
// an attacker.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>

namespace knap {

class RunKey {
 public:
  static constexpr std::size_t kDigestSize = 16;
  using Digest = std::array<std::uint8_t, kDigestSize>;

  RunKey();  // the public default key
  explicit RunKey(const std::array<std::uint8_t, 32>& bytes);

  // Reads 32 raw bytes. Throws std::runtime_error naming the path when the file is missing, has another length, or can
  // be read by group or others.
  static RunKey ReadFile(const std::string& path);

  static RunKey MakeRandom();

  // Creates the file with mode 0600; throws std::runtime_error when it exists or cannot be written.
  void WriteFile(const std::string& path) const;

  // The digest of a message whose last kDigestSize bytes are its digest field. Precondition: size >= kDigestSize.
  Digest CalcDigest(const std::uint8_t* message, std::size_t size) const;

  // Compares in constant time. False when size < kDigestSize.
  bool Verify(const std::uint8_t* message, std::size_t size) const;

 private:
  std::array<std::uint8_t, 32> bytes_;
};

}  // namespace knap
