// Real worker processes over real LCM: right answers whoever dies.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "coordinator/dispatch/dispatcher.h"
#include "coordinator/learning/schedule.h"
#include "coordinator/local_workers.h"
#include "lcmtypes/wire/lcm_transport.h"
#include "tests/support/own_lcm_url.h"
#include "tests/support/wait_for.h"
#include "tests/worker/closed_form_engine.h"

namespace knap {
namespace cluster_test {

using ::testing::AllOf;
using ::testing::HasSubstr;

class Quiet : public LearningObserver {
 public:
  void OnBatchStart(const BatchStart&) override {}
  void OnEvaluation(const LearningEvaluation&) override {}
  void OnBatchBox(const BatchBox&) override {}
  void OnBatchEnd(const BatchEnd&) override {}
};

class Cluster {
 public:
  // Each step of a rollout takes step_us; a rollout has 10.
  Cluster(int workers, int step_us, const std::string& more_scenario = "", DispatchOptions options = {},
          const std::string& mesh = "")
      : directory_(std::filesystem::temp_directory_path() / fmt::format("knap-cluster-{}-{}", getpid(), ++count_)) {
    std::filesystem::create_directories(directory_);
    key_ = RunKey::MakeRandom();
    key_.WriteFile(directory_ / "key");
    scenario_["scenario.txt"] = fmt::format("dimension 4\nsteps 10\nstep_us {}\n{}", step_us, more_scenario);
    if (!mesh.empty()) scenario_["mesh.stl"] = mesh;
    options.run_id = 4711;
    options.engine = ClosedFormEngine().identity();
    transport_ = std::make_unique<LcmTransport>(url_, Dispatcher::ListChannels(), &clock_);
    dispatcher_ = std::make_unique<Dispatcher>(options, key_, scenario_, transport_.get(), &clock_);
    LocalWorkerOptions worker_options;
    worker_options.count = workers;
    worker_options.program = FindWorkerProgram("knap-test-worker");
    worker_options.lcm_url = url_;
    worker_options.key_file = directory_ / "key";
    worker_options.log_directory = directory_;
    workers_ = std::make_unique<LocalWorkers>(
        worker_options, &clock_,
        [this](const std::string& name, pid_t pid, DeathCause cause) { dispatcher_->ReportDeath(name, pid, cause); });
    dispatcher_->set_on_pump([this] { workers_->Poll(); });
    dispatcher_->set_on_stalled([this](const KnownWorker& worker) { workers_->Kill(worker.name, worker.pid); });
    dispatcher_->set_on_result([this](const RolloutReport& report) {
      answered_by.insert(report.worker);
      if (on_answer) on_answer(report.worker);
    });
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
          loaded->Run({queries[i].theta, {}, queries[i].theta_reference, queries[i].variation, queries[i].gradient},
                      [](std::int64_t, std::int64_t) {});
      EXPECT_EQ(outcomes[i].loss, expected.loss) << "query " << i;
      EXPECT_EQ(outcomes[i].gradient, expected.gradient) << "query " << i;
    }
  }

  // Waits until this many workers have joined and loaded.
  void WaitForWorkers(int count) {
    ASSERT_TRUE(PumpUntil([&] { return dispatcher_->CountUsableWorkers() >= count; })) << "workers do not come";
  }

  bool PumpUntil(const std::function<bool()>& condition) {
    return WaitFor([&] {
      dispatcher_->Pump(0.01);
      return condition();
    });
  }

  // How many requests the dispatcher believes a worker to hold; none when it does not know it.
  std::size_t CountHeld(const std::string& name) const {
    const std::map<std::int64_t, Holding>& holdings = dispatcher_->requests().holdings;
    for (const auto& [instance, worker] : dispatcher_->roster().workers()) {
      if (worker.name != name || worker.silent) continue;
      const auto held = holdings.find(instance);
      return held == holdings.end() ? 0 : held->second.ids.size();
    }
    return 0;
  }

  // Evaluates, always something new, until the condition holds: the faster the machine, the more often.
  void EvaluateUntil(const std::function<bool()>& condition, int queries) {
    int rounds = 0;
    ASSERT_TRUE(WaitFor([&] {
      EvaluateAndCheck(MakeQueries(queries, 1000.0 * ++rounds));
      return condition() || ::testing::Test::HasFailure();
    }));
  }

  std::function<void(const std::string& worker)> on_answer;
  std::set<std::string> answered_by;
  Dispatcher& dispatcher() { return *dispatcher_; }
  LocalWorkers& workers() { return *workers_; }
  const std::string& url() const { return url_; }
  std::string key_file() const { return directory_ / "key"; }

