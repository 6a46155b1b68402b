// The worker's side of the protocol (docs/protocol.md) as a state machine: messages and time go in, messages come out.
//
// A worker is free until a coordinator invites it (kJoin); then it takes requests of that run alone, until the run says
// stop or falls silent and another one invites it. Requests run one after the other in the order they came. Answers
// are kept and sent again until acknowledged; a request that is running or waiting already is not taken twice, one that
// is answered already is answered from memory.
//
// Not thread-safe; blocks in Turn alone. Drive it like this:
//   while (!reactor.stopped()) reactor.Turn(longest_wait_us);
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "lcmtypes/wire/clock.h"
#include "lcmtypes/wire/codec.h"
#include "lcmtypes/wire/content_id.h"
#include "lcmtypes/wire/engine_identity.h"
#include "lcmtypes/wire/sender.h"
#include "lcmtypes/wire/transport.h"
#include "lcmtypes/wire/value_parts.h"
#include "worker/executor.h"
#include "worker/result_store.h"
#include "worker/scenario_fetch.h"

namespace knap {

struct WorkerIdentity {
  std::string name;           // IsName
  std::int64_t instance = 0;  // random, new with every start; not 0
  EngineIdentity engine;
  std::string host;
  std::int32_t pid = 0;
};

class WorkerReactor {
 public:
  // What a transport for a worker of this name must hear.
  static std::vector<std::string> ListChannels(const std::string& name);

  // Transport, clock and executor must outlive the reactor.
  WorkerReactor(WorkerIdentity identity, const RunKey& key, Transport* transport, const Clock* clock,
                Executor* executor);

  // Waits for a message, at most so long and not beyond next_deadline_us, handles what has come, and does what is due.
  // However many messages come, the status goes on: some milliseconds' work of them is handled in one turn.
  void Turn(std::int64_t longest_wait_us);

  // The parts of a turn, for who waits by other means.
  void Handle(const Message& message);
  // Does all that is due now: takes a finished answer, starts the next job, sends status and repeats.
  void Tick();

  // The instant at which Tick has something to do even if no message comes and no job ends.
  std::int64_t next_deadline_us() const;

  // Tells the coordinator that this worker leaves: its requests go elsewhere at once. `lack`: what it lacks, when that
  // is why; what it computes is then not given to it, nor to another worker of its name, again.
  void SayGoodbye(const std::string& lack = "");

  // Its run said stop, or it lacked something for a computation and has said so.
  bool stopped() const { return stopped_; }
  const std::string& lack() const { return lack_; }  // empty: its run said stop
  std::int64_t run_id() const { return run_id_; }
  const RefusalCounters& refusals() const { return refusals_; }

 private:
  struct Job {
    ContentId id{};
    ContentId scenario{};
    std::int32_t attempt = 0;
    EngineRequest request;
  };

  void HandleRequest(const rollout_request_t& request);
  void HandleAssignment(const assignment_t& assignment, const ContentId& scenario, std::int64_t sequence);
  void HandleControl(const control_t& control);
  void Join(const control_t& control);
  void Cancel(const ContentId& id, std::int64_t sequence);
  void TakeRequest(const assignment_t& head, const ContentId& scenario, const std::vector<double>& values);
  void ErasePartial(const ContentId& id);
  bool IsQueued(const ContentId& id) const;

  void FinishJob(const EngineAnswer& answer);
  void StartNextJob();
  void FetchScenario();
  std::optional<ContentId> FindMissingScenario() const;
  void PublishResult(ResultStore::Entry* entry);
  void PublishStatus(std::int32_t state, const std::string& reason = "");
  std::int32_t CalcState() const;

  const WorkerIdentity identity_;
  const RunKey key_;
  Transport* const transport_;
  const Clock* const clock_;
  Executor* const executor_;
  Sender sender_;

  std::int64_t run_id_ = 0;        // 0: free
  std::int64_t run_heard_us_ = 0;  // when the run last gave a sign of life
  bool stopped_ = false;
  std::string lack_;

  std::deque<Job> queue_;  // taken and not answered; the first one runs when `running_`
  bool running_ = false;   // a request, not a mere loading
  std::int64_t job_started_us_ = 0;
  std::unordered_map<ContentId, ValueAssembly, ContentIdHash> partial_;  // requests of which parts are missing
  std::deque<ContentId> partial_order_;
  std::unordered_map<ContentId, std::int64_t, ContentIdHash> cancelled_;  // id → sequence of the cancellation
  std::deque<ContentId> cancelled_order_;
  ResultStore results_;

  std::optional<ContentId> run_scenario_;  // announced by the run: fetched and loaded before the first request
  std::map<ContentId, std::shared_ptr<const std::string>> bundles_;
  std::deque<ContentId> bundle_order_;
  std::optional<ScenarioFetch> fetch_;
  std::optional<ContentId> started_scenario_;  // of the last job: loaded, or being loaded

  std::int64_t status_sent_us_ = 0;
  std::int64_t status_due_us_ = 0;
  std::int64_t busy_us_ = 0;  // computing time since the last status, finished jobs
  double last_compute_s_ = 0.0;
  std::int64_t finished_ = 0;
  std::int64_t repeated_ = 0;
  RefusalCounters refusals_;
};

}  // namespace knap
