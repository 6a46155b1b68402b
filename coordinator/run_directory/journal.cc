#include "coordinator/run_directory/journal.h"

#include <fcntl.h>

#include <cstddef>
#include <optional>
#include <stdexcept>
#include <utility>

#include "coordinator/run_directory/crc32c.h"
#include "coordinator/run_directory/durable_file.h"

namespace knap {
namespace {

constexpr std::string_view kMagic = "knap journal 2\n";
constexpr std::size_t kPrefix = 16;  // length, checksum, sequence
constexpr std::size_t kMaxPayload = std::size_t{1} << 30;

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

std::string EncodeRecord(std::uint64_t sequence, std::string_view payload) {
  std::string length, tail;
  AppendInteger(length, static_cast<std::uint32_t>(payload.size()));
  AppendInteger(tail, sequence);
  tail += payload;
  std::string record = length;
  AppendInteger(record, CalcCrc32c(tail, CalcCrc32c(length)));
  return record + tail;
}

// The payload of a whole, undamaged record at the front of `bytes`.
std::optional<std::string_view> DecodeRecord(std::string_view bytes, std::uint64_t sequence) {
  if (bytes.size() < kPrefix || ReadInteger<std::uint64_t>(bytes.substr(8)) != sequence) return std::nullopt;
  const std::size_t length = ReadInteger<std::uint32_t>(bytes);
  if (length > bytes.size() - kPrefix) return std::nullopt;
  const std::uint32_t crc = CalcCrc32c(bytes.substr(8, 8 + length), CalcCrc32c(bytes.substr(0, 4)));
  if (crc != ReadInteger<std::uint32_t>(bytes.substr(4))) return std::nullopt;
  return bytes.substr(kPrefix, length);
}

// Whether any whole record stands in `bytes` with a sequence number above `sequence`.
bool HoldsLaterRecord(std::string_view bytes, std::uint64_t sequence) {
  const std::uint64_t highest = sequence + bytes.size() / kPrefix;
  for (; bytes.size() >= kPrefix; bytes.remove_prefix(1)) {
    const auto candidate = ReadInteger<std::uint64_t>(bytes.substr(8));
    if (candidate > sequence && candidate <= highest && DecodeRecord(bytes, candidate)) return true;
  }
  return false;
}

[[noreturn]] void Refuse(const std::filesystem::path& path, const std::string& what) {
  throw std::runtime_error(path.string() + ": " + what);
}

std::unique_ptr<AppendFile> OpenLocked(const std::filesystem::path& path) {
  auto file = std::make_unique<DurableFile>(path, O_RDWR | O_APPEND);
  if (!file->TryLock()) Refuse(path, "another process is using this run");
  return file;
}

std::string EncodeIdentity(const RunIdentity& identity) {
  std::string text;
  for (const auto& [name, value] : identity) text.append(name).append(": ").append(value).append("\n");
  return text;
}

// The first thing in which a header's identity differs, for people.
std::string DescribeDifference(std::string_view found, const RunIdentity& identity) {
  for (const auto& [name, value] : identity) {
    const std::string_view line = found.substr(0, found.find('\n'));
    const std::string prefix = name + ": ";
    if (line.substr(0, prefix.size()) != prefix) return name;
    if (line.substr(prefix.size()) != value) {
      return name + " (" + std::string(line.substr(prefix.size())) + ", not " + value + ")";
    }
    found.remove_prefix(line.size() + 1);
  }
  return "identity";
}

std::string_view DecodeHeader(const std::filesystem::path& path, std::string_view bytes) {
  const std::optional<std::string_view> header = DecodeRecord(bytes, 0);
  if (!header || header->substr(0, kMagic.size()) != kMagic) {
    Refuse(path, "not a knap journal, or its header is damaged");
  }
  return *header;
}

struct Records {
  std::vector<std::string> payloads;
  std::size_t end = 0;  // of the last whole one
  std::uint64_t next_sequence = 1;
};

// The whole records behind the header of a journal, up to the torn tail.
Records ReadRecords(const std::filesystem::path& path, std::string_view bytes) {
  Records records;
  records.end = kPrefix + DecodeRecord(bytes, 0)->size();
  while (const auto payload = DecodeRecord(bytes.substr(records.end), records.next_sequence)) {
    records.payloads.emplace_back(*payload);
    records.end += kPrefix + payload->size();
    ++records.next_sequence;
  }
  if (records.end < bytes.size() && HoldsLaterRecord(bytes.substr(records.end + 1), records.next_sequence)) {
    Refuse(path, "corrupted: record " + std::to_string(records.next_sequence) + " at byte " +
                     std::to_string(records.end) + " is damaged, and valid records follow it");
  }
  return records;
}

}  // namespace

Journal::Journal(std::unique_ptr<AppendFile> file, std::uint64_t next_sequence)
    : file_(std::move(file)), next_sequence_(next_sequence) {}

std::string Journal::EncodeHeader(const RunIdentity& identity) {
  return EncodeRecord(0, std::string(kMagic) + EncodeIdentity(identity));
}

Journal Journal::Create(const std::filesystem::path& path, const RunIdentity& identity) {
  if (std::filesystem::exists(path)) Refuse(path, "exists already");
  WriteFileAtomically(path, EncodeHeader(identity));
  return Journal(OpenLocked(path), 1);
}

Journal::Opened Journal::Open(const std::filesystem::path& path, const RunIdentity& identity) {
  return Open(OpenLocked(path), identity);
}

Journal::Opened Journal::Open(std::unique_ptr<AppendFile> file, const RunIdentity& identity) {
  const std::string bytes = file->ReadAll();
  const std::string found(DecodeHeader(file->path(), bytes).substr(kMagic.size()));
  if (found != EncodeIdentity(identity)) {
    Refuse(file->path(), "belongs to a run with another " + DescribeDifference(found, identity));
  }

  Records records = ReadRecords(file->path(), bytes);
  const std::uint64_t torn_bytes = bytes.size() - records.end;
  if (torn_bytes > 0) file->Truncate(records.end);
  file->Sync();  // what a crash of the process alone left unsynced is acted upon from now on
  return {Journal(std::move(file), records.next_sequence), std::move(records.payloads), torn_bytes};
}

std::vector<std::string> Journal::Read(const std::filesystem::path& path) {
  const std::string bytes = ReadFile(path);
  DecodeHeader(path, bytes);
  return ReadRecords(path, bytes).payloads;
}

void Journal::Append(std::string_view payload) {
  if (payload.size() > kMaxPayload) throw std::invalid_argument("Journal::Append: the payload exceeds 1 GiB");
  if (failed_) Refuse(file_->path(), "an earlier write failed, nothing more can be journaled");
  failed_ = true;  // until proven otherwise
  file_->Write(EncodeRecord(next_sequence_, payload));
  file_->Sync();
  failed_ = false;
  ++next_sequence_;
}

}  // namespace knap
