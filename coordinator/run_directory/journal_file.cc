#include "coordinator/run_directory/journal_file.h"

#include <fcntl.h>

#include <stdexcept>

#include "coordinator/run_directory/crc32c.h"

namespace knap {
namespace {

constexpr std::string_view kMagic = "knap journal 2\n";

template <typename Unsigned>
void AppendInteger(std::string& bytes, Unsigned value) {
  for (std::size_t k = 0; k < sizeof(Unsigned); ++k) bytes.push_back(static_cast<char>((value >> (8 * k)) & 0xFFu));
}

template <typename Unsigned>
Unsigned ReadInteger(std::string_view bytes) {
  Unsigned value = 0;
  for (std::size_t k = 0; k < sizeof(Unsigned); ++k) {
    value |= static_cast<Unsigned>(static_cast<unsigned char>(bytes[k])) << (8 * k);
  }
  return value;
}

}  // namespace

std::string EncodeRecord(std::uint64_t sequence, std::string_view payload) {
  std::string length, tail;
  AppendInteger(length, static_cast<std::uint32_t>(payload.size()));
  AppendInteger(tail, sequence);
  tail += payload;
  std::string record = length;
  AppendInteger(record, CalcCrc32c(tail, CalcCrc32c(length)));
  return record + tail;
}

std::optional<std::string_view> DecodeRecord(std::string_view bytes, std::uint64_t sequence) {
  if (bytes.size() < kRecordPrefix || ReadInteger<std::uint64_t>(bytes.substr(8)) != sequence) return std::nullopt;
  const std::size_t length = ReadInteger<std::uint32_t>(bytes);
  if (length > bytes.size() - kRecordPrefix) return std::nullopt;
  const std::uint32_t crc = CalcCrc32c(bytes.substr(8, 8 + length), CalcCrc32c(bytes.substr(0, 4)));
  if (crc != ReadInteger<std::uint32_t>(bytes.substr(4))) return std::nullopt;
  return bytes.substr(kRecordPrefix, length);
}

std::optional<FoundRecord> FindRecord(std::string_view bytes, std::size_t offset, std::uint64_t sequence) {
  const std::uint64_t highest = sequence + bytes.size() / kRecordPrefix;
  for (; offset + kRecordPrefix <= bytes.size(); ++offset) {
    const auto candidate = ReadInteger<std::uint64_t>(bytes.substr(offset + 8));
    if (candidate <= sequence || candidate > highest) continue;
    if (const auto payload = DecodeRecord(bytes.substr(offset), candidate)) {
      return FoundRecord{offset, candidate, *payload};
    }
  }
  return std::nullopt;
}

std::string EncodeHeaderPayload(const RunIdentity& identity) {
  std::string text(kMagic);
  for (const auto& [name, value] : identity) text.append(name).append(": ").append(value).append("\n");
  return text;
}

std::optional<std::string_view> DecodeHeader(std::string_view bytes) {
  const std::optional<std::string_view> header = DecodeRecord(bytes, 0);
  if (!header || header->substr(0, kMagic.size()) != kMagic) return std::nullopt;
  return header;
}

std::unique_ptr<DurableFile> OpenLockedJournal(const std::filesystem::path& path) {
  auto file = std::make_unique<DurableFile>(path, O_RDWR | O_APPEND);
  // A repair puts another file in its place; a lock on the one that was there keeps nobody away.
  if (!file->TryLock() || !file->IsAtItsPath()) {
    throw std::runtime_error(path.string() + ": another process is using this run");
  }
  return file;
}

}  // namespace knap
