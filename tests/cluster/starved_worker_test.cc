// Real workers that lack memory or processor time: others do their work, or the run ends with the reason.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "coordinator/dispatch/dispatcher.h"
#include "coordinator/local_workers.h"
#include "coordinator/run_directory/temporary_folder.h"
#include "lcmtypes/wire/lcm_transport.h"
#include "tests/cluster/child_process.h"
#include "tests/cluster/run_files.h"
#include "tests/support/own_lcm_url.h"
#include "tests/worker/closed_form_engine.h"

namespace knap {
namespace starved_worker_test {

using ::testing::AllOf;
using ::testing::HasSubstr;

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kMemoryCanBeLimited = false;  // the sanitizers reserve terabytes of address space
#else
constexpr bool kMemoryCanBeLimited = true;
#endif

constexpr int kNeeded_mb = 1024, kAllowed_mb = 768;  // of address space; a worker alone takes less than 400

// Workers of the closed-form engine whose every rollout asks for kNeeded_mb.
class HungryCluster : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!kMemoryCanBeLimited) GTEST_SKIP() << "address space cannot be limited under a sanitizer";
    key_.WriteFile(folder_ / "key");
    DispatchOptions options;
    options.run_id = 4712;
    options.engine = ClosedFormEngine().identity();
    options.no_worker_s = 3.0;
    dispatcher_ = std::make_unique<Dispatcher>(options, key_, scenario_, &transport_, &clock_);
  }

  // `kilobytes`: of address space that it may have; 0: as much as it likes.
  std::unique_ptr<ChildProcess> StartWorker(const std::string& name, int kilobytes) {
    const std::string limit = kilobytes > 0 ? fmt::format("ulimit -v {}; ", kilobytes) : "";
    return std::make_unique<ChildProcess>(
        "/bin/bash",
        std::vector<std::string>{
            "-c", fmt::format("{}exec '{}' --lcm-url '{}' --key '{}' --name {}", limit,
                              FindWorkerProgram("knap-test-worker"), url_, (folder_ / "key").string(), name)},
        folder_ / "", name);
  }

  static std::vector<RolloutQuery> MakeQueries() {
    std::vector<RolloutQuery> queries(40);
    for (std::size_t i = 0; i < queries.size(); ++i) queries[i].theta = {0.1 * static_cast<double>(i), 1.0, 2.0, 3.0};
    return queries;
  }

  const TemporaryFolder folder_;
  const std::string url_ = MakeOwnLcmUrl();
  const RunKey key_ = RunKey::MakeRandom();
  const SteadyClock clock_{};
  const ScenarioFiles scenario_ = {
      {"scenario.txt", fmt::format("dimension 4\nsteps 10\nstep_us 1000\nallocate_mb {}\n", kNeeded_mb)}};
  LcmTransport transport_{url_, Dispatcher::ListChannels(), &clock_};
  std::unique_ptr<Dispatcher> dispatcher_;
};

TEST_F(HungryCluster, AStarvedWorkerAmongHealthyOnesChangesNoBit) {
  const auto starved = StartWorker("starved", kAllowed_mb << 10);
  const auto healthy = StartWorker("healthy", 0), sound = StartWorker("sound", 0);
  while (dispatcher_->CountUsableWorkers() < 3) dispatcher_->Pump(0.01);
  const std::vector<RolloutQuery> queries = MakeQueries();
  const std::vector<RolloutOutcome> outcomes = dispatcher_->Evaluate(queries);
  const auto reference = ClosedFormEngine().Load({{"scenario.txt", "dimension 4\nsteps 10\n"}});
  for (std::size_t i = 0; i < queries.size(); ++i) {
    const EngineAnswer expected =
        reference->Run({queries[i].theta, {}, {}, {}, true}, [](std::int64_t, std::int64_t) {});
    EXPECT_EQ(outcomes[i].loss, expected.loss) << i;
    EXPECT_EQ(outcomes[i].gradient, expected.gradient) << i;
  }
  EXPECT_EQ(starved->Wait(), 1);
  EXPECT_EQ(starved->ReadErr(), "knap-worker: leaves: out of memory\n");
  EXPECT_EQ(dispatcher_->counters().workers_lacking, 1);
  EXPECT_EQ(dispatcher_->counters().workers_lost, 0);
  dispatcher_->StopWorkers(600.0);
  EXPECT_EQ(healthy->Wait(), 0);
  EXPECT_EQ(sound->Wait(), 0);
}

