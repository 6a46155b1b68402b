#include "coordinator/dispatch/dispatcher.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "lcmtypes/wire/channels.h"
#include "lcmtypes/wire/scenario_bundle.h"

namespace knap {
namespace {

constexpr std::int64_t kTurnUs = 20'000;          // longest wait for a message: hooks and leases come in between
constexpr std::int64_t kPumpIntervalUs = 50'000;  // of the on_pump hook
constexpr std::int64_t kPauseUs = 400'000;        // not listening for longer than this is a pause, not a worker's fault
constexpr std::int64_t kLostUs = 100'000;         // a request sent earlier than this and not in the status is lost
constexpr std::int64_t kForgetUs = 60'000'000;    // a worker silent for so long is like a new one if it comes again
constexpr std::int64_t kCommitUs = 50'000;        // longest wait for more answers to commit; workers repeat after 200 ms
constexpr std::size_t kMostOwed = 64;             // a crash costs no more answers than this
constexpr std::int64_t kStopRetryUs = 100'000;
constexpr int kMessagesPerTurn = 4096;
constexpr std::int32_t kMaxFatalAttempts = 3;
constexpr std::size_t kMaxStalls = 3;

std::int64_t ToMicroseconds(double seconds) { return static_cast<std::int64_t>(std::llround(seconds * 1e6)); }

void CheckRange(const char* name, double value, double lower, double upper) {
  if (value >= lower && value <= upper) return;
  throw std::invalid_argument(fmt::format("dispatch option {} is {}; {} to {} is allowed", name, value, lower, upper));
}

DispatchOptions Validate(DispatchOptions options) {
  CheckRange("credits", options.credits, 1, kMaxQueue);
  CheckRange("lease_s", options.lease_s, 0.5, 1e6);
  CheckRange("stall_s", options.stall_s, 0.5, 1e6);
  CheckRange("no_worker_s", options.no_worker_s, 0.0, 1e9);
  if (options.run_id == 0) throw std::invalid_argument("dispatch option run_id is 0; any other number is allowed");
  if (!IsName(options.engine)) {
    throw std::invalid_argument(fmt::format("dispatch option engine is '{}'; a name is allowed", options.engine));
  }
  return options;
}

template <typename T>
void EraseValue(std::vector<T>* values, const T& value) {
  values->erase(std::remove(values->begin(), values->end(), value), values->end());
}

}  // namespace

std::vector<std::string> Dispatcher::ListChannels() {
  return {std::string(kResultChannel), std::string(kWorkerStatusChannel), std::string(kControlChannel)};
}

Dispatcher::Dispatcher(DispatchOptions options, const RunKey& key, const std::map<std::string, std::string>& scenario,
                       Transport* transport, const Clock* clock)
    : options_(Validate(std::move(options))),
      key_(key),
      transport_(transport),
      clock_(clock),
      sender_(options_.run_id, key, transport, clock),
      started_us_(clock->now_us()),
      scenario_server_(EncodeBundle(scenario)),
      answers_(options_.max_answers) {}

ContentId Dispatcher::CalcId(const RolloutQuery& query) const {
  return CalcRequestId(
      {options_.engine, scenario(), query.theta, query.theta_reference, query.variation, query.gradient});
}

std::vector<RolloutOutcome> Dispatcher::Evaluate(std::span<const RolloutQuery> queries) {
  std::vector<RolloutOutcome> outcomes(queries.size());
  const std::int64_t now_us = clock_->now_us();
  for (std::size_t i = 0; i < queries.size(); ++i) {
    ++counters_.requested;
    const ContentId id = CalcId(queries[i]);
    if (const AnswerCache::Answer* known = answers_.Find(id)) {
      ++counters_.remembered;
      outcomes[i] = known->outcome;
      continue;
    }
    const auto [request, is_new] = open_.try_emplace(id);
    request->second.slots.push_back(&outcomes[i]);
    if (!is_new) {
      ++counters_.remembered;
      continue;
    }
    request->second.query = queries[i];
    request->second.opened_us = now_us;
    waiting_.push_back(id);
  }
  usable_us_ = now_us;
  try {
    while (!open_.empty()) Turn(kTurnUs);
  } catch (...) {
    CancelAll();
    throw;
  }
  return outcomes;
}

void Dispatcher::Pump(double wait_s) {
  const std::int64_t end_us = clock_->now_us() + ToMicroseconds(wait_s);
  do {
    Turn(std::clamp<std::int64_t>(end_us - clock_->now_us(), 0, kTurnUs));
  } while (clock_->now_us() < end_us);
}

void Dispatcher::StopWorkers(double timeout_s) {
  stopping_ = true;
  const std::int64_t end_us = clock_->now_us() + ToMicroseconds(timeout_s);
  std::int64_t send_us = clock_->now_us();
  const auto has_workers = [this] {
    return std::any_of(roster_.workers().begin(), roster_.workers().end(), [this](const auto& entry) {
      return entry.second.run_id == options_.run_id && !entry.second.silent;
    });
  };
  PublishRunStatus();
  while (has_workers() && clock_->now_us() < end_us) {
    if (clock_->now_us() >= send_us) {
      for (const auto& [instance, worker] : roster_.workers()) {
        if (worker.run_id == options_.run_id) SendControl(control_t::kStop, worker, {});
      }
      send_us = clock_->now_us() + kStopRetryUs;
    }
    std::optional<Message> message = transport_->Receive(kTurnUs);
    for (; message; message = transport_->Receive(0)) Handle(*message);
    CommitIfDue(clock_->now_us());
    FlushControls();
    CheckLeases(clock_->now_us());
  }
  stopping_ = false;
  if (failure_) throw std::runtime_error(*std::exchange(failure_, std::nullopt));
}

void Dispatcher::Preload(const ContentId& id, RolloutOutcome outcome) { answers_.Insert(id, {std::move(outcome), ""}); }

void Dispatcher::Turn(std::int64_t wait_us) {
  const std::int64_t begin_us = clock_->now_us();
  if (begin_us - turn_ended_us_ > kPauseUs) listening_since_us_ = begin_us;

  AssignWaiting();
  FlushControls();
  int handled = 0;
  std::optional<Message> message = transport_->Receive(wait_us);
  for (; message; message = transport_->Receive(0)) {
    Handle(*message);
    if (++handled == kMessagesPerTurn) break;
  }
  const std::int64_t now_us = clock_->now_us();
  if (handled < kMessagesPerTurn) CheckLeases(now_us);  // only when no sign of life lies unread
  CommitIfDue(now_us);
  AssignWaiting();
  FlushControls();
  CheckForWorkers(now_us);
  if (now_us >= status_due_us_) PublishRunStatus();
  turn_ended_us_ = now_us;
  if (on_pump_ && now_us >= pump_due_us_) {
    pump_due_us_ = now_us + kPumpIntervalUs;
    on_pump_();
  }
  if (failure_) throw std::runtime_error(*std::exchange(failure_, std::nullopt));
  if (stop_flag_ != nullptr && *stop_flag_) throw Interrupted("interrupted");
}

void Dispatcher::Handle(const Message& message) {
  if (message.channel == kWorkerStatusChannel) {
    if (const auto status = Open<worker_status_t>(message.bytes, key_, &counters_.refused)) {
      HandleStatus(*status, message.arrival_us);
    }
  } else if (message.channel == kResultChannel) {
    if (const auto result = Open<rollout_result_t>(message.bytes, key_, &counters_.refused)) {
      HandleResult(*result, message.arrival_us);
    }
  } else if (message.channel == kControlChannel) {
    if (const auto control = Open<control_t>(message.bytes, key_, &counters_.refused)) HandleControl(*control);
  }
}

void Dispatcher::HandleStatus(const worker_status_t& status, std::int64_t arrival_us) {
  if (status.protocol != kProtocolVersion) {
    ++counters_.other_protocol;
    return;
  }
  if (status.engine != options_.engine) {
    ++counters_.other_engine;
    return;
  }
  if (!IsName(status.name) || status.sender == 0) {
    ++counters_.refused.malformed;
    return;
  }
  KnownWorker* worker = roster_.Update(status, arrival_us);
  if (worker == nullptr) return;
  if (status.state == worker_status_t::kStopping) {
    Release(worker);
    roster_.Remove(worker->instance);
    return;
  }
  if (worker->run_id != options_.run_id) {
    Release(worker);  // it has forgotten what it was given
    if (!stopping_) SendControl(control_t::kJoin, *worker, {});
    return;
  }
  const std::vector<ContentId> queue = ParseIds(status.queue);
  for (const ContentId& id : queue) {
    if (open_.count(id) == 0 && id != worker->running) worker->unsent_cancellations.push_back(id);
  }
  for (const ContentId& id : std::vector<ContentId>(worker->assigned)) {
    OpenRequest& request = open_.at(id);
    const bool has_it = std::find(queue.begin(), queue.end(), id) != queue.end();
    if (has_it || arrival_us - request.sent_us[worker->instance] < kLostUs) continue;
    // Either the request was lost or its answer: a worker that has the answer repeats it.
    ++counters_.resent;
    SendRequest(id, &request, worker);
  }
}

void Dispatcher::HandleControl(const control_t& control) {
  if (control.kind != control_t::kWantScenario || control.receiver != options_.run_id) return;
  for (scenario_t& piece : scenario_server_.MakePieces(control, clock_->now_us())) {
    sender_.Publish(kScenarioChannel, options_.run_id, std::move(piece));
  }
}

void Dispatcher::HandleResult(const rollout_result_t& result, std::int64_t arrival_us) {
  if (result.run_id != options_.run_id) {
    ++counters_.other_run;
    return;
  }
  KnownWorker* worker = roster_.Find(result.sender);
  const ContentId id = MakeId(result.id);
  if (worker != nullptr) {
    worker->heard_us = arrival_us;
    worker->silent = false;
    worker->last_sequence = std::max(worker->last_sequence, result.sequence);  // statuses from before are outdated
    const auto& assigned = worker->assigned;
    // A worker repeats old answers while it is stuck: only a new one is progress.
    if (worker->running == id || std::find(assigned.begin(), assigned.end(), id) != assigned.end()) {
      worker->stalled = false;
      worker->progress_us = arrival_us;
    }
    if (worker->running == id) worker->running = ContentId{};
  }
  const auto open = open_.find(id);
  if (open == open_.end()) {
    if (const AnswerCache::Answer* known = answers_.Find(id)) {
      CompareWithKnown(result, *known);
    } else {
      ++counters_.late;
    }
    Owe(id, result);
    return;
  }
  const RolloutQuery& query = open->second.query;
  const bool has_gradient = query.gradient && result.status == rollout_result_t::kOk;
  if (static_cast<std::size_t>(result.gradient_size) != (has_gradient ? query.theta.size() : 0)) {
    Fail(fmt::format("worker {}: request {}: an answer with a gradient of {} values to a question about {} parameters",
                     result.worker, FormatHex(id), result.gradient_size, has_gradient ? query.theta.size() : 0));
    return;
  }
  std::vector<PartialAnswer>& partial = open->second.partial;
  auto part =
      std::find_if(partial.begin(), partial.end(), [&](const PartialAnswer& p) { return p.worker == result.sender; });
  if (part == partial.end()) {
    partial.push_back({result.sender, ValueAssembly(result.gradient_size)});
    part = partial.end() - 1;
  }
  if (!part->gradient.Add(result.gradient_size, result.first_value, result.values)) {
    ++counters_.refused.malformed;
  } else if (part->gradient.IsComplete()) {
    Accept(id, result, std::vector<double>(part->gradient.values()));
  }
}

void Dispatcher::CompareWithKnown(const rollout_result_t& result, const AnswerCache::Answer& known) {
  ++counters_.duplicates;
  const std::string difference = result.status == rollout_result_t::kOk
                                     ? DescribeDifference(result, known.outcome)
                                     : fmt::format("it fails with '{}'", result.error);
  if (difference.empty()) return;
  Fail(fmt::format("workers disagree on request {}: worker {} against {}: {}", FormatHex(MakeId(result.id)),
                   result.worker, known.worker.empty() ? "the journal" : "worker " + known.worker, difference));
}

void Dispatcher::Accept(const ContentId& id, const rollout_result_t& result, const std::vector<double>& gradient) {
  auto node = open_.extract(id);
  OpenRequest& request = node.mapped();
  for (const std::int64_t instance : request.assigned_to) {
    KnownWorker* holder = roster_.Find(instance);
    if (holder == nullptr) continue;
    EraseValue(&holder->assigned, id);
    holder->alone = holder->alone && !holder->assigned.empty();
    if (instance != result.sender) holder->unsent_cancellations.push_back(id);
  }
  if (result.status != rollout_result_t::kOk) {
    Fail(fmt::format("worker {}: {}", result.worker, result.error));
    return;
  }
  AnswerCache::Answer answer{MakeOutcome(result, gradient), result.worker};
  ++counters_.computed;
  if (on_result_) {
    RolloutReport report;
    report.id = id;
    report.query = &request.query;
    report.outcome = &answer.outcome;
    report.worker = result.worker;
    report.attempt = result.attempt;
    report.waited_s = static_cast<double>(clock_->now_us() - request.opened_us) * 1e-6;
    report.compute_s = result.compute_s;
    on_result_(report);
  }
  for (RolloutOutcome* slot : request.slots) *slot = answer.outcome;
  answers_.Insert(id, std::move(answer));
  Owe(id, result);
}

void Dispatcher::Owe(const ContentId& id, const rollout_result_t& result) {
  if (owed_.empty()) owed_since_us_ = clock_->now_us();
  owed_.push_back({id, result.sender, result.worker});
}

void Dispatcher::CommitIfDue(std::int64_t now_us) {
  if (owed_.empty()) return;
  if (open_.empty() || owed_.size() >= kMostOwed || now_us - owed_since_us_ >= kCommitUs) Commit();
}

void Dispatcher::Commit() {
  if (on_commit_) on_commit_();
  for (const OwedAcknowledgement& owed : std::exchange(owed_, {})) {
    if (KnownWorker* worker = roster_.Find(owed.instance)) {
      worker->unsent_acknowledgements.push_back(owed.id);
    } else if (IsName(owed.worker)) {
      KnownWorker stranger;
      stranger.name = owed.worker;
      stranger.instance = owed.instance;
      SendControl(control_t::kAcknowledge, stranger, {&owed.id, 1});
    }
  }
}

void Dispatcher::CheckLeases(std::int64_t now_us) {
  std::erase_if(roster_.workers(),
                [&](const auto& entry) { return entry.second.silent && now_us - entry.second.heard_us > kForgetUs; });
  const std::int64_t lease_us = ToMicroseconds(options_.lease_s);
  const std::int64_t stall_us = ToMicroseconds(options_.stall_s);
  for (auto& [instance, worker] : roster_.workers()) {
    if (!worker.silent && now_us - std::max(worker.heard_us, listening_since_us_) > lease_us) {
      worker.silent = true;
      ++counters_.workers_lost;
      Release(&worker);
    }
    if (worker.CountOccupying() == 0 || worker.silent || worker.stalled) continue;  // the dead are not stuck
    if (now_us - std::max(worker.progress_us, listening_since_us_) <= stall_us) continue;
    worker.stalled = true;
    ++counters_.workers_stalled;
    const ContentId stuck = worker.running == ContentId{} ? worker.assigned.front() : worker.running;
    const auto request = open_.find(stuck);
    if (request != open_.end() && request->second.stalled_on.insert(instance).second &&
        request->second.stalled_on.size() >= kMaxStalls) {
      Fail(fmt::format("request {} made no progress for {} s on {} workers", FormatHex(stuck), options_.stall_s,
                       kMaxStalls));
    }
    Release(&worker);
    if (on_stalled_) on_stalled_(worker);
  }
}

void Dispatcher::CheckForWorkers(std::int64_t now_us) {
  if (open_.empty() || CountUsableWorkers() > 0) {
    usable_us_ = now_us;
  } else if (now_us - std::max(usable_us_, listening_since_us_) > ToMicroseconds(options_.no_worker_s)) {
    throw NoWorkers(fmt::format("no worker for {} s ({} requests wait)", options_.no_worker_s, open_.size()));
  }
}

void Dispatcher::ReportDeath(const std::string& worker_name, std::int32_t pid, DeathCause cause) {
  KnownWorker* worker = roster_.FindProcess(worker_name, pid);
  if (worker == nullptr) return;
  if (cause == DeathCause::kFault) {
    for (const ContentId& id : worker->assigned) {
      OpenRequest& request = open_.at(id);
      request.suspect = true;
      // Among several the culprit is not known: from now on each of them runs alone.
      if (worker->assigned.size() > 1 && id != worker->running) continue;
      if (++request.fatal_attempts >= kMaxFatalAttempts) {
        Fail(fmt::format("request {} is poison: {} workers crashed while they computed it", FormatHex(id),
                         kMaxFatalAttempts));
      }
    }
  }
  if (!worker->silent) ++counters_.workers_lost;
  Release(worker);
  roster_.Remove(worker->instance);
}

void Dispatcher::Release(KnownWorker* worker) {
  // Backwards, so that at the front of waiting_ they keep their order.
  while (!worker->assigned.empty()) Unassign(ContentId(worker->assigned.back()), worker);
  worker->unsent_acknowledgements.clear();
  worker->unsent_cancellations.clear();
}

void Dispatcher::Unassign(const ContentId& id, KnownWorker* worker) {
  EraseValue(&worker->assigned, id);
  worker->alone = worker->alone && !worker->assigned.empty();
  OpenRequest& request = open_.at(id);
  EraseValue(&request.assigned_to, worker->instance);
  request.sent_us.erase(worker->instance);
  if (request.assigned_to.empty() && !request.waiting) {
    request.waiting = true;
    waiting_.push_front(id);
  }
}

void Dispatcher::CancelAll() {
  for (auto& [instance, worker] : roster_.workers()) {
    for (const ContentId& id : worker.assigned) worker.unsent_cancellations.push_back(id);
    worker.assigned.clear();
    worker.alone = false;
  }
  open_.clear();
  waiting_.clear();
  failure_.reset();
  FlushControls();
}

int Dispatcher::CountUsableWorkers() const {
  return static_cast<int>(std::count_if(roster_.workers().begin(), roster_.workers().end(),
                                        [this](const auto& entry) { return IsUsable(entry.second); }));
}

bool Dispatcher::IsUsable(const KnownWorker& worker) const {
  return worker.run_id == options_.run_id && !worker.silent && !worker.stalled;
}

void Dispatcher::Fail(const std::string& what) {
  if (!failure_) failure_ = what;
}

}  // namespace knap
