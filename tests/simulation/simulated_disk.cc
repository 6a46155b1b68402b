#include "tests/simulation/simulated_disk.h"

#include <cerrno>
#include <system_error>
#include <utility>

#include "coordinator/run/answer_journal.h"

namespace knap {
namespace {

constexpr std::size_t kPrefix = 16;  // of a record: length, checksum, sequence (coordinator/run_directory/journal.h)

std::size_t ReadLength(std::string_view record) {
  std::size_t length = 0;
  for (std::size_t i = 4; i-- > 0;) length = (length << 8) | static_cast<unsigned char>(record[i]);
  return length;
}

}  // namespace

void SimulatedDisk::Create(std::string bytes) {
  exists_ = true;
  bytes_ = durable_ = std::move(bytes);
}

void SimulatedDisk::Sync() {
  const bool appended = bytes_.size() >= durable_.size() && bytes_.compare(0, durable_.size(), durable_) == 0;
  const std::size_t begin = appended ? durable_.size() : 0;
  durable_ = bytes_;
  if (!appended) answers_.clear();
  ReadAnswers(begin);
  if (appended) return;
  for (const ContentId& id : relied_on_) {
    if (!HoldsAnswer(id)) lost_ = id;
  }
}

void SimulatedDisk::ReadAnswers(std::size_t begin) {
  std::string_view rest = std::string_view(durable_).substr(begin);
  bool is_header = begin == 0;
  while (rest.size() >= kPrefix && rest.size() >= kPrefix + ReadLength(rest)) {
    const std::size_t length = ReadLength(rest);
    if (!is_header) {
      for (const JournaledAnswer& answer : DecodeAnswers(rest.substr(kPrefix, length))) answers_.insert(answer.id);
    }
    is_header = false;
    rest.remove_prefix(kPrefix + length);
  }
}

void SimulatedDisk::Crash(const std::function<double()>& draw) {
  const bool appended = bytes_.size() >= durable_.size() && bytes_.compare(0, durable_.size(), durable_) == 0;
  if (!appended) {  // cut, and the cut not synced
    bytes_ = draw() < 0.5 ? durable_ : bytes_;
  } else {
    std::string kept = bytes_.substr(durable_.size());
    const std::size_t written = kept.size();
    kept.resize(static_cast<std::size_t>(draw() * static_cast<double>(written + 1)));
    if (!kept.empty() && draw() < 0.2)
      kept[static_cast<std::size_t>(draw() * static_cast<double>(kept.size()))] ^= 0x10;
    if (draw() < 0.2) kept.resize(written, '\0');
    bytes_ = durable_ + kept;
  }
}

std::string SimulatedFile::ReadAll() const {
  if (!hooks_.read_fails) return disk_->bytes();
  if (!hooks_.read_is_short) throw std::system_error(EIO, std::generic_category(), path_.string());
  // What was read before the failure: whole records, so that nothing looks damaged.
  const std::string& bytes = disk_->bytes();
  std::size_t end = kPrefix + ReadLength(bytes);
  while (end < bytes.size() / 2 && end + kPrefix <= bytes.size()) {
    end += kPrefix + ReadLength(std::string_view(bytes).substr(end));
  }
  return bytes.substr(0, end);
}

void SimulatedFile::Write(std::string_view bytes) {
  if (!hooks_.is_alive()) return;
  try {
    hooks_.on_effect();
  } catch (...) {
    disk_->Write(bytes.substr(0, static_cast<std::size_t>(hooks_.draw() * static_cast<double>(bytes.size() + 1))));
    throw;
  }
  disk_->Write(bytes);
}

void SimulatedFile::Sync() {
  if (!hooks_.is_alive()) return;
  hooks_.on_effect();
  if (!hooks_.sync_does_nothing) disk_->Sync();
}

void SimulatedFile::Truncate(std::uint64_t size) {
  if (!hooks_.is_alive()) return;
  hooks_.on_effect();
  disk_->Truncate(static_cast<std::size_t>(size));
}

}  // namespace knap