 private:
  static inline int count_ = 0;
  std::string url_ = MakeOwnLcmUrl();
  std::filesystem::path directory_;
  SteadyClock clock_;
  RunKey key_;
  std::map<std::string, std::string> scenario_;
  std::unique_ptr<LcmTransport> transport_;
  std::unique_ptr<Dispatcher> dispatcher_;
  std::unique_ptr<LocalWorkers> workers_;
};

// Nobody is believed gone or stuck only because the machine is busy with something else.
DispatchOptions MakePatientOptions() {
  DispatchOptions options;
  options.lease_s = options.no_worker_s = 600.0;
  return options;
}

TEST(ClusterTest, TenQueriesKeepTwoWorkersBusy) {
  Cluster cluster(2, 5000, "", MakePatientOptions());
  cluster.WaitForWorkers(2);
  int busy = 0;  // when the first answer came
  cluster.on_answer = [&](const std::string& worker) {
    if (cluster.answered_by != std::set<std::string>{worker} || busy > 0) return;
    for (const char* name : {"local-1", "local-2"}) busy += cluster.CountHeld(name) > 0 ? 1 : 0;
  };
  cluster.EvaluateAndCheck(Cluster::MakeQueries(10));
  EXPECT_EQ(busy, 2);
}

// A worker started by hand, as with --external: nobody starts it again.
class HandWorker {
 public:
  explicit HandWorker(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), FindWorkerProgram("knap-test-worker"));
    std::vector<char*> words;
    for (std::string& argument : arguments) words.push_back(argument.data());
    words.push_back(nullptr);
    pid_ = fork();
    if (pid_ == 0) {
      execv(words[0], words.data());
      _exit(127);
    }
  }
  ~HandWorker() {
    kill(pid_, SIGKILL);
    if (!waited_) waitpid(pid_, nullptr, 0);
  }
  HandWorker(const HandWorker&) = delete;
  HandWorker& operator=(const HandWorker&) = delete;

  void Signal(int signal) const { kill(pid_, signal); }
  pid_t pid() const { return pid_; }
  int WaitForExitCode() {
    int status = 0;
    waitpid(pid_, &status, 0);
    waited_ = true;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }

 private:
  pid_t pid_ = 0;
  bool waited_ = false;
};

TEST(ClusterTest, KilledWorkersChangeNothing) {
  // local-1 lives on; local-2 is killed at every third answer, with more in its hands, and started again.
  Cluster cluster(2, 5000);
  HandWorker mortal({"--lcm-url", cluster.url(), "--key", cluster.key_file(), "--name", "mortal"});  // dies for good
  cluster.WaitForWorkers(3);
  int answers = 0;
  cluster.on_answer = [&](const std::string& worker) {
    if (worker == "mortal") mortal.Signal(SIGKILL);
    if (worker != "local-2" || ++answers % 3 != 0 || cluster.CountHeld(worker) == 0) return;
    const std::vector<pid_t> processes = cluster.workers().ListProcesses();
    if (processes.size() == 2) kill(processes[1], SIGKILL);
  };
  cluster.EvaluateUntil(
      [&] {
        const DispatchCounters& counters = cluster.dispatcher().counters();
        return cluster.answered_by.size() == 3 && cluster.workers().restarts() >= 2 && counters.workers_lost >= 3 &&
               counters.reissued >= 3;
      },
      30);
  EXPECT_EQ(cluster.answered_by, (std::set<std::string>{"local-1", "local-2", "mortal"}));
}

// How long that takes is DispatcherTest's, by a simulated clock.
TEST(ClusterTest, FrozenWorkersRequestsGoToOthers) {
  Cluster cluster(1, 5000);
  HandWorker frozen({"--lcm-url", cluster.url(), "--key", cluster.key_file(), "--name", "frozen"});
  cluster.WaitForWorkers(2);
  bool stopped = false;
  cluster.on_answer = [&](const std::string&) {
    if (stopped || cluster.CountHeld("frozen") == 0) return;
    frozen.Signal(SIGSTOP);
    stopped = true;
  };
  cluster.EvaluateUntil([&] { return stopped; }, 8);
  const DispatchCounters& counters = cluster.dispatcher().counters();
  EXPECT_GE(counters.reissued + counters.moved + counters.copied, 1);
  frozen.Signal(SIGCONT);  // it comes back, its late answers agree, and it works on
  cluster.WaitForWorkers(2);
  cluster.answered_by.clear();
  cluster.EvaluateUntil([&] { return cluster.answered_by.count("frozen") == 1; }, 8);
}

TEST(ClusterTest, RequestThatCrashesWorkersIsPoison) {
  Cluster cluster(2, 1000, "crash_at 666\n");
  cluster.WaitForWorkers(2);
  auto queries = Cluster::MakeQueries(5);
  queries[2].variation = {666.0};
  const std::string id = FormatHex(cluster.dispatcher().CalcId(queries[2]));
  try {
    cluster.dispatcher().Evaluate(queries);
    FAIL() << "nothing was thrown";
  } catch (const std::runtime_error& e) {
    EXPECT_THAT(e.what(), AllOf(HasSubstr("poison"), HasSubstr(id)));
  }
  queries.erase(queries.begin() + 2);
  cluster.EvaluateAndCheck(queries);  // the cluster lives on
}

