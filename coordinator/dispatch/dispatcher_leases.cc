// Whom the dispatcher believes dead or stuck, and what becomes of the requests they held.
#include <fmt/format.h>

#include <algorithm>

#include "coordinator/dispatch/dispatcher.h"

namespace knap {
namespace {

constexpr std::int64_t kForgetUs = 60'000'000;  // a worker silent for so long is like a new one if it comes again
constexpr std::int32_t kMaxFatalAttempts = 3;
constexpr std::size_t kMaxStalls = 3;

}  // namespace

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
    std::string what = fmt::format("no worker for {} s ({} requests wait)", options_.no_worker_s, open_.size());
    for (const auto& [instance, why] : refused_) what += fmt::format("; refused {}", why);
    throw NoWorkers(what);
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
  worker->unsent_requests.clear();
  worker->unsent_acknowledgements.clear();
  worker->unsent_cancellations.clear();
}

void Dispatcher::Unassign(const ContentId& id, KnownWorker* worker) {
  std::erase(worker->assigned, id);
  worker->alone = worker->alone && !worker->assigned.empty();
  OpenRequest& request = open_.at(id);
  std::erase(request.assigned_to, worker->instance);
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
    worker.unsent_requests.clear();
    worker.alone = false;
  }
  open_.clear();
  waiting_.clear();
  failure_.reset();
  FlushMessages();
}

}  // namespace knap
