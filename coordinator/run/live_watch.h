// A run that goes on, as a page for a browser: what is on the bus and in the run's folder, served from threads of its
// own. It listens as any bystander would, and takes nothing from the run but processor time.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <thread>

#include "coordinator/learning/problem.h"
#include "coordinator/report/live_document.h"
#include "coordinator/run_directory/run_directory.h"
#include "coordinator/watch/cluster_view.h"
#include "coordinator/watch/page_server.h"
#include "lcmtypes/wire/clock.h"
#include "lcmtypes/wire/run_key.h"
#include "lcmtypes/wire/transport.h"
#include "sim/rollout/rollout.h"
#include "sim/scenarios/scenario_files.h"

namespace knap {

class LiveWatch {
 public:
  // `run` has begun: its logs are there. `key_file`: empty for the public key. Throws std::runtime_error where the
  // address cannot be listened at or the network fails, and what MakeProblem and RolloutModel throw.
  LiveWatch(const ListenAddress& address, const LoadedScenario& scenario, const RunDirectory& run,
            const std::string& lcm_url, const std::string& key_file);
  ~LiveWatch();
  LiveWatch(const LiveWatch&) = delete;
  LiveWatch& operator=(const LiveWatch&) = delete;

  const std::string& url() const { return server_->url(); }

  // The run has ended and has its report: whoever has the page open gets that in its place. Waits until one has it,
  // where one has asked within the last minute; a minute at the most.
  void HandOver(const std::filesystem::path& report);

 private:
  void Listen();  // until stop_
  nlohmann::ordered_json MakeStatus();
  std::string ServePage();
  std::string ServeNews(const std::string& seen);

  SteadyClock clock_;
  RunDirectory run_;
  Problem problem_;
  RolloutModel model_;

  std::mutex view_mutex_;
  ClusterView view_;
  std::mutex document_mutex_;
  LiveDocument document_;

  std::mutex readers_mutex_;
  std::condition_variable changed_;
  std::int64_t asked_us_ = -1;                   // when a browser last asked for news; negative: none has
  std::optional<std::filesystem::path> report_;  // it is there
  bool handed_over_ = false;

  std::unique_ptr<Transport> transport_;
  std::atomic<bool> stop_ = false;
  std::unique_ptr<PageServer> server_;
  std::thread listener_;
};

}  // namespace knap
