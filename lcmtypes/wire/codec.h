// Seal and Open: messages to bytes and back, with the digest, and with every length checked before it is believed.
//
// Open checks in this order: size <= kMaxMessageSize, LCM fingerprint of the type, digest over all bytes, lengths
// (message_layouts.h), the generated decoder, decode() == size. Whatever passes is what a holder of the run key sent.
// Both ways every string is made valid UTF-8 without control characters, and cut to its limit (text.h).
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string>
#include <vector>

#include "lcmtypes/wire/channels.h"
#include "lcmtypes/wire/message_layouts.h"
#include "lcmtypes/wire/run_key.h"

namespace knap {

enum class Refusal { kNone, kTooLarge, kForeign, kCorrupt, kMalformed };

// Messages refused, by reason: kForeign has another type's or another version's fingerprint, kCorrupt a wrong digest
// (damage, or a stranger's key), kMalformed a right digest but impossible lengths.
struct RefusalCounters {
  std::int64_t too_large = 0;
  std::int64_t foreign = 0;
  std::int64_t corrupt = 0;
  std::int64_t malformed = 0;

  void Count(Refusal refusal);
  std::int64_t total() const { return too_large + foreign + corrupt + malformed; }
};

namespace internal {
// Throws std::logic_error: our own message breaks the limits, a defect of the caller.
[[noreturn]] void ThrowUnsendable(const char* type, int size);
Refusal CheckEnvelope(const std::uint8_t* bytes, std::size_t size, std::int64_t fingerprint, const RunKey& key);
}  // namespace internal

// Encodes the message; its counts, texts and digest are set here.
template <typename T>
std::vector<std::uint8_t> Seal(T message, const RunKey& key) {
  SetCounts(&message);
  CleanTexts(&message);
  std::memset(message.digest, 0, sizeof(message.digest));
  const int size = message.getEncodedSize();
  if (size < 0 || static_cast<std::size_t>(size) > kMaxMessageSize) internal::ThrowUnsendable(T::getTypeName(), size);
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(size));
  if (message.encode(bytes.data(), 0, size) != size) internal::ThrowUnsendable(T::getTypeName(), size);
  const RunKey::Digest digest = key.CalcDigest(bytes.data(), bytes.size());
  std::memcpy(bytes.data() + bytes.size() - digest.size(), digest.data(), digest.size());
  return bytes;
}

// Empty when refused; *refusal (may be null) then says why.
template <typename T>
std::optional<T> Open(const std::uint8_t* bytes, std::size_t size, const RunKey& key, Refusal* refusal) {
  Refusal verdict = internal::CheckEnvelope(bytes, size, T::getHash(), key);
  std::optional<T> message;
  if (verdict == Refusal::kNone) {
    WireScanner scanner(bytes + 8, size - 8);
    Scan(static_cast<const T*>(nullptr), &scanner);
    message.emplace();
    if (!scanner.IsComplete() || message->decode(bytes, 0, static_cast<int>(size)) != static_cast<int>(size)) {
      verdict = Refusal::kMalformed;
      message.reset();
    } else {
      CleanTexts(&*message);
    }
  }
  if (refusal != nullptr) *refusal = verdict;
  return message;
}

template <typename T>
std::optional<T> Open(const std::vector<std::uint8_t>& bytes, const RunKey& key, RefusalCounters* counters) {
  Refusal refusal = Refusal::kNone;
  std::optional<T> message = Open<T>(bytes.data(), bytes.size(), key, &refusal);
  counters->Count(refusal);
  return message;
}

}  // namespace knap
