// Who gets which request: credits, requests moved to idle workers, second copies of stragglers.
#include <algorithm>
#include <cstddef>
#include <deque>
#include <utility>

#include "coordinator/dispatch/dispatcher.h"

namespace knap {
namespace {

constexpr std::int64_t kArrivedUs = 100'000;  // a request sent earlier than this has arrived, or is lost

}  // namespace

void Dispatcher::AssignWaiting() {
  const auto credits = static_cast<std::size_t>(pace_.CalcCredits(options_.credits));
  const std::deque<ContentId>& queue = requests_.book().queue;
  for (std::size_t place = 0; place < queue.size();) {
    const ContentId id = queue[place];
    const Request& request = *requests_.FindOpen(id);
    KnownWorker* worker = ChooseWorker(request, request.suspect ? 1 : credits);
    if (worker != nullptr) {
      if (request.attempts > 0) ++counters_.reissued;
      NoteWork(worker);
      requests_.Give(id, worker->instance, clock_->now_us());
    } else if (request.suspect || !request.lacking.empty()) {
      ++place;  // it waits for an idle worker, or for an able one; others need not wait for it
    } else {
      break;
    }
  }
  if (queue.empty() && requests_.open() > 0) ServeIdleWorkers();
}

std::size_t Dispatcher::CountOccupying(const KnownWorker& worker) const {
  const bool abandoned =
      worker.running != ContentId{} && requests_.FindLease(worker.running, worker.instance) == nullptr;
  return requests_.GetHolding(worker.instance).ids.size() + (abandoned ? 1 : 0);
}

KnownWorker* Dispatcher::ChooseWorker(const Request& request, std::size_t limit) {
  KnownWorker* best = nullptr;
  std::size_t least = 0;
  for (auto& [instance, worker] : roster_.workers()) {
    const Holding& holding = requests_.GetHolding(instance);
    const std::size_t occupying = CountOccupying(worker);
    if (!IsUsable(worker) || holding.alone || occupying >= limit || request.lacking.count(worker.name) != 0) continue;
    // Filled up when half is gone, so that one message brings many.
    if (occupying > limit / 2 && holding.unsent.empty()) continue;
    if (best != nullptr && occupying >= least) continue;
    best = &worker;
    least = occupying;
  }
  return best;
}

void Dispatcher::NoteWork(KnownWorker* worker) {
  if (CountOccupying(*worker) == 0) worker->progress_us = worker->began_us = clock_->now_us();
}

void Dispatcher::ServeIdleWorkers() {
  std::vector<KnownWorker*> idle;
  for (auto& [instance, worker] : roster_.workers()) {
    if (IsUsable(worker) && CountOccupying(worker) == 0) idle.push_back(&worker);
  }
  if (idle.empty()) return;
  MoveTo(&idle);
  if (!idle.empty()) CopyTo(&idle);
}

KnownWorker* Dispatcher::TakeIdle(std::vector<KnownWorker*>* idle, const Request& request) const {
  for (std::size_t i = idle->size(); i-- > 0;) {
    KnownWorker* worker = (*idle)[i];
    if (request.lacking.count(worker->name) != 0) continue;
    idle->erase(idle->begin() + static_cast<std::ptrdiff_t>(i));
    return worker;
  }
  return nullptr;
}

void Dispatcher::MoveTo(std::vector<KnownWorker*>* idle) {
  for (auto& [instance, busy] : roster_.workers()) {
    while (const std::optional<ContentId> id = FindMovable(busy)) {
      KnownWorker* worker = TakeIdle(idle, *requests_.FindOpen(*id));
      if (worker == nullptr) break;
      NoteWork(worker);
      requests_.Move(*id, instance, worker->instance, clock_->now_us());
      busy.unsent_cancellations.push_back(*id);
      ++counters_.moved;
      if (idle->empty()) return;
    }
  }
}

std::optional<ContentId> Dispatcher::FindMovable(const KnownWorker& worker) const {
  const std::vector<ContentId>& held = requests_.GetHolding(worker.instance).ids;
  for (std::size_t i = held.size(); i-- > 0;) {
    const ContentId& id = held[i];
    if (id == worker.running) continue;
    // The first one has probably begun, unless a status from after its arrival names another.
    const std::int64_t age_us = worker.status_us - requests_.FindLease(id, worker.instance)->sent_us;
    if (i > 0 || (worker.running != ContentId{} && age_us > kArrivedUs)) return id;
  }
  return std::nullopt;
}

void Dispatcher::CopyTo(std::vector<KnownWorker*>* idle) {
  const std::int64_t now_us = clock_->now_us();
  std::vector<std::pair<std::int64_t, ContentId>> stragglers;  // begin and id
  for (const auto& [instance, worker] : roster_.workers()) {
    const std::vector<ContentId>& held = requests_.GetHolding(instance).ids;
    if (held.empty()) continue;
    const bool runs_own = requests_.FindLease(worker.running, instance) != nullptr;
    if (!runs_own && worker.running != ContentId{}) continue;  // it is busy with what was taken from it
    const ContentId& id = runs_own ? worker.running : held.front();
    const Request& request = *requests_.FindOpen(id);
    if (request.suspect || request.leases.size() > 1) continue;
    if (pace_.IsStraggling(now_us - worker.began_us, requests_.open())) stragglers.emplace_back(worker.began_us, id);
  }
  std::sort(stragglers.begin(), stragglers.end());
  for (const auto& [began_us, id] : stragglers) {
    KnownWorker* worker = TakeIdle(idle, *requests_.FindOpen(id));
    if (worker == nullptr) continue;
    ++counters_.copied;
    NoteWork(worker);
    const KnownWorker& straggler = *roster_.Find(requests_.FindOpen(id)->leases.front().worker);
    RequestTrouble trouble = MakeTrouble(TroubleKind::kStraggler, straggler, {&id, 1});
    requests_.Give(id, worker->instance, now_us);
    trouble.helper = worker->name;
    trouble.copy_attempt = requests_.FindOpen(id)->attempts;
    Tell(trouble);
  }
}

}  // namespace knap
