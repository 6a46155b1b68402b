// One life of a run under faults, all of it decided by a seed: the real learning, journal, dispatcher and worker
// reactors over a simulated clock, network and disk, with a closed-form engine.
//
// The network drops, duplicates, delays, reorders and damages messages. Workers crash (from outside or inside), freeze,
// hang in a computation, are slow, come late, lack memory, or compute other bits and say so; the network falls silent
// for a while, or is cut in one direction between the coordinator and one worker; the coordinator freezes, and it dies:
// at an arbitrary message sent or disk operation done, with what it had not synced lost in part, or because its journal
// cannot be read. Another life resumes from its disk. After kFaultsEnd_s no new fault happens. Then the run must end,
// and with the reference's bits.
//
// Checked after every event of the simulation and with every message that the coordinator sends or asks for: its book
// of requests agrees with itself (tests/coordinator/request_book.h); who holds a request is a worker that it believes
// able to work; a dead worker's requests are taken back in time; an answer that was acknowledged to a worker is in a
// synced record of the journal, and stays there.
#pragma once

#include <cstdint>
#include <string>

#include "coordinator/dispatch/dispatch_types.h"

namespace knap {

// Defects that the simulator must find.
enum class PlantedDefect {
  kNone,
  kAcknowledgesBeforeJournal,  // answers are acknowledged although nothing was written yet
  kSyncDoesNothing,            // the journal's writes are never forced to the disk
  kIgnoresDigests,             // the coordinator believes every message whatever its digest
  kNoStepProgress,             // a heartbeat is enough to keep a lease
  kLeasesNeverExpire,          // silent workers keep what they hold
  kReadsAreShort,              // a journal that cannot be read to its end passes for a shorter one
};

struct SimulationReport {
  std::string failure;  // why the run did not end as it must; empty when it did
  // What happened, over all lives of the coordinator.
  int lives = 0;
  int worker_crashes = 0, hangs = 0, freezes = 0, silences = 0, cuts = 0, lacks = 0, failed_reads = 0;
  std::int64_t checks = 0;  // of the invariants
  std::int64_t torn_bytes = 0;
  std::int64_t messages = 0;
  double simulated_s = 0.0;
  DispatchCounters counters;
};

SimulationReport RunSimulation(std::uint64_t seed, PlantedDefect defect);

}  // namespace knap
