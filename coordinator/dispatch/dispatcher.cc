#include "coordinator/dispatch/dispatcher.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "lcmtypes/wire/channels.h"
#include "lcmtypes/wire/scenario_bundle.h"

namespace knap {
namespace {

constexpr std::int64_t kTurnUs = 20'000;          // longest wait for a message: hooks and leases come in between
constexpr std::int64_t kPumpIntervalUs = 50'000;  // of the on_pump hook
constexpr std::int64_t kPauseUs = 400'000;        // not listening for longer than this is a pause, not a worker's fault
constexpr std::int64_t kCommitUs = 50'000;  // longest wait for more answers to commit; workers repeat after 200 ms
constexpr std::size_t kMostOwed = 64;       // a crash costs no more answers than this
constexpr std::int64_t kStopRetryUs = 100'000;
constexpr int kMessagesPerTurn = 4096;

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
  if (!IsName(options.engine.name)) {
    throw std::invalid_argument(fmt::format("dispatch option engine is '{}'; a name is allowed", options.engine.name));
  }
  return options;
}

}  // namespace

const char* GetName(TroubleKind kind) {
  switch (kind) {
    case TroubleKind::kDied:
      return "died";
    case TroubleKind::kFaulted:
      return "faulted";
    case TroubleKind::kSilent:
      return "silent";
    case TroubleKind::kStopping:
      return "stopping";
    case TroubleKind::kLacking:
      return "lacking";
    case TroubleKind::kStuck:
      return "stuck";
    case TroubleKind::kElsewhere:
      return "elsewhere";
    case TroubleKind::kStraggler:
      return "straggler";
    case TroubleKind::kMessageLost:
      return "message_lost";
    case TroubleKind::kDropped:
      return "dropped";
  }
  return "";
}

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
  const std::span<const double> theta = query.theta;
  if (theta.size() < options_.control_size) {
    throw std::invalid_argument(
        fmt::format("a query of {} values; {} of them should be controls", theta.size(), options_.control_size));
  }
  const std::size_t design_size = theta.size() - options_.control_size;
  return CalcRequestId({options_.engine.name, scenario(), theta.first(design_size), theta.subspan(design_size),
                        query.theta_reference, query.variation, query.gradient, query.theta_nodes});
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
    if (!requests_.Ask(id, queries[i], &outcomes[i], now_us)) ++counters_.remembered;
  }
  usable_us_ = now_us;
  pace_.Begin(requests_.open());
  try {
    while (requests_.open() > 0) Turn(kTurnUs);
    if (!requests_.book().owed.empty()) Commit();  // of an earlier call that failed
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
    const bool all_read = HandleMessages(kTurnUs);
    CommitIfDue(clock_->now_us());
    FlushMessages();
    if (all_read) CheckLeases(clock_->now_us());
  }
  stopping_ = false;
  if (failure_) throw std::runtime_error(*std::exchange(failure_, std::nullopt));
}

bool Dispatcher::HandleMessages(std::int64_t wait_us) {
  int handled = 0;
  std::optional<Message> message = transport_->Receive(wait_us);
  for (; message; message = transport_->Receive(0)) {
    Handle(*message);
    if (++handled == kMessagesPerTurn) return false;
  }
  return true;
}

void Dispatcher::Turn(std::int64_t wait_us) {
  const std::int64_t begin_us = clock_->now_us();
  if (begin_us - turn_ended_us_ > kPauseUs) listening_since_us_ = begin_us;

  AssignWaiting();
  FlushMessages();
  const bool all_read = HandleMessages(wait_us);
  const std::int64_t now_us = clock_->now_us();
  if (all_read) CheckLeases(now_us);  // only when no sign of life lies unread
  CommitIfDue(now_us);
  AssignWaiting();
  FlushMessages();
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

void Dispatcher::Owe(const ContentId& id, const rollout_result_t& result) {
  if (requests_.book().owed.empty()) owed_since_us_ = clock_->now_us();
  requests_.Owe({id, result.sender, result.worker});
}

void Dispatcher::CommitIfDue(std::int64_t now_us) {
  const std::size_t owed = requests_.book().owed.size();
  if (owed == 0) return;
  if (requests_.open() == 0 || owed >= kMostOwed || now_us - owed_since_us_ >= kCommitUs) Commit();
}

void Dispatcher::Commit() {
  if (on_commit_) on_commit_();
  for (const OwedAcknowledgement& owed : requests_.TakeOwed()) {
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
