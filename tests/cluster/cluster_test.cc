// Real worker processes over real LCM: right answers whoever dies.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "coordinator/dispatch/dispatcher.h"
#include "coordinator/local_workers.h"
#include "lcmtypes/wire/lcm_transport.h"
#include "lcmtypes/wire/multicast.h"
#include "tests/worker/closed_form_engine.h"

namespace knap {
namespace {

using ::testing::HasSubstr;

double ReadClock() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

class Cluster {
 public:
  // Each step of a rollout takes step_us; a rollout has 10.
  Cluster(int workers, int step_us, const std::string& more_scenario = "", DispatchOptions options = {})
      : directory_(std::filesystem::temp_directory_path() / fmt::format("knap-cluster-{}-{}", getpid(), ++count_)) {
    std::filesystem::create_directories(directory_);
    key_ = RunKey::MakeRandom();
    key_.WriteFile(directory_ / "key");
    scenario_["scenario.txt"] = fmt::format("dimension 4\nsteps 10\nstep_us {}\n{}", step_us, more_scenario);
    options.run_id = 4711;
    options.engine = "closed-form";
    const std::string url = MakeFreeLcmUrl();
    transport_ = std::make_unique<LcmTransport>(url, Dispatcher::ListChannels(), &clock_);
    dispatcher_ = std::make_unique<Dispatcher>(options, key_, scenario_, transport_.get(), &clock_);
    LocalWorkerOptions worker_options;
    worker_options.count = workers;
    worker_options.program = FindWorkerProgram("knap-test-worker");
    worker_options.lcm_url = url;
    worker_options.key_file = directory_ / "key";
    worker_options.log_directory = directory_;
    workers_ = std::make_unique<LocalWorkers>(worker_options, &clock_, [this](const std::string& name, pid_t pid, DeathCause cause) {
      dispatcher_->ReportDeath(name, pid, cause);
    });
    dispatcher_->set_on_pump([this] {
      if (on_pump) on_pump();
      if (restart) workers_->Poll();
    });
    dispatcher_->set_on_stalled([this](const KnownWorker& worker) { workers_->Kill(worker.name, worker.pid); });
    dispatcher_->set_on_result([this](const RolloutReport& report) { answered_by.insert(report.worker); });
  }
  ~Cluster() {
    workers_.reset();
    std::filesystem::remove_all(directory_);
  }

  static std::vector<RolloutQuery> MakeQueries(int count, double offset = 0.0) {
    std::vector<RolloutQuery> queries(static_cast<std::size_t>(count));
    for (std::size_t i = 0; i < queries.size(); ++i) {
      const double x = offset + static_cast<double>(i);
      queries[i].theta = {x, 0.1 * x, 1.0 - x, 0.5};
      queries[i].variation = {0.25 * x, 0.3};
    }
    return queries;
  }

  // Evaluates and compares every answer, bit for bit, with one computed in this process.
  void EvaluateAndCheck(const std::vector<RolloutQuery>& queries) {
    const std::vector<RolloutOutcome> outcomes = dispatcher_->Evaluate(queries);
    ClosedFormEngine engine;
    const auto loaded = engine.Load({{"scenario.txt", "dimension 4\nsteps 10\n"}});
    ASSERT_EQ(outcomes.size(), queries.size());
    for (std::size_t i = 0; i < queries.size(); ++i) {
      const EngineAnswer expected =
          loaded->Run({queries[i].theta, queries[i].theta_reference, queries[i].variation, queries[i].gradient},
                      [](std::int64_t, std::int64_t) {});
      EXPECT_EQ(outcomes[i].loss, expected.loss) << "query " << i;
      EXPECT_EQ(outcomes[i].gradient, expected.gradient) << "query " << i;
    }
  }

  // Waits until this many workers have joined and loaded.
  void WaitForWorkers(int count) {
    const double end = ReadClock() + 10.0;
    while (dispatcher_->CountUsableWorkers() < count) {
      ASSERT_LT(ReadClock(), end) << "workers do not come";
      dispatcher_->Pump(0.01);
    }
  }

  std::function<void()> on_pump;
  bool restart = true;
  std::set<std::string> answered_by;
  Dispatcher& dispatcher() { return *dispatcher_; }
  LocalWorkers& workers() { return *workers_; }
  LcmTransport& transport() { return *transport_; }

 private:
  static inline int count_ = 0;
  std::filesystem::path directory_;
  SteadyClock clock_;
  RunKey key_;
  std::map<std::string, std::string> scenario_;
  std::unique_ptr<LcmTransport> transport_;
  std::unique_ptr<Dispatcher> dispatcher_;
  std::unique_ptr<LocalWorkers> workers_;
};

TEST(ClusterTest, TenQueriesKeepTwoWorkersBusy) {
  Cluster cluster(2, 5000);
  cluster.WaitForWorkers(2);
  const double begin = ReadClock();
  cluster.EvaluateAndCheck(Cluster::MakeQueries(10));
  const double elapsed = ReadClock() - begin;
  EXPECT_EQ(cluster.answered_by.size(), 2u);
  // Ten sleeps of at least 50 ms on two workers; one worker alone would need 500 ms.
  EXPECT_GE(elapsed, 0.25);
  EXPECT_LT(elapsed, 0.45);
}

TEST(ClusterTest, KilledWorkersChangeNothing) {
  Cluster cluster(3, 5000);
  cluster.WaitForWorkers(3);
  cluster.restart = false;
  const std::vector<pid_t> processes = cluster.workers().ListProcesses();
  double next_kill = ReadClock() + 0.1;
  bool killed_for_good = false;
  cluster.on_pump = [&] {
    if (ReadClock() < next_kill) return;
    next_kill += 0.5;
    if (!killed_for_good) {
      // The first dies for good: restart stays off until it is the last one's turn again.
      kill(processes[0], SIGKILL);
      killed_for_good = true;
    } else {
      cluster.restart = true;
      const std::vector<pid_t> now = cluster.workers().ListProcesses();
      if (!now.empty()) kill(now.back(), SIGKILL);
    }
  };
  cluster.EvaluateAndCheck(Cluster::MakeQueries(120));
  EXPECT_GE(cluster.dispatcher().counters().workers_lost, 2);
  EXPECT_GE(cluster.dispatcher().counters().reissued, 1);
}

TEST(ClusterTest, StopEndsEveryWorker) {
  Cluster cluster(2, 0);
  cluster.WaitForWorkers(2);
  cluster.EvaluateAndCheck(Cluster::MakeQueries(4));
  cluster.restart = false;
  cluster.dispatcher().StopWorkers(2.0);
  EXPECT_EQ(cluster.dispatcher().CountUsableWorkers(), 0);
}

}  // namespace
}  // namespace knap