TEST(ClusterTest, HangingRequestIsTakenAwayAndItsWorkerKilled) {
  DispatchOptions options;
  options.stall_s = 2.0;
  Cluster cluster(2, 1000, "hang_at 13\n", options);
  cluster.WaitForWorkers(2);
  auto queries = Cluster::MakeQueries(3);
  queries[1].variation = {13.0};
  const std::string id = FormatHex(cluster.dispatcher().CalcId(queries[1]));
  try {
    cluster.dispatcher().Evaluate(queries);
    FAIL() << "nothing was thrown";
  } catch (const std::runtime_error& e) {
    EXPECT_THAT(e.what(), AllOf(HasSubstr("no progress"), HasSubstr(id)));
  }
  EXPECT_GE(cluster.dispatcher().counters().workers_stalled, 3);
  EXPECT_GE(cluster.workers().restarts(), 1);
}

TEST(ClusterTest, LargeScenarioReachesWorkers) {
  // 300 KB in pieces of 1 KB to three workers at once.
  Cluster cluster(3, 0, "", {}, std::string(300'000, 'm'));
  cluster.EvaluateAndCheck(Cluster::MakeQueries(6));
}

// Four design parameters and 120 controls, as many as Reaching has, optimised jointly: requests and answers of two
// parts each. The optimum of the closed form is known: x_i = i / 10.
TEST(ClusterTest, DesignAndControlsAreOptimisedJointly) {
  Problem problem;
  ParameterSpec& spec = problem.parameters;
  spec.controls = 120;
  for (std::size_t i = 0; i < 124; ++i) {
    spec.names.push_back(i < 4 ? fmt::format("design{}", i) : fmt::format("control[{}][{}]", (i - 4) / 4, i % 4));
    spec.lower.push_back(-1.0);
    spec.upper.push_back(14.0);
    spec.initial.push_back(0.0);
  }
  LearningOptions learning;
  learning.method = LearningMethod::kDiffHand;
  learning.variations = learning.batch = 1;
  learning.max_evaluations = 60;
  learning.loss_tolerance = learning.parameter_tolerance = 0.0;
  std::vector<double> learned;
  for (const int workers : {1, 2}) {
    DispatchOptions options;
    options.control_size = spec.controls;
    Cluster cluster(workers, 0, "controls 120\n", options);
    Quiet observer;
    const LearningResult result = Learn(problem, learning, cluster.dispatcher(), observer);
    for (std::size_t i = 0; i < 124; ++i) EXPECT_NEAR(result.theta[i], 0.1 * static_cast<double>(i), 1e-4) << i;
    if (workers == 1) learned = result.theta;
    EXPECT_EQ(result.theta, learned);
    EXPECT_EQ(cluster.dispatcher().counters().refused.total(), 0);
  }
}

TEST(ClusterTest, WorkersWithoutTheKeyGetNoWork) {
  DispatchOptions options;
  options.no_worker_s = 1.0;
  Cluster cluster(0, 0, "", options);
  HandWorker stranger({"--lcm-url", cluster.url(), "--name", "stranger"});
  ASSERT_TRUE(cluster.PumpUntil([&] { return cluster.dispatcher().counters().refused.corrupt >= 2; }));
  EXPECT_THROW(cluster.dispatcher().Evaluate(Cluster::MakeQueries(1)), NoWorkers);
}

TEST(ClusterTest, StopEndsEveryWorker) {
  Cluster cluster(0, 0, "", MakePatientOptions());
  HandWorker a({"--lcm-url", cluster.url(), "--key", cluster.key_file(), "--name", "a"});
  HandWorker b({"--lcm-url", cluster.url(), "--key", cluster.key_file(), "--name", "b"});
  cluster.WaitForWorkers(2);
  cluster.EvaluateAndCheck(Cluster::MakeQueries(4));
  cluster.dispatcher().StopWorkers(600.0);
  EXPECT_EQ(a.WaitForExitCode(), 0);
  EXPECT_EQ(b.WaitForExitCode(), 0);
}

TEST(ClusterTest, TerminatedWorkerSaysGoodbye) {
  Cluster cluster(1, 5000, "", MakePatientOptions());
  HandWorker leaver({"--lcm-url", cluster.url(), "--key", cluster.key_file(), "--name", "leaver"});
  cluster.WaitForWorkers(2);
  bool told = false;
  cluster.on_answer = [&](const std::string&) {
    if (!told) leaver.Signal(SIGTERM);
    told = true;
  };
  cluster.EvaluateAndCheck(Cluster::MakeQueries(8));
  EXPECT_EQ(leaver.WaitForExitCode(), 0);
  // Leases last longer than this test: only its goodbye takes it off the roster.
  EXPECT_TRUE(cluster.PumpUntil([&] { return cluster.dispatcher().CountUsableWorkers() == 1; }));
  EXPECT_EQ(cluster.dispatcher().counters().workers_lost, 0);
}

TEST(WorkerProgramTest, BadUsageExitsWithTwo) {
  EXPECT_EQ(HandWorker({"--nonsense"}).WaitForExitCode(), 2);
  EXPECT_EQ(HandWorker({"--name", "no spaces"}).WaitForExitCode(), 2);
  EXPECT_EQ(HandWorker({"--key", "/nowhere/key"}).WaitForExitCode(), 2);
  EXPECT_EQ(HandWorker({"--lcm-url", "udpm://1.2.3.4:5"}).WaitForExitCode(), 2);
}

}  // namespace cluster_test
}  // namespace knap
