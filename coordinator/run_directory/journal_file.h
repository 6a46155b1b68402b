// The bytes of a journal (journal.h) and the right to change them; for the two that do, Journal and RepairJournal.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "coordinator/run_directory/durable_file.h"
#include "coordinator/run_directory/journal.h"

namespace knap {

// What stands before each payload: length, checksum, sequence.
inline constexpr std::size_t kRecordPrefix = 16;

std::string EncodeRecord(std::uint64_t sequence, std::string_view payload);

// The payload of the whole, undamaged record with this number at the front of `bytes`.
std::optional<std::string_view> DecodeRecord(std::string_view bytes, std::uint64_t sequence);

struct FoundRecord {
  std::size_t offset = 0;
  std::uint64_t sequence = 0;
  std::string_view payload;
  std::size_t end() const { return offset + kRecordPrefix + payload.size(); }
};

// The first whole record at or behind `offset` whose number is above `sequence`, and no higher than a file of this size
// can hold, so that chance does not make one out of damaged bytes.
std::optional<FoundRecord> FindRecord(std::string_view bytes, std::size_t offset, std::uint64_t sequence);

// The header's payload for this identity, and the one at the front of `bytes`; empty when there stands no header.
std::string EncodeHeaderPayload(const RunIdentity& identity);
std::optional<std::string_view> DecodeHeader(std::string_view bytes);

// Opens a journal that nobody else uses, and keeps others from it while the file is open. Throws std::runtime_error
// when another process has it.
std::unique_ptr<DurableFile> OpenLockedJournal(const std::filesystem::path& path);

}  // namespace knap
