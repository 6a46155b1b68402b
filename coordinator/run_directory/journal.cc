#include "coordinator/run_directory/journal.h"

#include <cstddef>
#include <optional>
#include <stdexcept>
#include <utility>

#include "coordinator/run_directory/durable_file.h"
#include "coordinator/run_directory/journal_file.h"

namespace knap {
namespace {

constexpr std::size_t kMaxPayload = std::size_t{1} << 30;

[[noreturn]] void Refuse(const std::filesystem::path& path, const std::string& what) {
  throw std::runtime_error(path.string() + ": " + what);
}

// Damage that may not be passed over: what is behind it would be lost.
[[noreturn]] void RefuseDamaged(const std::filesystem::path& path, const std::string& what) {
  Refuse(path,
         what + "; `knap repair " + path.parent_path().string() + "` keeps what is whole and sets the rest aside");
}

// The first thing in which a header's identity differs, for people.
std::string DescribeDifference(std::string_view found, const RunIdentity& identity) {
  found.remove_prefix(found.find('\n') + 1);  // what kind of file it is
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

std::string_view RequireHeader(const std::filesystem::path& path, std::string_view bytes) {
  const std::optional<std::string_view> header = DecodeHeader(bytes);
  if (!header) RefuseDamaged(path, "not a knap journal, or its header is damaged");
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
  records.end = kRecordPrefix + RequireHeader(path, bytes).size();
  while (const auto payload = DecodeRecord(bytes.substr(records.end), records.next_sequence)) {
    records.payloads.emplace_back(*payload);
    records.end += kRecordPrefix + payload->size();
    ++records.next_sequence;
  }
  if (FindRecord(bytes, records.end, records.next_sequence - 1)) {
    RefuseDamaged(path, "corrupted: record " + std::to_string(records.next_sequence) + " at byte " +
                            std::to_string(records.end) + " is damaged, and valid records follow it");
  }
  return records;
}

}  // namespace

Journal::Journal(std::unique_ptr<AppendFile> file, std::uint64_t next_sequence)
    : file_(std::move(file)), next_sequence_(next_sequence) {}

std::string Journal::EncodeHeader(const RunIdentity& identity) {
  return EncodeRecord(0, EncodeHeaderPayload(identity));
}

Journal Journal::Create(const std::filesystem::path& path, const RunIdentity& identity) {
  if (std::filesystem::exists(path)) Refuse(path, "exists already");
  WriteFileAtomically(path, EncodeHeader(identity));
  return Journal(OpenLockedJournal(path), 1);
}

Journal::Opened Journal::Open(const std::filesystem::path& path, const RunIdentity& identity) {
  return Open(OpenLockedJournal(path), identity);
}

Journal::Opened Journal::Open(std::unique_ptr<AppendFile> file, const RunIdentity& identity) {
  const std::string bytes = file->ReadAll();
  const std::string_view found = RequireHeader(file->path(), bytes);
  if (found != EncodeHeaderPayload(identity)) {
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
