// The coordinator's side of the protocol (docs/protocol.md): gives requests to workers, and gets every answer whatever
// the network loses and whichever workers die.
//
// A state machine over Transport and Clock. All functions belong to one thread; time passes only in Evaluate, Pump and
// StopWorkers, which block on the transport. A call to Evaluate or Pump after a long pause first reads what has come
// meanwhile, and judges nobody by the time in which it did not listen.
//
// Who computes an answer, how often and when, has no influence on it: answers are keyed by content, two answers to one
// request must agree bit for bit, and Evaluate returns them by the index of the query.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "coordinator/dispatch/answer_cache.h"
#include "coordinator/dispatch/batch_pace.h"
#include "coordinator/dispatch/dispatch_types.h"
#include "coordinator/dispatch/request_table.h"
#include "coordinator/dispatch/scenario_server.h"
#include "coordinator/dispatch/worker_roster.h"
#include "coordinator/rollout_service.h"
#include "knap/rollout_request_t.hpp"
#include "lcmtypes/wire/clock.h"
#include "lcmtypes/wire/codec.h"
#include "lcmtypes/wire/run_key.h"
#include "lcmtypes/wire/sender.h"
#include "lcmtypes/wire/transport.h"

namespace knap {

enum class DeathCause {
  kFault,    // a fault signal from inside: SIGSEGV, SIGABRT, ...
  kOutside,  // anything else: killed, or ended by itself
};

class Dispatcher : public RolloutService {
 public:
  // What a transport for a dispatcher must hear.
  static std::vector<std::string> ListChannels();

  // `scenario`: file name → bytes, see scenario_bundle.h. Transport and clock must outlive the dispatcher. Throws
  // std::invalid_argument for options out of range, std::runtime_error for a scenario too large to travel.
  Dispatcher(DispatchOptions options, const RunKey& key, const std::map<std::string, std::string>& scenario,
             Transport* transport, const Clock* clock);

  // Answers queries[i] in outcome[i]. Equal queries, in one call or over the dispatcher's life, are computed once.
  // Throws NoWorkers, Interrupted, or std::runtime_error with one line: an engine's error, a poison request, workers
  // that disagree; requests still open are then cancelled. Whatever the hooks throw passes through.
  std::vector<RolloutOutcome> Evaluate(std::span<const RolloutQuery> queries) override;

  // Handles what comes until `wait_s` has passed: lets workers join and load the scenario before the first Evaluate.
  void Pump(double wait_s);

  // Tells this run's workers to stop, again and again until all have said goodbye or `timeout_s` has passed.
  void StopWorkers(double timeout_s);

  // Throws std::invalid_argument for a query with fewer values than DispatchOptions::control_size.
  ContentId CalcId(const RolloutQuery& query) const;
  const ContentId& scenario() const { return scenario_server_.scenario(); }

  // Called with every accepted answer, as it comes.
  void set_on_result(std::function<void(const RolloutReport&)> hook) { on_result_ = std::move(hook); }
  // Called before the answers reported since the last call are acknowledged to their workers, and before Evaluate
  // returns them: when it returns they must survive a crash. Many answers share one call.
  void set_on_commit(std::function<void()> hook) { on_commit_ = std::move(hook); }
  // Called about 20 times a second while waiting.
  void set_on_pump(std::function<void()> hook) { on_pump_ = std::move(hook); }
  // Called with a worker whose computation is stuck; whoever started it may kill it.
  void set_on_stalled(std::function<void(const KnownWorker&)> hook) { on_stalled_ = std::move(hook); }
  // Called with what is out of the ordinary, as it happens. It must not throw.
  void set_on_trouble(std::function<void(const RequestTrouble&)> hook) { on_trouble_ = std::move(hook); }
  // When the flag becomes true, the waiting call throws Interrupted. May be null; must outlive the dispatcher.
  void set_stop_flag(const std::atomic<bool>* flag) { stop_flag_ = flag; }

  // What the next run_status_t tells.
  void SetProgress(RunProgress progress) { progress_ = std::move(progress); }

  // A worker process of this machine has ended. Its requests go to others at once. One that was lost to faults
  // kMaxFatalAttempts times is poison: the waiting call throws, naming it.
  void ReportDeath(const std::string& worker, std::int32_t pid, DeathCause cause);

