// What the dispatcher makes of messages: who works, what is answered.
#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "coordinator/dispatch/dispatcher.h"
#include "lcmtypes/wire/channels.h"

namespace knap {
namespace {

constexpr std::int64_t kLostUs = 100'000;  // a request sent earlier than this and not in the status is lost
constexpr std::size_t kMostRefused = 16;   // workers whose refusal is told; who keeps announcing more is noise

}  // namespace

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
  if (status.engine != options_.engine.name) {
    ++counters_.other_engine;
    return;
  }
  if (!IsName(status.name) || status.sender == 0) {
    ++counters_.refused.malformed;
    return;
  }
  if (!Admit(status)) return;
  KnownWorker* worker = roster_.Update(status, arrival_us);
  if (worker == nullptr) return;
  if (status.state == worker_status_t::kStopping) {
    if (!status.reason.empty()) NoteLack(status);
    Release(worker, status.reason.empty() ? TroubleKind::kStopping : TroubleKind::kLacking);
    roster_.Remove(worker->instance);
    return;
  }
  if (worker->run_id != options_.run_id) {
    Release(worker, TroubleKind::kElsewhere);  // it has forgotten what it was given
    if (!stopping_) SendControl(control_t::kJoin, *worker, {});
    return;
  }
  const std::vector<ContentId> queue = ParseIds(status.queue);
  for (const ContentId& id : queue) {
    if (requests_.FindOpen(id) == nullptr && id != worker->running) worker->unsent_cancellations.push_back(id);
  }
  std::vector<ContentId> lost;
  for (const ContentId& id : requests_.GetHolding(worker->instance).ids) {
    if (std::find(queue.begin(), queue.end(), id) != queue.end()) {
      requests_.NoteArrival(id, worker->instance);
    } else if (arrival_us - requests_.FindLease(id, worker->instance)->sent_us >= kLostUs) {
      // Either the request was lost or its answer: a worker that has the answer repeats it.
      ++counters_.resent;
      requests_.Resend(id, worker->instance, arrival_us);
      lost.push_back(id);
    }
  }
  if (!lost.empty()) Tell(MakeTrouble(TroubleKind::kMessageLost, *worker, lost));
}

bool Dispatcher::Admit(const worker_status_t& status) {
  const EngineIdentity theirs{status.engine, status.build, MakeId(status.fingerprint)};
  const std::string mismatch = DescribeMismatch(theirs, options_.engine);
  if (mismatch.empty()) return true;
  if (refused_.size() < kMostRefused &&
      refused_.emplace(status.sender, fmt::format("worker {} on {}: {}", status.name, status.host, mismatch)).second) {
    ++counters_.workers_refused;
  }
  return false;
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
  if (!IsName(result.worker)) {
    ++counters_.refused.malformed;
    return;
  }
  KnownWorker* worker = roster_.Find(result.sender);
  const ContentId id = MakeId(result.id);
  if (worker != nullptr) {
    worker->heard_us = arrival_us;
    worker->silent = false;
    worker->last_sequence = std::max(worker->last_sequence, result.sequence);  // statuses from before are outdated
    // A worker repeats old answers while it is stuck: only a new one is progress.
    if (worker->running == id || requests_.FindLease(id, worker->instance) != nullptr) {
      worker->stalled = false;
      worker->progress_us = arrival_us;
      if (result.first_value == 0) {
        pace_.Record(arrival_us - worker->began_us);
        worker->began_us = arrival_us;
      }
    }
    if (worker->running == id) worker->running = ContentId{};
  }
  const Request* request = requests_.FindOpen(id);
  if (request == nullptr) {
    if (const AnswerCache::Answer* known = answers_.Find(id)) {
      CompareWithKnown(result, *known);
    } else {
      ++counters_.late;
    }
    Owe(id, result);
    return;
  }
  const RolloutQuery& query = request->query;
  const bool has_gradient = query.gradient && result.status == rollout_result_t::kOk;
  if (static_cast<std::size_t>(result.gradient_size) != (has_gradient ? query.theta.size() : 0)) {
    Fail(fmt::format("worker {}: request {}: an answer with a gradient of {} values to a question about {} parameters",
                     result.worker, FormatHex(id), result.gradient_size, has_gradient ? query.theta.size() : 0));
    return;
  }
  const ValueAssembly* gradient =
      requests_.AddPart(id, result.sender, result.gradient_size, result.first_value, result.values);
  if (gradient == nullptr) {
    ++counters_.refused.malformed;
  } else if (gradient->IsComplete()) {
    Accept(id, result, std::vector<double>(gradient->values()));
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

void Dispatcher::CancelAtOthers(const ContentId& id, const Request& request, std::int64_t sender) {
  for (const Lease& lease : request.leases) {
    KnownWorker* holder = roster_.Find(lease.worker);
    if (holder != nullptr && lease.worker != sender) holder->unsent_cancellations.push_back(id);
  }
}

void Dispatcher::Accept(const ContentId& id, const rollout_result_t& result, const std::vector<double>& gradient) {
  if (result.status != rollout_result_t::kOk) {
    CancelAtOthers(id, requests_.Drop(id), result.sender);
    Fail(fmt::format("worker {}: {}", result.worker, result.error));
    return;
  }
  AnswerCache::Answer answer{MakeOutcome(result, gradient), result.worker};
  ++counters_.computed;
  const RolloutCertificate& certificate = answer.outcome.certificate;
  const bool failed = !certificate.finite || !certificate.converged;
  counters_.untrusted += failed || !certificate.distrust.empty() ? 1 : 0;
  counters_.flagged += !failed && !gradient.empty() && !certificate.gradient_reliable ? 1 : 0;
  if (on_result_) {
    const Request& request = *requests_.FindOpen(id);
    RolloutReport report;
    report.id = id;
    report.query = &request.query;
    report.outcome = &answer.outcome;
    report.worker = result.worker;
    report.attempt = result.attempt;
    report.waited_s = static_cast<double>(clock_->now_us() - request.opened_us) * 1e-6;
    if (const Lease* lease = requests_.FindLease(id, result.sender)) {
      report.held_s = static_cast<double>(clock_->now_us() - lease->given_us) * 1e-6;
    }
    report.compute_s = result.compute_s;
    on_result_(report);
  }
  const Request request = requests_.Answer(id);
  Owe(id, result);
  CancelAtOthers(id, request, result.sender);
  for (RolloutOutcome* slot : request.slots) *slot = answer.outcome;
  answers_.Insert(id, std::move(answer));
}

}  // namespace knap
