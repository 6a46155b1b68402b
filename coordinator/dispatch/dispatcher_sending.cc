// How what the dispatcher decided is put into messages.
#include <algorithm>
#include <cstddef>
#include <string>
#include <utility>

#include "coordinator/dispatch/dispatcher.h"
#include "lcmtypes/wire/channels.h"

namespace knap {
namespace {

constexpr std::int64_t kStatusIntervalUs = 500'000;
// Encoded bytes of a rollout_request_t without its lists, and of an assignment_t without its values.
constexpr std::size_t kRequestSize = 8 + 5 * 8 + 2 * 4 + 32 + RunKey::kDigestSize;
constexpr std::size_t kAssignmentSize = 9 * 4 + 32;

// Takes up to `limit` ids off the front.
std::vector<ContentId> TakeFront(std::vector<ContentId>* ids, std::size_t limit) {
  const auto end = ids->begin() + static_cast<std::ptrdiff_t>(std::min(limit, ids->size()));
  std::vector<ContentId> taken(ids->begin(), end);
  ids->erase(ids->begin(), end);
  return taken;
}

// The parts of one request, as many as its values need. The last `controls` values of its theta are controls.
std::vector<assignment_t> MakeAssignments(const ContentId& id, const RolloutQuery& query, std::size_t controls,
                                          std::int32_t attempt) {
  assignment_t head{};
  head.attempt = attempt;
  head.gradient = query.gradient ? 1 : 0;
  head.theta_size = static_cast<std::int32_t>(query.theta.size() - controls);
  head.control_size = static_cast<std::int32_t>(controls);
  head.reference_size = static_cast<std::int32_t>(query.theta_reference.size());
  head.variation_size = static_cast<std::int32_t>(query.variation.size());
  head.nodes_size = static_cast<std::int32_t>(query.theta_nodes.size());
  CopyId(id, head.id);
  std::vector<double> values = query.theta;
  values.insert(values.end(), query.theta_reference.begin(), query.theta_reference.end());
  values.insert(values.end(), query.variation.begin(), query.variation.end());
  values.insert(values.end(), query.theta_nodes.begin(), query.theta_nodes.end());
  std::vector<assignment_t> parts;
  ForEachPart(values, [&](std::int32_t first, std::span<const double> part) {
    parts.push_back(head);
    parts.back().first_value = first;
    parts.back().values.assign(part.begin(), part.end());
  });
  return parts;
}

}  // namespace

void Dispatcher::SendRequests(KnownWorker* worker) {
  rollout_request_t message{};
  std::size_t room = 0;  // bytes left in the message; 0 when none is begun
  const auto begin = [&] {
    message = rollout_request_t{};
    message.receiver = worker->instance;
    CopyId(scenario(), message.scenario);
    for (const ContentId& done : TakeFront(&worker->unsent_acknowledgements, kAcknowledgementsPerRequest)) {
      AppendId(done, &message.acknowledged);
    }
    room = kMaxMessageSize - kRequestSize - message.acknowledged.size();
  };
  const auto end = [&] {
    if (message.assignments.empty()) return;
    sender_.Publish(MakeRequestChannel(worker->name), options_.run_id, std::move(message));
    message.assignments.clear();
    room = 0;
  };
  for (const ContentId& id : requests_.TakeUnsent(worker->instance)) {
    const Request& request = *requests_.FindOpen(id);
    for (assignment_t& part : MakeAssignments(id, request.query, options_.control_size, request.attempts)) {
      const std::size_t size = kAssignmentSize + 8 * part.values.size();
      if (size > room || message.assignments.size() == static_cast<std::size_t>(kAssignmentsPerRequest)) {
        end();
        begin();
      }
      room -= size;
      message.assignments.push_back(std::move(part));
    }
  }
  end();
}

void Dispatcher::SendControl(std::int32_t kind, const KnownWorker& worker, std::span<const ContentId> ids) {
  control_t control{};
  control.receiver = worker.instance;
  control.kind = kind;
  if (kind == control_t::kJoin) CopyId(scenario(), control.scenario);
  for (const ContentId& id : ids) AppendId(id, &control.ids);
  sender_.Publish(MakeControlChannel(worker.name), options_.run_id, std::move(control));
}

void Dispatcher::FlushMessages() {
  for (auto& [instance, worker] : roster_.workers()) {
    // First of all, so that what is wanted again has the larger sequence number.
    while (!worker.unsent_cancellations.empty()) {
      SendControl(control_t::kCancel, worker, TakeFront(&worker.unsent_cancellations, kIdsPerControl));
    }
    SendRequests(&worker);
    while (!worker.unsent_acknowledgements.empty()) {
      SendControl(control_t::kAcknowledge, worker, TakeFront(&worker.unsent_acknowledgements, kIdsPerControl));
    }
  }
}

void Dispatcher::PublishRunStatus() {
  const std::int64_t now_us = clock_->now_us();
  run_status_t status{};
  status.state = progress_.state;
  status.progress = progress_.progress;
  status.loss = progress_.loss;
  status.grad_norm = progress_.grad_norm;
  status.best_loss = progress_.best_loss;
  status.radius = progress_.radius;
  status.eta_s = progress_.eta_s;
  status.iteration = progress_.iteration;
  status.batch = progress_.batch;
  status.batch_count = progress_.batch_count;
  status.theta = progress_.theta;
  if (status.theta.size() > static_cast<std::size_t>(kValuesPerPart)) status.theta.resize(kValuesPerPart);
  status.scenario = progress_.scenario;
  status.method = progress_.method;
  status.elapsed_s = static_cast<double>(now_us - started_us_) * 1e-6;
  if (now_us > status_sent_us_) {
    const double interval_s = static_cast<double>(now_us - status_sent_us_) * 1e-6;
    status.rollouts_per_s = static_cast<double>(counters_.computed - computed_at_status_) / interval_s;
  }
  status.workers = CountUsableWorkers();
  status.requests_open = static_cast<std::int32_t>(requests_.open());
  status.requests_done = static_cast<std::int32_t>(counters_.computed);
  status.requests_reissued = static_cast<std::int32_t>(counters_.reissued);
  status.rollouts_untrusted = static_cast<std::int32_t>(counters_.untrusted);
  status.gradients_flagged = static_cast<std::int32_t>(counters_.flagged);
  status.messages_refused = static_cast<std::int32_t>(counters_.refused.total());
  sender_.Publish(kRunStatusChannel, options_.run_id, std::move(status));
  computed_at_status_ = counters_.computed;
  status_sent_us_ = now_us;
  status_due_us_ = now_us + kStatusIntervalUs;
}

}  // namespace knap
