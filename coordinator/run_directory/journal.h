// The coordinator's memory across crashes: an append-only file of records, on the disk before anything acts upon them.
//
// A file is a sequence of records, all integers little endian:
//
//   uint32 length of the payload | uint32 CRC-32C of (length, sequence, payload) | uint64 sequence | payload
//
// Sequence numbers count 0, 1, 2, … Record 0 is the header: "knap journal 1\n" and then the hash of the run's
// configuration. The meaning of all other payloads is the caller's.
//
// After a crash the file may end in a part of the record being written. Opening cuts such a torn tail off: it was never
// acted upon, since Append returns after fdatasync. A damaged record with a valid one anywhere behind it is not a torn
// tail but corruption, and an error. So is a damaged header: a file is created whole, by renaming.
//
// One Append is one record is one fdatasync: collect what arrived together into one payload.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "coordinator/run_directory/durable_file.h"

namespace knap {

class Journal {
 public:
  // Creates the file, which must not exist, with its header. config_hash: any bytes that identify the configuration.
  static Journal Create(const std::filesystem::path& path, std::string_view config_hash);

  struct Opened;
  // Opens for reading and further appending. Throws std::runtime_error with one line that names the file and, for
  // corruption, the offset: not a journal, another configuration, corrupted, or in use by another process.
  static Opened Open(const std::filesystem::path& path, std::string_view config_hash);

  // The payloads of all whole records of any journal, whoever uses it; touches nothing. Throws as Open does.
  static std::vector<std::string> ReadPayloads(const std::filesystem::path& path);

  // The payload is durable when this returns. If it throws (std::system_error: disk full, …) the journal takes no more.
  void Append(std::string_view payload);

 private:
  Journal(DurableFile file, std::uint64_t next_sequence);

  DurableFile file_;
  std::uint64_t next_sequence_;
  bool failed_ = false;
};

struct Journal::Opened {
  Journal journal;
  std::vector<std::string> payloads;  // of all whole records behind the header, in order
  std::uint64_t torn_bytes = 0;       // cut off at the end
};

}  // namespace knap
