#include "worker/worker_reactor.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "lcmtypes/wire/channels.h"
#include "lcmtypes/wire/request_values.h"

namespace knap {
namespace {

constexpr std::int64_t kStatusIntervalUs = 250'000;
constexpr std::int64_t kResultRetryUs = 200'000;   // an answer not acknowledged is sent again
constexpr std::int64_t kFetchRetryUs = 100'000;    // scenario pieces that did not come are asked for again
constexpr std::int64_t kRunSilenceUs = 2'000'000;  // a run silent for so long may be left for another one
constexpr int kMessagesPerTurn = 256;
constexpr std::size_t kResultsPerRetry = 16;
constexpr std::size_t kMaxResults = 1024;
constexpr std::size_t kMaxPartial = 32;
constexpr std::size_t kMaxCancelled = 256;
constexpr std::size_t kMaxBundles = 2;

std::int32_t MakeFlag(bool b) { return b ? 1 : 0; }

}  // namespace

std::vector<std::string> WorkerReactor::ListChannels(const std::string& name) {
  return {MakeRequestChannel(name), MakeControlChannel(name), std::string(kScenarioChannel),
          std::string(kRunStatusChannel)};
}

WorkerReactor::WorkerReactor(WorkerIdentity identity, const RunKey& key, Transport* transport, const Clock* clock,
                             Executor* executor)
    : identity_(std::move(identity)),
      key_(key),
      transport_(transport),
      clock_(clock),
      executor_(executor),
      sender_(identity_.instance, key, transport, clock),
      results_(kMaxResults),
      status_sent_us_(clock->now_us()),
      status_due_us_(clock->now_us()) {}

void WorkerReactor::Turn(std::int64_t longest_wait_us) {
  const std::int64_t wait_us = std::clamp<std::int64_t>(next_deadline_us() - clock_->now_us(), 0, longest_wait_us);
  std::optional<Message> message = transport_->Receive(wait_us);
  for (int i = 1; message; ++i) {
    Handle(*message);
    if (i == kMessagesPerTurn) break;
    message = transport_->Receive(0);
  }
  Tick();
}

void WorkerReactor::Handle(const Message& message) {
  if (message.channel == kScenarioChannel) {
    const auto piece = Open<scenario_t>(message.bytes, key_, &refusals_);
    if (piece && fetch_) fetch_->Add(*piece);
  } else if (message.channel == kRunStatusChannel) {
    const auto status = Open<run_status_t>(message.bytes, key_, &refusals_);
    if (status && status->run_id == run_id_) run_heard_us_ = message.arrival_us;
  } else if (message.channel == MakeRequestChannel(identity_.name)) {
    const auto request = Open<rollout_request_t>(message.bytes, key_, &refusals_);
    if (!request || request->receiver != identity_.instance || request->run_id != run_id_) return;
    run_heard_us_ = message.arrival_us;
    HandleRequest(*request);
  } else if (message.channel == MakeControlChannel(identity_.name)) {
    const auto control = Open<control_t>(message.bytes, key_, &refusals_);
    if (!control || control->receiver != identity_.instance) return;
    HandleControl(*control);
  }
}

void WorkerReactor::HandleControl(const control_t& control) {
  if (control.kind == control_t::kJoin) {
    Join(control);
    return;
  }
  if (control.run_id != run_id_) return;
  run_heard_us_ = clock_->now_us();
  if (control.kind == control_t::kAcknowledge) {
    for (const ContentId& id : ParseIds(control.ids)) results_.Acknowledge(id);
  } else if (control.kind == control_t::kCancel) {
    for (const ContentId& id : ParseIds(control.ids)) Cancel(id, control.sequence);
  } else if (control.kind == control_t::kStop) {
    SayGoodbye();
  }
}

void WorkerReactor::Join(const control_t& control) {
  const std::int64_t now_us = clock_->now_us();
  if (control.run_id == 0) return;
  if (control.run_id != run_id_) {
    if (run_id_ != 0 && now_us - run_heard_us_ < kRunSilenceUs) return;  // its own run lives
    // What the old run wanted is wanted no more; a computation that runs cannot be broken off and is kept as answer.
    while (queue_.size() > (running_ ? 1u : 0u)) queue_.pop_back();
    partial_.clear();
    partial_order_.clear();
    cancelled_.clear();
    cancelled_order_.clear();
    results_.AcknowledgeAll();
    run_id_ = control.run_id;
    status_due_us_ = now_us;
  }
  run_heard_us_ = now_us;
  run_scenario_ = MakeId(control.scenario);
}

void WorkerReactor::Cancel(const ContentId& id, std::int64_t sequence) {
  // A computation cannot be broken off; its answer is sent all the same, for a second answer is a check on the first.
  const auto first = queue_.begin() + (running_ ? 1 : 0);
  queue_.erase(std::remove_if(first, queue_.end(), [&](const Job& job) { return job.id == id; }), queue_.end());
  ErasePartial(id);
  results_.Acknowledge(id);
  // A request that was overtaken by its cancellation is recognised by its smaller sequence number.
  if (cancelled_.insert_or_assign(id, sequence).second) cancelled_order_.push_back(id);
  if (cancelled_order_.size() > kMaxCancelled) {
    cancelled_.erase(cancelled_order_.front());
    cancelled_order_.pop_front();
  }
}

bool WorkerReactor::IsQueued(const ContentId& id) const {
  return std::any_of(queue_.begin(), queue_.end(), [&](const Job& job) { return job.id == id; });
}

void WorkerReactor::HandleRequest(const rollout_request_t& request) {
  for (const ContentId& id : ParseIds(request.acknowledged)) results_.Acknowledge(id);
  for (const assignment_t& assignment : request.assignments) {
    HandleAssignment(assignment, MakeId(request.scenario), request.sequence);
  }
}

void WorkerReactor::HandleAssignment(const assignment_t& assignment, const ContentId& scenario, std::int64_t sequence) {
  const ContentId id = MakeId(assignment.id);
  const auto tombstone = cancelled_.find(id);
  if (tombstone != cancelled_.end()) {
    if (sequence < tombstone->second) return;
    tombstone->second = -1;  // wanted again
  }
  if (ResultStore::Entry* entry = results_.Find(id)) {
    ++repeated_;
    PublishResult(entry);
    return;
  }
  if (IsQueued(id) || queue_.size() >= static_cast<std::size_t>(kMaxQueue)) return;

  const std::int64_t total = CountValues(assignment);
  if (total > kMaxValues) {
    ++refusals_.malformed;
    return;
  }
  auto found = partial_.find(id);
  if (found == partial_.end()) {
    if (partial_.size() >= kMaxPartial) ErasePartial(ContentId(partial_order_.front()));
    found = partial_.emplace(id, ValueAssembly(static_cast<std::int32_t>(total))).first;
    partial_order_.push_back(id);
  }
  ValueAssembly& values = found->second;
  if (!values.Add(static_cast<std::int32_t>(total), assignment.first_value, assignment.values)) {
    ++refusals_.malformed;
  } else if (values.IsComplete()) {
    TakeRequest(assignment, scenario, values.values());
    ErasePartial(id);
  }
}

void WorkerReactor::ErasePartial(const ContentId& id) {
  if (partial_.erase(id) == 0) return;
  partial_order_.erase(std::find(partial_order_.begin(), partial_order_.end(), id));
}

void WorkerReactor::TakeRequest(const assignment_t& head, const ContentId& scenario,
                                const std::vector<double>& values) {
  const RequestValues asked(head, values);
  Job job;
  job.id = MakeId(head.id);
  job.scenario = scenario;
  job.attempt = head.attempt;
  job.request.theta.assign(asked.theta.begin(), asked.theta.end());
  job.request.controls.assign(asked.controls.begin(), asked.controls.end());
  job.request.reference.assign(asked.reference.begin(), asked.reference.end());
  job.request.variation.assign(asked.variation.begin(), asked.variation.end());
  job.request.nodes.assign(asked.nodes.begin(), asked.nodes.end());
  job.request.gradient = head.gradient != 0;
  const ContentId id = CalcRequestId({identity_.engine.name, job.scenario, asked.theta, asked.controls, asked.reference,
                                      asked.variation, job.request.gradient, asked.nodes});
  if (id != job.id) {
    ++refusals_.malformed;  // the coordinator means another engine, or parts of two requests were mixed
    return;
  }
  queue_.push_back(std::move(job));
}

void WorkerReactor::Tick() {
  const std::int64_t now_us = clock_->now_us();
  if (const std::optional<EngineAnswer> answer = executor_->TakeAnswer()) {
    if (!answer->lack.empty()) {
      SayGoodbye(answer->lack);
      return;
    }
    if (running_) FinishJob(*answer);
  }
  FetchScenario();
  StartNextJob();
  for (const ContentId& id : results_.FindDue(now_us - kResultRetryUs, kResultsPerRetry)) {
    PublishResult(results_.Find(id));
  }
  if (now_us >= status_due_us_) PublishStatus(CalcState());
}

std::int64_t WorkerReactor::next_deadline_us() const {
  std::int64_t deadline_us = status_due_us_;
  const std::int64_t now_us = clock_->now_us();
  if (fetch_) deadline_us = std::min(deadline_us, now_us + kFetchRetryUs);
  if (results_.unacknowledged() > 0) deadline_us = std::min(deadline_us, now_us + kResultRetryUs);
  return deadline_us;
}

void WorkerReactor::FinishJob(const EngineAnswer& answer) {
  const Job job = std::move(queue_.front());
  queue_.pop_front();
  running_ = false;
  const std::int64_t now_us = clock_->now_us();
  last_compute_s_ = static_cast<double>(now_us - job_started_us_) * 1e-6;
  busy_us_ += now_us - std::max(job_started_us_, status_sent_us_);
  ++finished_;

  rollout_result_t head{};
  head.loss = answer.loss;
  head.loss_error = answer.loss_error;
  head.worst_residual = answer.worst_residual;
  head.penetration = answer.penetration;
  head.largest_force = answer.largest_force;
  head.distrust = answer.distrust;
  head.forward_s = answer.forward_s;
  head.gradient_s = answer.gradient_s;
  head.compute_s = last_compute_s_;
  head.success = MakeFlag(answer.success);
  head.finite = MakeFlag(answer.finite);
  head.converged = MakeFlag(answer.converged);
  head.gradient_reliable = MakeFlag(answer.gradient_reliable);
  head.subdivided_steps = answer.subdivided_steps;
  head.contact_onsets = answer.contact_onsets;
  head.steps = answer.steps;
  head.attempt = job.attempt;
  head.worker = identity_.name;
  CopyId(job.id, head.id);
  std::vector<double> gradient = answer.gradient;
  std::string error = answer.error;
  if (gradient.size() > static_cast<std::size_t>(kMaxValues)) error = "the engine's gradient is too long to travel";
  if (!error.empty()) {
    gradient.clear();
    head.status = rollout_result_t::kError;
    head.error = std::move(error);
  }
  head.gradient_size = static_cast<std::int32_t>(gradient.size());
  std::vector<rollout_result_t> parts;
  ForEachPart(gradient, [&](std::int32_t first, std::span<const double> values) {
    parts.push_back(head);
    parts.back().first_value = first;
    parts.back().values.assign(values.begin(), values.end());
  });

  PublishResult(&results_.Add(job.id, std::move(parts)));
}

void WorkerReactor::PublishResult(ResultStore::Entry* entry) {
  entry->sent_at_us = clock_->now_us();
  for (const rollout_result_t& part : entry->parts) sender_.Publish(kResultChannel, run_id_, part);
}

std::optional<ContentId> WorkerReactor::FindMissingScenario() const {
  // The first request waits for its scenario; later ones may have others, which come when it is their turn.
  const std::optional<ContentId> wanted = queue_.empty() ? run_scenario_ : queue_.front().scenario;
  return wanted && bundles_.count(*wanted) == 0 ? wanted : std::nullopt;
}

void WorkerReactor::FetchScenario() {
  const std::optional<ContentId> missing = FindMissingScenario();
  if (!missing) {
    fetch_.reset();
    return;
  }
  if (!fetch_ || fetch_->scenario() != *missing) fetch_.emplace(*missing);
  if (const auto bundle = fetch_->TakeBundle()) {
    bundles_[*missing] = bundle;
    bundle_order_.push_back(*missing);
    if (bundle_order_.size() > kMaxBundles) {
      bundles_.erase(bundle_order_.front());
      bundle_order_.pop_front();
    }
    fetch_.reset();
    return;
  }
  std::vector<std::int32_t> wanted = fetch_->ChooseWanted(clock_->now_us(), kFetchRetryUs);
  if (wanted.empty()) return;
  control_t control{};
  control.receiver = run_id_;
  control.kind = control_t::kWantScenario;
  control.chunks = std::move(wanted);
  control.worker = identity_.name;
  CopyId(*missing, control.scenario);
  sender_.Publish(kControlChannel, run_id_, std::move(control));
}

void WorkerReactor::StartNextJob() {
  if (executor_->busy()) return;
  const std::optional<ContentId> scenario = queue_.empty() ? run_scenario_ : queue_.front().scenario;
  if (!scenario) return;
  const auto bundle = bundles_.find(*scenario);
  if (bundle == bundles_.end()) return;
  if (queue_.empty() && started_scenario_ == scenario) return;  // loaded ahead already
  ExecutorJob job;
  job.scenario = *scenario;
  job.bundle = bundle->second;
  if (!queue_.empty()) {
    job.request = queue_.front().request;
    running_ = true;
    job_started_us_ = clock_->now_us();
  }
  started_scenario_ = scenario;
  executor_->Start(std::move(job));
}

std::int32_t WorkerReactor::CalcState() const {
  if (running_) return worker_status_t::kComputing;
  if (executor_->busy() || fetch_) return worker_status_t::kLoading;
  return worker_status_t::kIdle;
}

void WorkerReactor::PublishStatus(std::int32_t state, const std::string& reason) {
  const std::int64_t now_us = clock_->now_us();
  const StepProgress steps = running_ ? executor_->progress() : StepProgress{};
  if (running_) busy_us_ += now_us - std::max(job_started_us_, status_sent_us_);
  worker_status_t status{};
  status.steps_done = steps.done;
  status.steps_total = steps.total;
  if (steps.total > 0) status.step_fraction = static_cast<double>(steps.done) / static_cast<double>(steps.total);
  if (now_us > status_sent_us_) {
    status.busy_fraction = static_cast<double>(busy_us_) / static_cast<double>(now_us - status_sent_us_);
  }
  status.compute_s = last_compute_s_;
  status.finished = finished_;
  status.repeated = repeated_;
  status.refused = refusals_.total();
  status.state = state;
  status.protocol = kProtocolVersion;
  status.pid = identity_.pid;
  status.unacknowledged = static_cast<std::int32_t>(results_.unacknowledged());
  status.queue_capacity = kMaxQueue;
  if (running_) CopyId(queue_.front().id, status.running);
  if (started_scenario_) CopyId(*started_scenario_, status.scenario);
  CopyId(identity_.engine.fingerprint, status.fingerprint);
  for (const Job& job : queue_) AppendId(job.id, &status.queue);
  status.name = identity_.name;
  status.engine = identity_.engine.name;
  status.build = identity_.engine.build;
  status.host = identity_.host;
  status.reason = reason;
  sender_.Publish(kWorkerStatusChannel, run_id_, std::move(status));
  status_sent_us_ = now_us;
  status_due_us_ = now_us + kStatusIntervalUs;
  busy_us_ = 0;
}

void WorkerReactor::SayGoodbye(const std::string& lack) {
  stopped_ = true;
  lack_ = lack;
  PublishStatus(worker_status_t::kStopping, lack);
}

}  // namespace knap
