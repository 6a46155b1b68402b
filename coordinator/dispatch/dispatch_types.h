// What goes into the dispatcher and comes out of it, apart from queries and outcomes: options, counters, reports,
// and the ways in which a run can fail to get its answers.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "coordinator/rollout_service.h"
#include "lcmtypes/wire/codec.h"
#include "lcmtypes/wire/content_id.h"
#include "lcmtypes/wire/engine_identity.h"

namespace knap {

struct DispatchOptions {
  std::int64_t run_id = 0;            // a nonce of this run's; not 0
  EngineIdentity engine;              // workers with another one get no work
  std::size_t control_size = 0;       // of every theta: its last values are controls or weights, the others design
  int credits = 2;                    // least number of requests that one worker may hold, 1 to kMaxQueue: one runs,
                                      // one waits; more when they are short (batch_pace.h)
  double lease_s = 1.0;               // a worker silent for so long is believed gone; it sends its status at 4 Hz
  double stall_s = 120.0;             // a worker without any progress for so long is believed stuck
  double no_worker_s = 30.0;          // so long without a worker while requests wait: NoWorkers
  std::size_t max_answers = 1 << 17;  // answers remembered for repeated queries; the oldest are forgotten
};

struct DispatchCounters {
  std::int64_t requested = 0;     // queries given to Evaluate
  std::int64_t remembered = 0;    // of these: answered from memory, or equal to another one of the same call
  std::int64_t computed = 0;      // answers accepted from workers
  std::int64_t untrusted = 0;     // of those: failed, or not to be trusted
  std::int64_t flagged = 0;       // of those: with a gradient that may not be that of the problem
  std::int64_t reissued = 0;      // requests given to another worker because the first was lost or stuck
  std::int64_t moved = 0;         // requests taken from a busy worker's queue for one that had nothing to do
  std::int64_t copied = 0;        // second copies of stragglers given to idle workers
  std::int64_t resent = 0;        // requests sent again to the same worker because it had not got them
  std::int64_t duplicates = 0;    // answers to requests that had one already
  std::int64_t late = 0;          // answers that nobody waits for any more
  std::int64_t workers_lost = 0;  // workers that fell silent or died
  std::int64_t workers_stalled = 0;
  std::int64_t workers_lacking = 0;  // workers that left because they lacked something
  std::int64_t other_protocol = 0;   // status messages of workers that speak another protocol version
  std::int64_t other_engine = 0;     // status messages of workers with another engine
  std::int64_t workers_refused = 0;  // workers with the run's engine, but another build or other bits
  std::int64_t other_run = 0;        // answers that belong to another run
  RefusalCounters refused;           // messages that are not what they should be
};

inline std::int64_t ToMicroseconds(double seconds) { return static_cast<std::int64_t>(std::llround(seconds * 1e6)); }

// One accepted answer, for rollouts.csv and the journal.
struct RolloutReport {
  ContentId id{};
  const RolloutQuery* query = nullptr;      // valid during the call alone
  const RolloutOutcome* outcome = nullptr;  // valid during the call alone
  std::string worker;
  std::int32_t attempt = 0;  // of the computation that gave this answer
  double waited_s = 0.0;     // from Evaluate to the answer
  // From when the worker was given it to its answer; NaN when it had been taken back, and the answer came all the same.
  double held_s = std::numeric_limits<double>::quiet_NaN();
  double compute_s = 0.0;  // as the worker measured it
};

// What is out of the ordinary, and why requests are given or sent again.
enum class TroubleKind {
  // A worker is gone, and what it held goes to others.
  kDied,       // its process ended, killed or by itself
  kFaulted,    // its process ended by a fault signal
  kSilent,     // nothing was heard of it for a lease
  kStopping,   // it said goodbye
  kLacking,    // the same, because it lacked something
  kStuck,      // it made no progress
  kElsewhere,  // it does not work for this run any more
  // A worker keeps what it holds.
  kStraggler,    // another one, which was idle, got a second copy
  kMessageLost,  // its status does not list it, and it is sent again
  // The call has failed, or was interrupted: nobody waits for the answers any more.
  kDropped,
};

// "died", "faulted", …, as events.jsonl has it.
const char* GetName(TroubleKind kind);

struct RequestTrouble {
  struct Held {
    ContentId id{};
    std::int32_t attempt = 0;  // which of the times it was given to a worker, from 1; 0: it never was
    double held_s = 0.0;       // since then; 0 while it waits
  };
  TroubleKind kind = TroubleKind::kDied;
  std::string worker{};           // who holds, or held, the requests; empty for those that waited in the queue
  std::string host{};             // its host
  std::vector<Held> requests{};   // oldest first; a worker that is gone may have held none
  std::string helper{};           // of kStraggler: who got the copy
  std::int32_t copy_attempt = 0;  // of kStraggler: which of the times this is
};

// How the run goes, for run_status_t; the schedule fills it, the dispatcher adds the cluster's figures and sends it.
struct RunProgress {
  std::int32_t state = 0;  // run_status_t::kWaiting, kLearning, kEvaluating, kDone
  double progress = 0.0;
  double loss = std::numeric_limits<double>::quiet_NaN();  // until there is one
  double grad_norm = 0.0;
  double best_loss = std::numeric_limits<double>::quiet_NaN();
  double radius = 0.0;
  double eta_s = -1.0;
  std::int32_t iteration = 0;
  std::int32_t batch = 0;
  std::int32_t batch_count = 0;
  std::vector<double> theta;
  std::string scenario;
  std::string method;
};

// No worker came, or all were lost, for DispatchOptions::no_worker_s. The command line exits with 4.
class NoWorkers : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

// The stop flag was set while waiting. The command line exits with 130.
class Interrupted : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

}  // namespace knap
