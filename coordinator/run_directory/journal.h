// The coordinator's memory across crashes: an append-only file of records, on the disk before anything acts upon them.
//
// A file is a sequence of records, all integers little endian:
//
//   uint32 length of the payload | uint32 CRC-32C of (length, sequence, payload) | uint64 sequence | payload
//
// Sequence numbers count 0, 1, 2, … Record 0 is the header: "knap journal 2\n" and then what the run's bits depend on,
// one line "name: value\n" each. The meaning of all other payloads is the caller's.
//
// After a crash the file may end in a part of the record being written. Opening cuts such a torn tail off: it was never
// acted upon, since Append returns after fdatasync. A damaged record with a valid one anywhere behind it is not a torn
// tail but corruption, and an error. So is a damaged header: a file is created whole, by renaming. journal_repair.h
// goes on from there.
//
// One Append is one record is one fdatasync: collect what arrived together into one payload.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "coordinator/run_directory/append_file.h"

namespace knap {

// What a run's bits depend on beside the questions it asks: names and values (configuration, build, ...), in one fixed
// order. Names hold no ": ", neither holds a line end.
using RunIdentity = std::vector<std::pair<std::string, std::string>>;

class Journal {
 public:
  // Creates the file, which must not exist, with its header.
  static Journal Create(const std::filesystem::path& path, const RunIdentity& identity);

  struct Opened;
  // Opens for reading and further appending. Throws std::runtime_error with one line that names the file and, for
  // corruption, the offset: not a journal, of a run with another identity (the line names what differs), corrupted, or
  // in use by another process.
  static Opened Open(const std::filesystem::path& path, const RunIdentity& identity);

  // The same for a file that is open already and that nobody else uses.
  static Opened Open(std::unique_ptr<AppendFile> file, const RunIdentity& identity);

  // All whole records behind the header, in order, whatever run it belongs to and whoever uses it; nothing is changed.
  // Throws as Open does when it is not a journal or corrupted.
  static std::vector<std::string> Read(const std::filesystem::path& path);

  // What a new journal holds.
  static std::string EncodeHeader(const RunIdentity& identity);

  // The payload is durable when this returns. If it throws (std::system_error: disk full, …) the journal takes no more.
  void Append(std::string_view payload);

 private:
  Journal(std::unique_ptr<AppendFile> file, std::uint64_t next_sequence);

  std::unique_ptr<AppendFile> file_;
  std::uint64_t next_sequence_;
  bool failed_ = false;
};

struct Journal::Opened {
  Journal journal;
  std::vector<std::string> payloads;  // of all whole records behind the header, in order
  std::uint64_t torn_bytes = 0;       // cut off at the end
};

}  // namespace knap
