// The page of a run that goes on: report.html with what is known before its end, and the news for a browser that has
// it open [docs/report.md]. What it shows is on the bus and in the run's files; two replays are simulated here, with
// the initial design and with the one that the latest batch ended at.
#pragma once

#include <cstdint>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "coordinator/report/report_source.h"
#include "coordinator/report/run_history.h"

namespace knap {

// Belongs to one thread at a time.
class LiveDocument {
 public:
  // What `source` points to outlives it. `make_test` names a design "initial" or "learned" and finds its rollouts' ids.
  LiveDocument(ReportSource source,
               std::function<ReportedTest(const std::string& name, const std::vector<double>& theta)> make_test);

  // `status`: MakeStatusJson, of the bus. Both throw as RunHistory::Read and RolloutModel::Record do.
  std::string MakePage(const nlohmann::ordered_json& status);
  // JSON: page/README.md's `live`, `learning`, `timeline`, `certificates`, and, where the browser has not seen the
  // latest design yet (`seen`: the version that it was given with it), `theta` and `replays`.
  std::string MakeNews(const nlohmann::ordered_json& status, const std::string& seen);

 private:
  void Update();
  nlohmann::ordered_json MakeLiveJson(const nlohmann::ordered_json& status) const;
  void AddHistory(nlohmann::ordered_json* data) const;

  ReportSource source_;
  std::function<ReportedTest(const std::string&, const std::vector<double>&)> make_test_;
  RunHistory history_;
  std::size_t events_seen_ = 0;
  std::string run_id_;          // of its present life, as on the bus
  std::int64_t version_ = 0;    // of the latest design: how many there were before it
  std::int64_t replayed_ = -1;  // version of replays_'s learned ones
  nlohmann::ordered_json bodies_ = nlohmann::ordered_json::object();  // with gravity and fixed_poses
  nlohmann::ordered_json initial_replays_, learned_replays_;
};

}  // namespace knap
