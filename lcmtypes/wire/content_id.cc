#include "lcmtypes/wire/content_id.h"

#include <sodium.h>

#include <bit>

namespace knap {
namespace {

class CanonicalBytes {
 public:
  void AddInteger(std::uint64_t value) {
    for (int shift = 0; shift < 64; shift += 8) bytes_.push_back(static_cast<char>((value >> shift) & 0xff));
  }
  void AddString(std::string_view s) {
    AddInteger(s.size());
    bytes_.append(s);
  }
  void AddId(const ContentId& id) { bytes_.append(id.begin(), id.end()); }
  void AddDoubles(std::span<const double> values) {
    AddInteger(values.size());
    for (const double value : values) AddInteger(std::bit_cast<std::uint64_t>(value));
  }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

}  // namespace

ContentId CalcSha256(std::string_view bytes) {
  ContentId id;
  crypto_hash_sha256(id.data(), reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size());
  return id;
}

ContentId CalcRequestId(const RequestContent& content) {
  CanonicalBytes bytes;
  bytes.AddString("knap-request-3");
  bytes.AddString(content.engine);
  bytes.AddId(content.scenario);
  bytes.AddDoubles(content.theta);
  bytes.AddDoubles(content.controls);
  bytes.AddDoubles(content.reference);
  bytes.AddDoubles(content.variation);
  bytes.AddDoubles(content.nodes);
  bytes.AddInteger(content.reference.empty() ? 0 : 1);
  bytes.AddInteger(content.gradient ? 1 : 0);
  return CalcSha256(bytes.bytes());
}

ContentId CalcFingerprint(std::span<const double> numbers) {
  CanonicalBytes bytes;
  bytes.AddString("knap-numbers-1");
  bytes.AddDoubles(numbers);
  return CalcSha256(bytes.bytes());
}

std::string FormatHex(const ContentId& id) {
  std::string hex;
  for (const std::uint8_t byte : id) {
    hex.push_back("0123456789abcdef"[byte >> 4]);
    hex.push_back("0123456789abcdef"[byte & 15]);
  }
  return hex;
}

std::string FormatShort(const ContentId& id) { return FormatHex(id).substr(0, kShortDigits); }

void AppendId(const ContentId& id, std::vector<std::uint8_t>* bytes) {
  bytes->insert(bytes->end(), id.begin(), id.end());
}

std::vector<ContentId> ParseIds(const std::vector<std::uint8_t>& bytes) {
  std::vector<ContentId> ids(bytes.size() / 32);
  for (std::size_t i = 0; i < ids.size(); ++i) std::memcpy(ids[i].data(), bytes.data() + 32 * i, 32);
  return ids;
}

}  // namespace knap