  const DispatchCounters& counters() const { return counters_; }
  const WorkerRoster& roster() const { return roster_; }
  int CountUsableWorkers() const;
  // By instance: name and host of workers that were refused, and why; the first 16 of them.
  const std::map<std::int64_t, std::string>& refused() const { return refused_; }
  // By instance: name and host of workers that left because they lacked something, and what; 16 of them.
  const std::map<std::int64_t, std::string>& lacking() const { return lacking_; }
  const RequestBook& requests() const { return requests_.book(); }

 private:
  void Turn(std::int64_t wait_us);
  // Waits for a message, at most so long, and handles what has come; false when there may be more.
  bool HandleMessages(std::int64_t wait_us);
  void Handle(const Message& message);
  bool Admit(const worker_status_t& status);
  void HandleStatus(const worker_status_t& status, std::int64_t arrival_us);
  void HandleControl(const control_t& control);
  void HandleResult(const rollout_result_t& result, std::int64_t arrival_us);
  void CompareWithKnown(const rollout_result_t& result, const AnswerCache::Answer& known);
  void Accept(const ContentId& id, const rollout_result_t& result, const std::vector<double>& gradient);
  void CancelAtOthers(const ContentId& id, const Request& request, std::int64_t sender);
  void Owe(const ContentId& id, const rollout_result_t& result);
  void CommitIfDue(std::int64_t now_us);
  void Commit();

  void CheckLeases(std::int64_t now_us);
  void CheckForWorkers(std::int64_t now_us);
  // What it holds goes back into the queue, and what it is to be sent is forgotten.
  void Release(KnownWorker* worker, TroubleKind why);
  RequestTrouble MakeTrouble(TroubleKind kind, const KnownWorker& worker, std::span<const ContentId> ids) const;
  void Tell(const RequestTrouble& trouble) const;
  void TellDropped() const;
  void NoteLack(const worker_status_t& status);
  bool HasAbleWorker(const Request& request) const;
  void CancelAll();

  void AssignWaiting();
  // Usable and able to compute it, holding least and less than this; may be null.
  KnownWorker* ChooseWorker(const Request& request, std::size_t limit);
  // Requests that occupy it: what it was given, and what it still computes although it was taken from it.
  std::size_t CountOccupying(const KnownWorker& worker) const;
  void NoteWork(KnownWorker* worker);  // it is about to be given a request
  // At the end of a batch, when nobody waits for a worker: those who have nothing to do get what waits behind another
  // one's running request (should that have begun it meanwhile, both answer), or else second copies of stragglers.
  void ServeIdleWorkers();
  void MoveTo(std::vector<KnownWorker*>* idle);
  KnownWorker* TakeIdle(std::vector<KnownWorker*>* idle, const Request& request) const;  // able to compute it, or null
  void CopyTo(std::vector<KnownWorker*>* idle);
  std::optional<ContentId> FindMovable(const KnownWorker& worker) const;  // what it holds and does not run
  void SendRequests(KnownWorker* worker);
  void SendControl(std::int32_t kind, const KnownWorker& worker, std::span<const ContentId> ids);
  void FlushMessages();
  void PublishRunStatus();
  bool IsUsable(const KnownWorker& worker) const;
  void Fail(const std::string& what);

  const DispatchOptions options_;
  const RunKey key_;
  Transport* const transport_;
  const Clock* const clock_;
  Sender sender_;
  const std::int64_t started_us_;
  ScenarioServer scenario_server_;
  WorkerRoster roster_;
  AnswerCache answers_;
  BatchPace pace_;

  RequestTable requests_;
  std::int64_t owed_since_us_ = 0;

  std::map<std::int64_t, std::string> refused_;
  std::map<std::int64_t, std::string> lacking_;

  std::int64_t turn_ended_us_ = 0;       // when we last listened
  std::int64_t listening_since_us_ = 0;  // without a long pause
  std::int64_t usable_us_ = 0;           // when there was a usable worker last, or waiting began
  std::int64_t status_due_us_ = 0;
  std::int64_t status_sent_us_ = 0;
  std::int64_t computed_at_status_ = 0;
  std::int64_t pump_due_us_ = 0;
  bool stopping_ = false;

  std::function<void(const RolloutReport&)> on_result_;
  std::function<void()> on_commit_;
  std::function<void()> on_pump_;
  std::function<void(const KnownWorker&)> on_stalled_;
  std::function<void(const RequestTrouble&)> on_trouble_;
  const std::atomic<bool>* stop_flag_ = nullptr;
  RunProgress progress_;
  DispatchCounters counters_;
  std::optional<std::string> failure_;  // the first reason to give up; thrown at the end of the turn
};

}  // namespace knap
