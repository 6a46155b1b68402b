// Whom the dispatcher believes dead or stuck, and what becomes of the requests they held.
#include <fmt/format.h>

#include <algorithm>

#include "coordinator/dispatch/dispatcher.h"

namespace knap {
namespace {

constexpr std::int64_t kForgetUs = 60'000'000;  // a worker silent for so long is like a new one if it comes again
constexpr std::size_t kMostLacking = 16;        // workers whose lack is told

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
      Release(&worker, TroubleKind::kSilent);
    }
    if (worker.stalled && worker.state == worker_status_t::kIdle && now_us - worker.stalled_us > stall_us) {
      worker.stalled = false;  // it computes nothing: it did not hear us, and may hear us again
    }
    if (CountOccupying(worker) == 0 || worker.silent || worker.stalled) continue;  // the dead are not stuck
    if (now_us - std::max(worker.progress_us, listening_since_us_) <= stall_us) continue;
    worker.stalled = true;
    worker.stalled_us = now_us;
    ++counters_.workers_stalled;
    const ContentId stuck = worker.running == ContentId{} ? requests_.GetHolding(instance).ids.front() : worker.running;
    // A request that never arrived there is not to blame.
    const Lease* lease = requests_.FindLease(stuck, instance);
    if (lease != nullptr && lease->arrived && requests_.ChargeStall(stuck, instance)) {
      Fail(fmt::format("request {} made no progress for {} s on {} workers", FormatHex(stuck), options_.stall_s,
                       RequestTable::kMaxStalls));
    }
    Release(&worker, TroubleKind::kStuck);
    if (on_stalled_) on_stalled_(worker);
  }
}

bool Dispatcher::HasAbleWorker(const Request& request) const {
  return std::any_of(roster_.workers().begin(), roster_.workers().end(), [&](const auto& entry) {
    return IsUsable(entry.second) && request.lacking.count(entry.second.name) == 0;
  });
}

void Dispatcher::CheckForWorkers(std::int64_t now_us) {
  std::string missing = CountUsableWorkers() > 0 ? "" : "no worker";
  for (const ContentId& id : requests_.book().queue) {
    const Request& request = *requests_.FindOpen(id);
    if (!missing.empty() || request.attempts == 0) break;  // those that nobody has tried yet come last
    if (HasAbleWorker(request)) continue;
    missing = fmt::format("no worker that has what request {} needs", FormatHex(id));
  }
  if (requests_.open() == 0 || missing.empty()) {
    usable_us_ = now_us;
  } else if (now_us - std::max(usable_us_, listening_since_us_) > ToMicroseconds(options_.no_worker_s)) {
    std::string what = fmt::format("{} for {} s ({} requests wait)", missing, options_.no_worker_s, requests_.open());
    for (const auto& [instance, why] : refused_) what += fmt::format("; refused {}", why);
    for (const auto& [instance, why] : lacking_) what += fmt::format("; {}", why);
    throw NoWorkers(what);
  }
}

void Dispatcher::NoteLack(const worker_status_t& status) {
  requests_.NoteLack(status.sender, MakeId(status.running), status.name);
  ++counters_.workers_lacking;
  lacking_.emplace(status.sender, fmt::format("worker {} on {} left: {}", status.name, status.host, status.reason));
  if (lacking_.size() > kMostLacking) lacking_.erase(lacking_.begin());
}

void Dispatcher::ReportDeath(const std::string& worker_name, std::int32_t pid, DeathCause cause) {
  KnownWorker* worker = roster_.FindProcess(worker_name, pid);
  if (worker == nullptr) return;
  if (cause == DeathCause::kFault) {
    for (const ContentId& id : requests_.ChargeDeath(worker->instance, worker->running)) {
      Fail(fmt::format("request {} is poison: {} workers crashed while they computed it", FormatHex(id),
                       RequestTable::kMaxFatalAttempts));
    }
  }
  if (!worker->silent) ++counters_.workers_lost;
  Release(worker, cause == DeathCause::kFault ? TroubleKind::kFaulted : TroubleKind::kDied);
  roster_.Remove(worker->instance);
}

void Dispatcher::Release(KnownWorker* worker, TroubleKind why) {
  const std::vector<ContentId>& held = requests_.GetHolding(worker->instance).ids;
  // It is nothing out of the ordinary that workers end at the end, nor what those of no or another run do.
  const bool is_ours = worker->run_id == options_.run_id && !stopping_;
  if (is_ours || !held.empty()) Tell(MakeTrouble(why, *worker, held));
  requests_.TakeBack(worker->instance);
  worker->unsent_acknowledgements.clear();
  worker->unsent_cancellations.clear();
}

RequestTrouble Dispatcher::MakeTrouble(TroubleKind kind, const KnownWorker& worker,
                                       std::span<const ContentId> ids) const {
  RequestTrouble trouble{.kind = kind, .worker = worker.name, .host = worker.host};
  for (const ContentId& id : ids) {
    const Lease& lease = *requests_.FindLease(id, worker.instance);
    trouble.requests.push_back({id, lease.attempt, static_cast<double>(clock_->now_us() - lease.given_us) * 1e-6});
  }
  return trouble;
}

void Dispatcher::Tell(const RequestTrouble& trouble) const {
  if (on_trouble_) on_trouble_(trouble);
}

void Dispatcher::TellDropped() const {
  for (const auto& [instance, worker] : roster_.workers()) {
    const std::vector<ContentId>& held = requests_.GetHolding(instance).ids;
    if (!held.empty()) Tell(MakeTrouble(TroubleKind::kDropped, worker, held));
  }
  RequestTrouble waiting{.kind = TroubleKind::kDropped};
  for (const ContentId& id : requests_.book().queue) {
    waiting.requests.push_back({.id = id, .attempt = requests_.FindOpen(id)->attempts});
  }
  if (!waiting.requests.empty()) Tell(waiting);
}

void Dispatcher::CancelAll() {
  TellDropped();
  for (auto& [instance, worker] : roster_.workers()) {
    const std::vector<ContentId>& held = requests_.GetHolding(instance).ids;
    worker.unsent_cancellations.insert(worker.unsent_cancellations.end(), held.begin(), held.end());
  }
  requests_.DropOpen();
  failure_.reset();
  FlushMessages();
}

}  // namespace knap
