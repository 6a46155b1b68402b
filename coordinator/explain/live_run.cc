#include "coordinator/explain/live_run.h"

#include <algorithm>

#include "lcmtypes/wire/text.h"

namespace knap {

std::optional<LiveRun> FindLiveRun(const ClusterView& view, std::int64_t run_id) {
  const auto found = view.runs().find(run_id);
  if (found == view.runs().end() || found->second.status.state == run_status_t::kDone) return std::nullopt;
  LiveRun run;
  run.open = found->second.status.requests_open;
  run.workers = found->second.status.workers;
  for (const auto& [instance, worker] : view.workers()) {
    const worker_status_t& status = worker.status;
    if (status.run_id != run_id || status.state == worker_status_t::kStopping) continue;
    LiveWorker& heard = run.heard.emplace_back();
    heard.name = CleanText(status.name);
    heard.host = CleanText(status.host);
    heard.held = ParseIds(status.queue);
    heard.computes = !heard.held.empty() && heard.held.front() == MakeId(status.running);
    heard.step_fraction = status.step_fraction;
  }
  std::sort(run.heard.begin(), run.heard.end(),
            [](const LiveWorker& a, const LiveWorker& b) { return a.name < b.name; });
  return run;
}

}  // namespace knap