// The coordinator's own workers, all of them starved: each is started again, but not in a tight loop, and the run ends
// with the reason.
TEST_F(HungryCluster, WhenAllOwnWorkersAreStarvedTheRunEndsWithTheReason) {
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_AS, &before), 0);
  const rlimit low{rlim_t{kAllowed_mb} << 20, before.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_AS, &low), 0);  // they inherit it
  LocalWorkerOptions options;
  options.count = 2;
  options.program = FindWorkerProgram("knap-test-worker");
  options.lcm_url = url_;
  options.key_file = folder_ / "key";
  options.log_directory = folder_ / "";
  std::string line;
  int restarts = 0;
  {
    LocalWorkers workers(options, &clock_, [this](const std::string& name, pid_t pid, DeathCause cause) {
      EXPECT_EQ(cause, DeathCause::kOutside);
      dispatcher_->ReportDeath(name, pid, cause);
    });
    dispatcher_->set_on_pump([&] { workers.Poll(); });
    try {
      dispatcher_->Evaluate(MakeQueries());
    } catch (const std::runtime_error& e) {  // NoWorkers, or every worker given up: whichever comes first
      line = e.what();
    }
    restarts = workers.restarts();
  }
  setrlimit(RLIMIT_AS, &before);
  EXPECT_THAT(line, AllOf(HasSubstr("local-"), HasSubstr("out of memory")));
  EXPECT_LE(restarts, 2 * 12);  // pauses of 20 ms that double: twelve of them last longer than the run
}

// `knap learn` with one worker that may use one second of processor time. When it has left the others come.
TEST(StarvedLearnTest, AWorkerOutOfProcessorTimeLeavesAndTheOthersEndWithTheSameBits) {
  const TemporaryFolder folder;
  RunKey::MakeRandom().WriteFile(folder / "key");
  const std::string url = MakeOwnLcmUrl();
  const auto learn = [&](const std::string& out, const std::vector<std::string>& more) {
    std::vector<std::string> arguments = {"learn",
                                          KNAP_SOURCE_DIR "/configs/pushing.yaml",
                                          "learning.variations=8",
                                          "learning.batch=4",
                                          "learning.max_evaluations=4",
                                          "evaluation.variations=6",
                                          "--out",
                                          out};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return std::make_unique<ChildProcess>(KNAP_PROGRAM, arguments, folder / "", out + "-log");
  };
  const auto start = [&](const std::string& name, const std::string& limit) {
    const std::string command =
        fmt::format("{}exec '{}' --lcm-url '{}' --key key --name {}", limit, KNAP_WORKER, url, name);
    return std::make_unique<ChildProcess>("/bin/bash", std::vector<std::string>{"-c", command}, folder / "", name);
  };
  const auto reference = learn("reference", {"--workers", "1"});
  ASSERT_EQ(reference->Wait(), 0) << reference->ReadErr();

  const auto starved = start("starved", "ulimit -S -t 1; ");
  const auto run = learn("run", {"--external", "--lcm-url", url, "--key", "key", "--wait", "600"});
  EXPECT_EQ(starved->Wait(), 1);
  EXPECT_EQ(starved->ReadErr(), "knap-worker: leaves: out of processor time (RLIMIT_CPU)\n");
  const auto first = start("first", ""), second = start("second", "");
  ASSERT_EQ(run->Wait(), 0) << run->ReadErr();
  ExpectSameRun(folder / "run", folder / "reference");
  EXPECT_THAT(ReadText(folder / "run/events.jsonl"), HasSubstr("worker_left"));
  // The run has told the workers that others started for it to stop.
  EXPECT_EQ(first->Wait(), 0);
  EXPECT_EQ(second->Wait(), 0);
}

}  // namespace starved_worker_test
}  // namespace knap
