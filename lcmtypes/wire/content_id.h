// Content ids: SHA-256 of everything that a thing depends on, so that equal ids mean equal things.
//
// The id of a request is the hash of one canonical sequence of bytes; every integer is an unsigned 64-bit little-endian
// number, every double its IEEE 754 bits as such a number, every string its length and then its bytes, every list its
// length and then its elements:
//   string "knap-request-3", string engine, 32 bytes scenario id, list theta, list controls, list reference (theta,
//   then controls), list variation, list nodes (theta, then controls), integer kind of loss (0 task, 1 distillation),
//   integer derivative (0 loss alone, 1 with gradient).
// Attempts, leases and senders stay outside, so the id is the idempotency key and the cache key.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace knap {

using ContentId = std::array<std::uint8_t, 32>;

struct ContentIdHash {
  // SHA-256 is uniform: any 8 bytes of it are a hash.
  std::size_t operator()(const ContentId& id) const {
    std::size_t h = 0;
    std::memcpy(&h, id.data(), sizeof(h));
    return h;
  }
};

ContentId CalcSha256(std::string_view bytes);

struct RequestContent {
  std::string_view engine;
  ContentId scenario{};
  std::span<const double> theta;
  std::span<const double> controls;   // and weights of a policy; empty: none
  std::span<const double> reference;  // theta, then controls; empty: task loss, else distillation
  std::span<const double> variation;
  bool gradient = true;
  std::span<const double> nodes{};  // theta, then controls; empty: time steps are chosen
};

ContentId CalcRequestId(const RequestContent& content);

// SHA-256 of string "knap-numbers-1" and list `numbers`, encoded as above: machines on which the same program rounds
// but one of the numbers differently have different fingerprints.
ContentId CalcFingerprint(std::span<const double> numbers);

// 64 lower-case hexadecimal digits, and the first of them for messages to people.
inline constexpr std::size_t kShortDigits = 12;
std::string FormatHex(const ContentId& id);
std::string FormatShort(const ContentId& id);

// Lists of ids travel as one byte array, 32 bytes each. ParseIds ignores an incomplete last one.
void AppendId(const ContentId& id, std::vector<std::uint8_t>* bytes);
std::vector<ContentId> ParseIds(const std::vector<std::uint8_t>& bytes);

// A fixed-size field of a message, from and to an id.
inline ContentId MakeId(const std::uint8_t (&field)[32]) {
  ContentId id;
  std::memcpy(id.data(), field, id.size());
  return id;
}
inline void CopyId(const ContentId& id, std::uint8_t (&field)[32]) { std::memcpy(field, id.data(), id.size()); }

}  // namespace knap
