// The half of the dispatcher that decides what is sent to whom; dispatcher.cc has the half that listens.
#include <algorithm>
#include <cstddef>
#include <optional>
#include <string>
#include <utility>

#include "coordinator/dispatch/dispatcher.h"
#include "lcmtypes/wire/channels.h"

namespace knap {
namespace {

constexpr std::int64_t kStatusIntervalUs = 500'000;
constexpr std::int64_t kArrivedUs = 100'000;  // a request sent earlier than this has arrived, or is lost

// Takes up to `limit` ids off the front.
std::vector<ContentId> TakeFront(std::vector<ContentId>* ids, std::size_t limit) {
  const auto end = ids->begin() + static_cast<std::ptrdiff_t>(std::min(limit, ids->size()));
  std::vector<ContentId> taken(ids->begin(), end);
  ids->erase(ids->begin(), end);
  return taken;
}

}  // namespace

void Dispatcher::AssignWaiting() {
  std::deque<ContentId> passed_over;
  while (!waiting_.empty()) {
    const ContentId id = waiting_.front();
    const auto open = open_.find(id);
    if (open == open_.end() || !open->second.waiting) {
      waiting_.pop_front();
      continue;
    }
    OpenRequest& request = open->second;
    KnownWorker* worker = ChooseWorker(request);
    if (worker == nullptr && !request.suspect) break;
    waiting_.pop_front();
    if (worker == nullptr) {
      passed_over.push_back(id);  // a suspect waits for an idle worker; others need not wait for it
      continue;
    }
    if (request.attempts > 0) ++counters_.reissued;
    Assign(id, &request, worker);
  }
  waiting_.insert(waiting_.begin(), passed_over.begin(), passed_over.end());
  if (waiting_.empty()) MoveToIdleWorkers();
}

void Dispatcher::Assign(const ContentId& id, OpenRequest* request, KnownWorker* worker) {
  request->waiting = false;
  request->assigned_to.push_back(worker->instance);
  ++request->attempts;
  if (worker->CountOccupying() == 0) worker->progress_us = clock_->now_us();
  worker->assigned.push_back(id);
  worker->alone = request->suspect;
  SendRequest(id, request, worker);
}

void Dispatcher::MoveToIdleWorkers() {
  for (auto& [idle_instance, idle] : roster_.workers()) {
    if (!IsUsable(idle) || idle.CountOccupying() > 0) continue;
    for (auto& [instance, busy] : roster_.workers()) {
      const std::optional<ContentId> id = FindMovable(busy);
      if (!id) continue;
      OpenRequest& request = open_.at(*id);
      request.waiting = true;  // so that it does not go back to waiting_
      Unassign(*id, &busy);
      busy.unsent_cancellations.push_back(*id);
      ++counters_.moved;
      Assign(*id, &request, &idle);
      break;
    }
  }
}

std::optional<ContentId> Dispatcher::FindMovable(const KnownWorker& worker) const {
  for (std::size_t i = worker.assigned.size(); i-- > 0;) {
    const ContentId& id = worker.assigned[i];
    if (id == worker.running) continue;
    // The first one has probably begun, unless a status from after its arrival names another.
    const std::int64_t age_us = worker.status_us - open_.at(id).sent_us.at(worker.instance);
    if (i > 0 || (worker.running != ContentId{} && age_us > kArrivedUs)) return id;
  }
  return std::nullopt;
}

KnownWorker* Dispatcher::ChooseWorker(const OpenRequest& request) {
  KnownWorker* best = nullptr;
  const std::size_t limit = request.suspect ? 1 : static_cast<std::size_t>(options_.credits);
  for (auto& [instance, worker] : roster_.workers()) {
    if (!IsUsable(worker) || worker.alone || worker.CountOccupying() >= limit) continue;
    if (best == nullptr || worker.CountOccupying() < best->CountOccupying()) best = &worker;
  }
  return best;
}

void Dispatcher::SendRequest(const ContentId& id, OpenRequest* request, KnownWorker* worker) {
  const RolloutQuery& query = request->query;
  rollout_request_t head{};
  head.receiver = worker->instance;
  head.attempt = request->attempts;
  head.gradient = query.gradient ? 1 : 0;
  head.theta_size = static_cast<std::int32_t>(query.theta.size() - options_.control_size);
  head.control_size = static_cast<std::int32_t>(options_.control_size);
  head.reference_size = static_cast<std::int32_t>(query.theta_reference.size());
  head.variation_size = static_cast<std::int32_t>(query.variation.size());
  CopyId(id, head.id);
  CopyId(scenario(), head.scenario);
  std::vector<double> values = query.theta;
  values.insert(values.end(), query.theta_reference.begin(), query.theta_reference.end());
  values.insert(values.end(), query.variation.begin(), query.variation.end());
  ForEachPart(values, [&](std::int32_t first, std::span<const double> part) {
    rollout_request_t message = head;
    message.first_value = first;
    message.values.assign(part.begin(), part.end());
    for (const ContentId& done : TakeFront(&worker->unsent_acknowledgements, kAcknowledgementsPerRequest)) {
      AppendId(done, &message.acknowledged);
    }
    sender_.Publish(MakeRequestChannel(worker->name), options_.run_id, std::move(message));
  });
  request->sent_us[worker->instance] = clock_->now_us();
}

void Dispatcher::SendControl(std::int32_t kind, const KnownWorker& worker, std::span<const ContentId> ids) {
  control_t control{};
  control.receiver = worker.instance;
  control.kind = kind;
  if (kind == control_t::kJoin) CopyId(scenario(), control.scenario);
  for (const ContentId& id : ids) AppendId(id, &control.ids);
  sender_.Publish(MakeControlChannel(worker.name), options_.run_id, std::move(control));
}

void Dispatcher::FlushControls() {
  for (auto& [instance, worker] : roster_.workers()) {
    while (!worker.unsent_acknowledgements.empty()) {
      SendControl(control_t::kAcknowledge, worker, TakeFront(&worker.unsent_acknowledgements, kIdsPerControl));
    }
    while (!worker.unsent_cancellations.empty()) {
      SendControl(control_t::kCancel, worker, TakeFront(&worker.unsent_cancellations, kIdsPerControl));
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
  status.scenario = MakeWireText(progress_.scenario, kMaxHostLength);
  status.method = MakeWireText(progress_.method, kMaxNameLength);
  status.elapsed_s = static_cast<double>(now_us - started_us_) * 1e-6;
  if (now_us > status_sent_us_) {
    const double interval_s = static_cast<double>(now_us - status_sent_us_) * 1e-6;
    status.rollouts_per_s = static_cast<double>(counters_.computed - computed_at_status_) / interval_s;
  }
  status.workers = CountUsableWorkers();
  status.requests_open = static_cast<std::int32_t>(open_.size());
  status.requests_done = static_cast<std::int32_t>(counters_.computed);
  status.requests_reissued = static_cast<std::int32_t>(counters_.reissued);
  status.messages_refused = static_cast<std::int32_t>(counters_.refused.total());
  sender_.Publish(kRunStatusChannel, options_.run_id, std::move(status));
  computed_at_status_ = counters_.computed;
  status_sent_us_ = now_us;
  status_due_us_ = now_us + kStatusIntervalUs;
}

}  // namespace knap
