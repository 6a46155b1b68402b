#include "lcmtypes/wire/codec.h"

#include <fmt/format.h>

#include <stdexcept>

namespace knap {

void RefusalCounters::Count(Refusal refusal) {
  switch (refusal) {
    case Refusal::kNone:
      return;
    case Refusal::kTooLarge:
      ++too_large;
      return;
    case Refusal::kForeign:
      ++foreign;
      return;
    case Refusal::kCorrupt:
      ++corrupt;
      return;
    case Refusal::kMalformed:
      ++malformed;
      return;
  }
}

namespace internal {

void ThrowUnsendable(const char* type, int size) {
  throw std::logic_error(fmt::format("{}: encodes to {} bytes; at most {} travel", type, size, kMaxMessageSize));
}

Refusal CheckEnvelope(const std::uint8_t* bytes, std::size_t size, std::int64_t fingerprint, const RunKey& key) {
  if (size > kMaxMessageSize) return Refusal::kTooLarge;
  if (size < 8 + RunKey::kDigestSize) return Refusal::kForeign;
  std::uint64_t found = 0;
  for (std::size_t i = 0; i < 8; ++i) found = (found << 8) | bytes[i];
  if (found != static_cast<std::uint64_t>(fingerprint)) return Refusal::kForeign;
  return key.Verify(bytes, size) ? Refusal::kNone : Refusal::kCorrupt;
}

}  // namespace internal
}  // namespace knap
