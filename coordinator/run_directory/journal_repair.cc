#include "coordinator/run_directory/journal_repair.h"

#include <optional>
#include <set>
#include <string_view>

#include "coordinator/run_directory/durable_file.h"
#include "coordinator/run_directory/journal_file.h"

namespace knap {
namespace {

std::filesystem::path ChooseNameAside(const std::filesystem::path& journal) {
  std::filesystem::path base = journal;
  base += ".damaged";
  std::filesystem::path name = base;
  for (int number = 2; std::filesystem::exists(name); ++number) {
    name = base;
    name += "-";
    name += std::to_string(number);
  }
  return name;
}

}  // namespace

JournalRepair RepairJournal(const std::filesystem::path& path, const RunIdentity& identity) {
  const auto lock = OpenLockedJournal(path);
  const std::string bytes = lock->ReadAll();
  JournalRepair repair;
  std::string whole, damaged;
  std::size_t position = 0;
  const auto set_aside_until = [&](std::size_t end) {
    if (end == position) return;
    repair.damaged.push_back({position, end - position});
    damaged += bytes.substr(position, end - position);
  };

  if (const std::optional<std::string_view> header = DecodeHeader(bytes)) {
    whole = EncodeRecord(0, *header);
    position = whole.size();
  } else {
    whole = Journal::EncodeHeader(identity);
    repair.header_lost = true;
  }
  std::set<std::uint64_t> found;
  while (const std::optional<FoundRecord> record = FindRecord(bytes, position, 0)) {
    set_aside_until(record->offset);
    repair.payloads.emplace_back(record->payload);
    whole += EncodeRecord(repair.payloads.size(), record->payload);
    position = record->end();
    found.insert(record->sequence);
  }
  set_aside_until(bytes.size());
  for (std::uint64_t number = 1; !found.empty() && number < *found.rbegin(); ++number) {
    if (!found.contains(number)) repair.missing.push_back(number);
  }
  repair.changed = whole != bytes;
  if (!damaged.empty()) {
    repair.set_aside = ChooseNameAside(path);
    WriteFileAtomically(repair.set_aside, damaged);
  }
  if (repair.changed) WriteFileAtomically(path, whole);
  return repair;
}

}  // namespace knap
