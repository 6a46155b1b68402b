#include "coordinator/dispatch/worker_roster.h"

namespace knap {
namespace {

constexpr std::size_t kMaxDeparted = 4096;

}  // namespace

KnownWorker* WorkerRoster::Update(const worker_status_t& status, std::int64_t arrival_us) {
  if (departed_.count(status.sender) != 0) return nullptr;
  const auto [found, added] = workers_.try_emplace(status.sender);
  KnownWorker& worker = found->second;
  if (!added && status.sequence <= worker.last_sequence) return nullptr;
  const ContentId running = MakeId(status.running);
  const bool got_on = added || running != worker.running || status.steps_done != worker.steps_done ||
                      status.finished != worker.finished || status.state != worker.state;
  worker.instance = status.sender;
  worker.name = status.name;
  worker.host = status.host;
  worker.pid = status.pid;
  worker.run_id = status.run_id;
  worker.last_sequence = status.sequence;
  worker.heard_us = arrival_us;
  worker.status_us = arrival_us;
  worker.silent = false;
  worker.steps_done = status.steps_done;
  worker.finished = status.finished;
  worker.state = status.state;
  worker.running = running;
  if (got_on) {
    worker.progress_us = arrival_us;
    worker.stalled = false;
  }
  return &worker;
}

KnownWorker* WorkerRoster::Find(std::int64_t instance) {
  const auto found = workers_.find(instance);
  return found == workers_.end() ? nullptr : &found->second;
}

KnownWorker* WorkerRoster::FindProcess(const std::string& name, std::int32_t pid) {
  for (auto& [instance, worker] : workers_) {
    if (worker.name == name && worker.pid == pid) return &worker;
  }
  return nullptr;
}

void WorkerRoster::Remove(std::int64_t instance) {
  workers_.erase(instance);
  if (!departed_.insert(instance).second) return;
  departed_order_.push_back(instance);
  if (departed_order_.size() > kMaxDeparted) {
    departed_.erase(departed_order_.front());
    departed_order_.pop_front();
  }
}

}  // namespace knap
