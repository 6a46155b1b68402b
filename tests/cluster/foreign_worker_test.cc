// Workers in other languages, written after docs/protocol.md alone, answer like their twin in C++, to the last bit.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <filesystem>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "coordinator/dispatch/dispatcher.h"
#include "coordinator/run_directory/temporary_folder.h"
#include "lcmtypes/wire/lcm_transport.h"
#include "tests/cluster/child_process.h"
#include "tests/cluster/run_files.h"
#include "tests/support/own_lcm_url.h"
#include "tests/support/wait_for.h"
#include "tests/worker/bowl_engine.h"

namespace knap {
namespace foreign_worker_test {

using ::testing::Each;
using ::testing::HasSubstr;

const std::string kBin = KNAP_BIN "/";

// The parameter: the language.
class ForeignWorkerTest : public ::testing::TestWithParam<std::string> {
 protected:
  ForeignWorkerTest() { RunKey(key_).WriteFile(folder_ / "key"); }

  // `fails`: what Python's raises in every rollout.
  std::unique_ptr<ChildProcess> StartForeign(const std::string& name, int step_us = 0, const std::string& fails = "") {
    std::vector<std::string> command;
#ifdef KNAP_JAVA
    if (GetParam() == "Java") {
      command = {KNAP_JAVA,
                 "-XX:TieredStopAtLevel=1",
                 "-Xshare:auto",
                 "-Djava.net.preferIPv4Stack=true",
                 "-cp",
                 KNAP_LCM_JAR ":" KNAP_BIN "/knap_types.jar:" KNAP_BIN "/knap_java_worker.jar",
                 "knap.worker.JavaWorker",
                 url_,
                 folder_ / "key",
                 name,
                 std::to_string(step_us)};
    }
#endif
#ifdef KNAP_PYTHON
    if (GetParam() == "Python") {
      command = {"PYTHONPATH=" KNAP_BIN "/python:" KNAP_SOURCE_DIR "/worker/python",
                 "PYTHONDONTWRITEBYTECODE=1",
                 "KNAP_STEP_US=" + std::to_string(step_us),
                 "KNAP_FAILS=" + fails,
                 KNAP_PYTHON,
                 KNAP_SOURCE_DIR "/tests/worker/python/bowl_worker.py",
                 "--lcm-url",
                 url_,
                 "--key",
                 folder_ / "key",
                 "--name",
                 name};
    }
#endif
    return std::make_unique<ChildProcess>("/usr/bin/env", command, folder_ / "", name);
  }

  std::unique_ptr<ChildProcess> StartCpp(const std::string& program, const std::string& name) {
    return std::make_unique<ChildProcess>(
        kBin + program, std::vector<std::string>{"--lcm-url", url_, "--key", folder_ / "key", "--name", name},
        folder_ / "", name);
  }

  // A small Pushing run of which nothing but bounds and variations matters to the engine `bowl`.
  std::vector<std::string> MakeLearnArguments(const std::string& out, const std::string& engine,
                                              const std::string& wait = "600") {
    return {"learn",
            KNAP_SOURCE_DIR "/configs/pushing.yaml",
            "rollout.step=10 ms",
            "learning.variations=12",
            "learning.batch=4",
            "evaluation.variations=20",
            "--external",
            "--engine",
            engine,
            "--lcm-url",
            url_,
            "--key",
            folder_ / "key",
            "--wait",
            wait,
            "--out",
            out};
  }

  void Learn(const std::string& out) {
    ChildProcess knap(kBin + "knap", MakeLearnArguments(out, "bowl"), folder_ / "", out + "-log");
    ASSERT_EQ(knap.Wait(), 0) << knap.ReadErr();
  }

