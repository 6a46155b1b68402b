#include "coordinator/watch/cluster_view.h"

#include <algorithm>

#include "lcmtypes/wire/channels.h"

namespace knap {
namespace {

constexpr std::int64_t kRateWindowUs = 3'000'000;
constexpr std::int64_t kForgetUs = 30'000'000;

}  // namespace

double CalcAge(std::int64_t heard_us, std::int64_t now_us) {
  return static_cast<double>(std::max<std::int64_t>(0, now_us - heard_us)) * 1e-6;
}

double WatchedWorker::CalcRate() const {
  if (finished_then.size() < 2) return 0.0;
  const auto& [first_us, first] = finished_then.front();
  const auto& [last_us, last] = finished_then.back();
  return last_us > first_us ? static_cast<double>(last - first) / (static_cast<double>(last_us - first_us) * 1e-6)
                            : 0.0;
}

std::vector<std::string> ClusterView::ListChannels() {
  return {std::string(kRunStatusChannel), std::string(kWorkerStatusChannel)};
}

void ClusterView::Handle(const Message& message) {
  if (message.channel == kRunStatusChannel) {
    const auto status = Open<run_status_t>(message.bytes, key_, &refusals_);
    if (!status) return;
    WatchedRun& run = runs_[status->run_id];
    if (status->sequence < run.status.sequence) return;
    run.status = *status;
    run.heard_us = message.arrival_us;
  } else if (message.channel == kWorkerStatusChannel) {
    const auto status = Open<worker_status_t>(message.bytes, key_, &refusals_);
    if (!status) return;
    if (status->state == worker_status_t::kStopping) {
      workers_.erase(status->sender);
      return;
    }
    WatchedWorker& worker = workers_[status->sender];
    if (status->sequence < worker.status.sequence) return;
    worker.status = *status;
    worker.heard_us = message.arrival_us;
    worker.finished_then.emplace_back(message.arrival_us, status->finished);
    while (message.arrival_us - worker.finished_then.front().first > kRateWindowUs) worker.finished_then.pop_front();
  }
}

void ClusterView::Forget(std::int64_t now_us) {
  const auto is_old = [now_us](const auto& entry) { return now_us - entry.second.heard_us > kForgetUs; };
  std::erase_if(runs_, is_old);
  std::erase_if(workers_, is_old);
}

}  // namespace knap
