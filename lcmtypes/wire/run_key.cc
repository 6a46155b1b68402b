#include "lcmtypes/wire/run_key.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sodium.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <stdexcept>

namespace knap {
namespace {

class File {
 public:
  explicit File(int fd) : fd_(fd) {}
  ~File() {
    if (fd_ >= 0) close(fd_);
  }
  File(const File&) = delete;
  File& operator=(const File&) = delete;
  int fd() const { return fd_; }

 private:
  int fd_;
};

[[noreturn]] void ThrowKeyError(const std::string& path, const std::string& what) {
  throw std::runtime_error(fmt::format("key file {}: {}", path, what));
}

}  // namespace

RunKey::RunKey() : bytes_{} { std::memcpy(bytes_.data(), "knap public key, protects nought", 32); }

RunKey::RunKey(const std::array<std::uint8_t, 32>& bytes) : bytes_(bytes) {}

RunKey RunKey::ReadFile(const std::string& path) {
  const File file(open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (file.fd() < 0) ThrowKeyError(path, std::strerror(errno));
  struct stat info {};
  if (fstat(file.fd(), &info) != 0) ThrowKeyError(path, std::strerror(errno));
  if ((info.st_mode & 077) != 0) {
    ThrowKeyError(path, fmt::format("mode {:04o} lets others read it; `chmod 600` it", info.st_mode & 07777));
  }
  std::array<std::uint8_t, 33> bytes{};
  const ssize_t size = read(file.fd(), bytes.data(), bytes.size());
  if (size != 32) ThrowKeyError(path, "a key is 32 bytes, this file is not");
  std::array<std::uint8_t, 32> key{};
  std::memcpy(key.data(), bytes.data(), key.size());
  return RunKey(key);
}

RunKey RunKey::MakeRandom() {
  if (sodium_init() < 0) throw std::runtime_error("libsodium cannot start");
  std::array<std::uint8_t, 32> bytes{};
  randombytes_buf(bytes.data(), bytes.size());
  return RunKey(bytes);
}

void RunKey::WriteFile(const std::string& path) const {
  const File file(open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600));
  if (file.fd() < 0) ThrowKeyError(path, std::strerror(errno));
  if (write(file.fd(), bytes_.data(), bytes_.size()) != static_cast<ssize_t>(bytes_.size()) || fsync(file.fd()) != 0) {
    ThrowKeyError(path, std::strerror(errno));
  }
}

RunKey::Digest RunKey::CalcDigest(const std::uint8_t* message, std::size_t size) const {
  static constexpr std::array<std::uint8_t, kDigestSize> kZeros{};
  crypto_auth_hmacsha256_state state;
  crypto_auth_hmacsha256_init(&state, bytes_.data(), bytes_.size());
  crypto_auth_hmacsha256_update(&state, message, size - kDigestSize);
  crypto_auth_hmacsha256_update(&state, kZeros.data(), kZeros.size());
  std::array<std::uint8_t, crypto_auth_hmacsha256_BYTES> full{};
  crypto_auth_hmacsha256_final(&state, full.data());
  Digest digest;
  std::memcpy(digest.data(), full.data(), digest.size());
  return digest;
}

bool RunKey::Verify(const std::uint8_t* message, std::size_t size) const {
  if (size < kDigestSize) return false;
  const Digest digest = CalcDigest(message, size);
  return sodium_memcmp(digest.data(), message + size - kDigestSize, kDigestSize) == 0;
}

}  // namespace knap
