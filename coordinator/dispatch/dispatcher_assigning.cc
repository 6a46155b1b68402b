// Who gets which request: credits, requests moved to idle workers, second copies of stragglers.
#include <algorithm>
#include <cstddef>
#include <utility>

#include "coordinator/dispatch/dispatcher.h"

namespace knap {
namespace {

constexpr std::int64_t kArrivedUs = 100'000;  // a request sent earlier than this has arrived, or is lost

}  // namespace

void Dispatcher::AssignWaiting() {
  std::deque<ContentId> passed_over;
  const auto credits = static_cast<std::size_t>(pace_.CalcCredits(options_.credits));
  while (!waiting_.empty()) {
    const ContentId id = waiting_.front();
    const auto open = open_.find(id);
    if (open == open_.end() || !open->second.waiting) {
      waiting_.pop_front();
      continue;
    }
    OpenRequest& request = open->second;
    KnownWorker* worker = ChooseWorker(request.suspect ? 1 : credits);
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
  if (waiting_.empty() && !open_.empty()) ServeIdleWorkers();
}

KnownWorker* Dispatcher::ChooseWorker(std::size_t limit) {
  KnownWorker* best = nullptr;
  for (auto& [instance, worker] : roster_.workers()) {
    if (!IsUsable(worker) || worker.alone || worker.CountOccupying() >= limit) continue;
    // Filled up when half is gone, so that one message brings many.
    if (worker.CountOccupying() > limit / 2 && worker.unsent_requests.empty()) continue;
    if (best == nullptr || worker.CountOccupying() < best->CountOccupying()) best = &worker;
  }
  return best;
}

void Dispatcher::Assign(const ContentId& id, OpenRequest* request, KnownWorker* worker) {
  const std::int64_t now_us = clock_->now_us();
  request->waiting = false;
  request->assigned_to.push_back(worker->instance);
  ++request->attempts;
  if (worker->CountOccupying() == 0) worker->progress_us = worker->began_us = now_us;
  worker->assigned.push_back(id);
  worker->alone = request->suspect;
  Enqueue(id, request, worker, now_us);
}

void Dispatcher::ServeIdleWorkers() {
  std::vector<KnownWorker*> idle;
  for (auto& [instance, worker] : roster_.workers()) {
    if (IsUsable(worker) && worker.CountOccupying() == 0) idle.push_back(&worker);
  }
  if (idle.empty()) return;
  MoveTo(&idle);
  if (!idle.empty()) CopyTo(&idle);
}

void Dispatcher::MoveTo(std::vector<KnownWorker*>* idle) {
  for (auto& [instance, busy] : roster_.workers()) {
    while (const std::optional<ContentId> id = FindMovable(busy)) {
      OpenRequest& request = open_.at(*id);
      request.waiting = true;  // so that it does not go back to waiting_
      Unassign(*id, &busy);
      busy.unsent_cancellations.push_back(*id);
      ++counters_.moved;
      Assign(*id, &request, idle->back());
      idle->pop_back();
      if (idle->empty()) return;
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

void Dispatcher::CopyTo(std::vector<KnownWorker*>* idle) {
  const std::int64_t now_us = clock_->now_us();
  std::vector<std::pair<std::int64_t, ContentId>> stragglers;  // begin and id
  for (const auto& [instance, worker] : roster_.workers()) {
    if (worker.assigned.empty()) continue;
    const bool runs_own =
        std::find(worker.assigned.begin(), worker.assigned.end(), worker.running) != worker.assigned.end();
    if (!runs_own && worker.running != ContentId{}) continue;  // it is busy with what was taken from it
    const ContentId& id = runs_own ? worker.running : worker.assigned.front();
    const OpenRequest& request = open_.at(id);
    if (request.suspect || request.assigned_to.size() > 1) continue;
    if (pace_.IsStraggling(now_us - worker.began_us, open_.size())) stragglers.emplace_back(worker.began_us, id);
  }
  std::sort(stragglers.begin(), stragglers.end());
  for (const auto& [began_us, id] : stragglers) {
    if (idle->empty()) return;
    ++counters_.copied;
    Assign(id, &open_.at(id), idle->back());
    idle->pop_back();
  }
}

}  // namespace knap
