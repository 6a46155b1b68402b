// Walks over an encoded message without allocating, so that every length is checked before the generated decoder,
// which resizes its vectors first, sees it.
//
// LCM's encoding: big-endian scalars, arrays bare, strings as int32 length (with the final NUL), bytes, NUL.
#pragma once

#include <cstddef>
#include <cstdint>

namespace knap {

class WireScanner {
 public:
  WireScanner(const std::uint8_t* bytes, std::size_t size) : bytes_(bytes), size_(size) {}

  // After the first failure every further call does nothing; ok() tells.
  void Skip(std::size_t n) {
    if (!ok_ || n > size_ - position_) {
      ok_ = false;
    } else {
      position_ += n;
    }
  }

  // The int32 at the present position, which must lie in [0, limit]; 0 on failure.
  std::size_t TakeCount(std::int32_t limit) {
    const std::size_t start = position_;
    Skip(4);
    if (!ok_) return 0;
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < 4; ++i) value = (value << 8) | bytes_[start + i];
    if (value > static_cast<std::uint32_t>(limit)) ok_ = false;
    return ok_ ? value : 0;
  }

  // A string of at most max_length characters without NUL inside, and its final NUL.
  void SkipString(std::size_t max_length) {
    const std::size_t size = TakeCount(static_cast<std::int32_t>(max_length) + 1);
    const std::size_t start = position_;
    if (size == 0) ok_ = false;
    Skip(size);
    for (std::size_t i = 0; ok_ && i < size; ++i) ok_ = (bytes_[start + i] == 0) == (i + 1 == size);
  }

  // True when nothing failed and nothing is left.
  bool IsComplete() const { return ok_ && position_ == size_; }

 private:
  const std::uint8_t* bytes_;
  std::size_t size_;
  std::size_t position_ = 0;
  bool ok_ = true;
};

}  // namespace knap
