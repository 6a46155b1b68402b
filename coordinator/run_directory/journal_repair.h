// A damaged journal made usable again: what is whole in it is kept, and the rest is set aside.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "coordinator/run_directory/journal.h"

namespace knap {

struct JournalRepair {
  struct Stretch {
    std::uint64_t offset = 0, bytes = 0;
  };
  std::vector<std::string> payloads;   // of the records that were kept, in order
  bool changed = false;                // otherwise nothing was wrong, and the file is as it was
  bool header_lost = false;            // then it was written again
  std::vector<Stretch> damaged;        // what is no record
  std::vector<std::uint64_t> missing;  // numbers of records that are not there, up to the last one that is
  std::filesystem::path set_aside;     // the file with the bytes of all damaged stretches; empty when there are none
};

// Keeps every whole record of the journal at `path`, numbers them anew, and writes what lies between them into a new
// file beside it, journal.damaged or journal.damaged-2 and so on, before the journal is replaced in one step. A header
// that is damaged is made from `identity`. Throws std::runtime_error when another process uses the journal,
// std::system_error when the disk refuses; the journal is then as it was.
JournalRepair RepairJournal(const std::filesystem::path& path, const RunIdentity& identity);

}  // namespace knap