  const std::string url_ = MakeOwnLcmUrl();
  const RunKey key_ = RunKey::MakeRandom();
  TemporaryFolder folder_;
};

std::vector<double> MakeRamp(std::size_t size, double scale) {
  std::vector<double> values(size);
  for (std::size_t i = 0; i < size; ++i) values[i] = scale * (0.3 + static_cast<double>(i) / 7.0);
  return values;
}

TEST_P(ForeignWorkerTest, AnswersEveryKindOfRequestLikeItsTwin) {
  SteadyClock clock;
  LcmTransport transport(url_, Dispatcher::ListChannels(), &clock);
  DispatchOptions options;
  options.run_id = 99;
  options.engine.name = "bowl";
  options.no_worker_s = 600.0;  // a language's machine takes its time where others work
  options.control_size = 3;     // of every theta below; the twin takes all as design
  // A scenario of 100 pieces: the worker has to fetch it in several rounds.
  Dispatcher dispatcher(options, key_, {{"scenario.yaml", std::string(100'000, 's')}}, &transport, &clock);
  std::set<std::string> answered_by;
  dispatcher.set_on_result([&](const RolloutReport& report) { answered_by.insert(report.worker); });
  const auto foreign = StartForeign("foreign");
  const auto other = StartCpp("knap-test-worker", "other-engine");
  ASSERT_TRUE(WaitFor([&] {
    dispatcher.Pump(0.01);
    return dispatcher.counters().other_engine > 0;
  }));

  std::vector<RolloutQuery> queries;
  for (std::size_t i = 0; i < 30; ++i) {
    queries.push_back({MakeRamp(7, 0.001 * static_cast<double>(i)), {}, MakeRamp(2, -0.02), true});
  }
  queries.push_back({MakeRamp(7, 1.0), MakeRamp(7, 0.9), {}, true});      // distillation
  queries.push_back({MakeRamp(7, 1.0), {}, {}, false});                   // loss alone
  queries.push_back({MakeRamp(150, 1.0), {}, MakeRamp(100, 0.5), true});  // both ways in several parts
  queries.push_back({MakeRamp(96, 1.0), MakeRamp(96, 2.0), {}, true});    // exactly whole parts
  const std::vector<RolloutOutcome> outcomes = dispatcher.Evaluate(queries);

  const auto twin = BowlEngine().Load({});
  for (std::size_t i = 0; i < queries.size(); ++i) {
    const RolloutQuery& q = queries[i];
    const EngineAnswer expected =
        twin->Run({q.theta, {}, q.theta_reference, q.variation, q.gradient}, [](std::int64_t, std::int64_t) {});
    EXPECT_EQ(outcomes[i].loss, expected.loss) << "query " << i;
    EXPECT_NE(outcomes[i].loss, 0.0) << "query " << i;
    EXPECT_EQ(outcomes[i].gradient, expected.gradient) << "query " << i;
    EXPECT_EQ(outcomes[i].success, expected.success) << "query " << i;
    EXPECT_EQ(outcomes[i].steps, expected.steps) << "query " << i;
  }
  EXPECT_EQ(answered_by, (std::set<std::string>{"foreign"}));  // answers of other engines are never taken
  EXPECT_EQ(dispatcher.counters().refused.total(), 0);

  dispatcher.StopWorkers(600.0);
  EXPECT_EQ(foreign->Wait(), 0) << foreign->ReadErr();
}

TEST_P(ForeignWorkerTest, LearnsTheSameBitsAsItsTwin) {
  {
    const auto twin = StartCpp("knap-bowl-worker", "twin");
    Learn("cpp");
  }
  {
    const auto foreign = StartForeign("foreign");
    Learn("foreign");
    foreign->Signal(SIGTERM);
    EXPECT_EQ(foreign->Wait(), 0) << foreign->ReadErr();
  }
  ExpectSameRun(folder_ / "foreign", folder_ / "cpp");
  EXPECT_THAT(ReadCsv(folder_ / "foreign/rollouts.csv")["worker"], Each("foreign"));
  EXPECT_THAT(ReadCsv(folder_ / "cpp/rollouts.csv")["worker"], Each("twin"));
}

TEST_P(ForeignWorkerTest, KilledInTheMiddleItIsReplacedByItsTwin) {
  // 100 steps of 300 us: it is at work when it dies, and what it held goes to the twin, which starts then.
  auto foreign = StartForeign("foreign", 300);
  ChildProcess knap(kBin + "knap", MakeLearnArguments("mixed", "bowl"), folder_ / "", "mixed-log");
  ASSERT_TRUE(WaitFor([&] { return knap.HasEnded() || ReadCsv(folder_ / "mixed/rollouts.csv")["id"].size() >= 5; }));
  foreign->Signal(SIGKILL);
  const auto twin = StartCpp("knap-bowl-worker", "twin");
  ASSERT_EQ(knap.Wait(), 0) << knap.ReadErr();
  const std::vector<std::string> workers = ReadCsv(folder_ / "mixed/rollouts.csv")["worker"];
  EXPECT_EQ(std::set<std::string>(workers.begin(), workers.end()), (std::set<std::string>{"foreign", "twin"}));
  EXPECT_EQ(twin->Wait(), 0);  // the run told it to stop
  const auto next = StartCpp("knap-bowl-worker", "next");
  Learn("cpp");
  ExpectSameRun(folder_ / "mixed", folder_ / "cpp");
}

TEST_P(ForeignWorkerTest, GetsNoWorkOfAnotherEngine) {
  const auto foreign = StartForeign("foreign");
  ChildProcess knap(kBin + "knap", MakeLearnArguments("run", "another", "2"), folder_ / "", "log");
  EXPECT_EQ(knap.Wait(), 4) << knap.ReadErr();
  ChildProcess resumed(
      kBin + "knap",
      {"learn", "--resume", "run", "--external", "--engine", "bowl", "--lcm-url", url_, "--key", folder_ / "key"},
      folder_ / "", "resumed");
  EXPECT_EQ(resumed.Wait(), 2);
  EXPECT_THAT(resumed.ReadErr(), HasSubstr("belongs to a run with another engine (another, not bowl)"));
  ChildProcess own(kBin + "knap", {"learn", KNAP_SOURCE_DIR "/configs/pushing.yaml", "--engine", "bowl"}, folder_ / "",
                   "own");
  EXPECT_EQ(own.Wait(), 2);
  EXPECT_THAT(own.ReadErr(), HasSubstr("--external"));
}

TEST_P(ForeignWorkerTest, WhatAnEngineRaisesIsToldApart) {
  if (GetParam() != "Python") GTEST_SKIP() << "the worker in Java knows no failure";
  const auto refuses = StartForeign("refuses", 0, "refuses");
  ChildProcess ended(kBin + "knap", MakeLearnArguments("refused", "bowl"), folder_ / "", "refused-log");
  EXPECT_EQ(ended.Wait(), 1);
  EXPECT_THAT(ended.ReadErr(), HasSubstr("a bowl [31m without a bottom"));
  refuses->Signal(SIGTERM);
  EXPECT_EQ(refuses->Wait(), 0) << refuses->ReadErr();

  const auto lacks = StartForeign("lacks", 0, "lacks");
  ChildProcess knap(kBin + "knap", MakeLearnArguments("run", "bowl"), folder_ / "", "log");
  EXPECT_EQ(lacks->Wait(), 1);
  EXPECT_THAT(lacks->ReadErr(), HasSubstr("lacks: leaves: MemoryError: no room for a bowl"));
  const auto twin = StartCpp("knap-bowl-worker", "twin");  // takes over
  EXPECT_EQ(knap.Wait(), 0) << knap.ReadErr();
}

std::vector<std::string> ListLanguages() {
  std::vector<std::string> languages;
#ifdef KNAP_JAVA
  languages.emplace_back("Java");
#endif
#ifdef KNAP_PYTHON
  languages.emplace_back("Python");
#endif
  return languages;
}

INSTANTIATE_TEST_SUITE_P(Languages, ForeignWorkerTest, ::testing::ValuesIn(ListLanguages()),
                         [](const auto& tested) { return tested.param; });

}  // namespace foreign_worker_test
}  // namespace knap
