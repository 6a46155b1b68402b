// The program knap from outside: exit codes, files, and the promise of the same bits whoever dies.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "coordinator/run_directory/temporary_folder.h"
#include "knap/run_status_t.hpp"
#include "lcmtypes/wire/channels.h"
#include "lcmtypes/wire/codec.h"
#include "lcmtypes/wire/lcm_transport.h"
#include "sim/geometry/mesh_io.h"
#include "tests/cluster/child_process.h"
#include "tests/cluster/run_files.h"
#include "tests/cluster/short_runs.h"
#include "tests/support/own_lcm_url.h"
#include "tests/support/wait_for.h"

namespace knap {
namespace learn_test {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::MatchesRegex;
using ::testing::Not;
using Json = nlohmann::json;

const std::string kConfig = KNAP_SOURCE_DIR "/configs/pushing.yaml";

bool IsIn(const fs::path& path, const std::string& what) { return ReadText(path).find(what) != std::string::npos; }

class LearnTest : public ::testing::Test {
 protected:
  Ended Run(std::vector<std::string> arguments) {
    return RunToEnd(KNAP_PROGRAM, std::move(arguments), folder_ / "", "run");
  }

  void RunWell(std::vector<std::string> arguments) {
    const Ended ended = Run(std::move(arguments));
    ASSERT_EQ(ended.code, 0) << ended.err;
  }

  Json ReadResult(const std::string& run) { return Json::parse(ReadText(folder_ / run / "result.json")); }

  void ExpectSameRun(const std::string& run, const std::string& reference) {
    knap::ExpectSameRun(folder_ / run, folder_ / reference);
  }

  // The slow run as it goes when nobody disturbs it, made once for all tests that disturb theirs.
  void ExpectUndisturbedResult(const std::string& run) {
    static const TemporaryFolder folder;
    static const int code = ChildProcess(KNAP_PROGRAM, MakeSlowLearning("calm", {}), folder / "", "calm").Wait();
    ASSERT_EQ(code, 0);
    knap::ExpectSameRun(folder_ / run, folder / "calm");
  }

  // Waits until the run has made so many evaluations; false when it ended before.
  bool WaitForEvaluations(ChildProcess* knap, const std::string& run, std::size_t count) {
    const auto is_there = [&] { return ReadCsv(folder_ / run / "metrics.csv")["loss"].size() >= count; };
    return WaitFor([&] { return is_there() || knap->HasEnded(); }) && !knap->HasEnded();
  }

  // Kills workers as chosen from those that live, until `is_enough` or the run's end. `pace` new answers come between
  // two blows, so that the run gets on however slowly this machine computes, and is hit however fast it does.
  void KillWorkers(ChildProcess* knap, const std::string& run, std::size_t pace, const std::function<bool()>& is_enough,
                   const std::function<std::vector<pid_t>(const std::vector<pid_t>&)>& choose) {
    std::size_t answers = 0;
    ASSERT_TRUE(WaitFor([&] {
      if (knap->HasEnded() || is_enough()) return true;
      const std::size_t now = ReadCsv(folder_ / run / "rollouts.csv")["id"].size();
      if (now < answers + pace) return false;
      const std::vector<pid_t> workers = knap->ListChildren();
      if (workers.empty()) return false;
      answers = now;
      for (const pid_t worker : choose(workers)) kill(worker, SIGKILL);
      return false;
    }));
  }

  TemporaryFolder folder_;
};

TEST_F(LearnTest, SameBitsForAnyNumberOfWorkers) {
  RunWell(MakeShortRun("learn", "one", {"--workers", "1"}));
  RunWell(MakeShortRun("learn", "two", {"--workers", "2"}));
  RunWell(MakeShortRun("learn", "four", {"--workers", "4"}));
  ExpectSameRun("two", "one");
  ExpectSameRun("four", "one");
  const Json theta = ReadResult("one")["theta"];
  EXPECT_NE(theta["learned"], theta["initial"]);
}

TEST_F(LearnTest, KilledWorkersChangeNothing) {
  ChildProcess knap(KNAP_PROGRAM, MakeSlowLearning("stormy", {"--workers", "2"}), folder_ / "", "stormy_log");
  std::size_t kills = 0;
  const auto choose_by_turns = [&](const std::vector<pid_t>& workers) {
    return std::vector<pid_t>{workers[kills++ % workers.size()]};
  };
  KillWorkers(
      &knap, "stormy", 6, [] { return false; }, choose_by_turns);
  ASSERT_EQ(knap.Wait(), 0) << knap.ReadErr();
  EXPECT_GE(kills, 3u);
  const std::string events = ReadText(folder_ / "stormy/events.jsonl");
  EXPECT_THAT(events, AllOf(HasSubstr("workers_lost"), HasSubstr("workers_restarted")));
  ExpectUndisturbedResult("stormy");
}

TEST_F(LearnTest, ResumesAfterKillToTheSameBits) {
  {
    ChildProcess knap(KNAP_PROGRAM, MakeSlowLearning("torn", {"--workers", "2"}), folder_ / "", "torn_log");
    ASSERT_TRUE(WaitForEvaluations(&knap, "torn", 2)) << knap.ReadErr();
    // Workers die with work in their hands, so that there is something to be remembered.
    KillWorkers(
        &knap, "torn", 2, [&] { return IsIn(folder_ / "torn/events.jsonl", "requests_reissued"); },
        [](const std::vector<pid_t>& workers) { return workers; });
    ASSERT_TRUE(WaitForEvaluations(&knap, "torn", 4)) << knap.ReadErr();
    knap.Signal(SIGKILL);
    ASSERT_EQ(knap.Wait(), -SIGKILL);
  }
  ASSERT_FALSE(fs::exists(folder_ / "torn/result.json"));
  RunWell({"learn", "--resume", "torn", "--workers", "1"});
  ExpectUndisturbedResult("torn");
  EXPECT_THAT(ReadText(folder_ / "torn/events.jsonl"), MatchesRegex("(.|\n)*\"answers_from_journal\":[1-9](.|\n)*"));
  const Json first = ReadResult("torn");
  EXPECT_GE(first["rollouts"]["reissued"], 1);
  // A finished run can be asked again: everything comes from the journal, the time and what went wrong count on.
  RunWell({"learn", "--resume", "torn", "--workers", "1"});
  ExpectUndisturbedResult("torn");
  EXPECT_GT(ReadResult("torn")["wall_s"], first["wall_s"]);
  EXPECT_GE(ReadResult("torn")["rollouts"]["reissued"], first["rollouts"]["reissued"]);
  const std::vector<std::string> times = ReadCsv(folder_ / "torn/rollouts.csv")["time_s"];
  for (std::size_t i = 1; i < times.size(); ++i) EXPECT_LE(std::stod(times[i - 1]), std::stod(times[i]));
}

TEST_F(LearnTest, InterruptedRunIsSavedAndGoesOn) {
  {
    ChildProcess knap(KNAP_PROGRAM, MakeSlowLearning("broken_off", {}), folder_ / "", "broken_off_log");
    ASSERT_TRUE(WaitForEvaluations(&knap, "broken_off", 3)) << knap.ReadErr();
    const std::vector<pid_t> workers = knap.ListChildren();
    EXPECT_FALSE(workers.empty());
    knap.Signal(SIGINT);
    EXPECT_EQ(knap.Wait(), 130);
    EXPECT_THAT(knap.ReadErr(), HasSubstr("knap learn --resume broken_off"));
    for (const pid_t worker : workers) EXPECT_NE(kill(worker, 0), 0) << "worker " << worker << " still runs";
  }
  RunWell({"learn", "--resume", "broken_off"});
  ExpectUndisturbedResult("broken_off");
}

TEST_F(LearnTest, WritesTheWholeRunDirectory) {
  std::vector<std::string> arguments = MakeShortRun("learn", "", {"--json"});
  arguments.erase(std::find(arguments.begin(), arguments.end(), "--out"), arguments.end() - 1);
  const Ended ended = Run(arguments);
  ASSERT_EQ(ended.code, 0) << ended.err;
  const fs::path run = folder_ / "runs/latest";
  EXPECT_THAT(fs::read_symlink(run).string(), MatchesRegex("pushing-[0-9]{8}T[0-9]{6}Z"));
  for (const char* name : {"run.json", "journal", "rollouts.csv", "events.jsonl", "report.html"}) {
    EXPECT_GT(fs::file_size(run / name), 0u) << name;
  }
  const Json result = Json::parse(ReadText(run / "result.json"));
  EXPECT_EQ(Json::parse(ended.out), result);  // one document and nothing else
  EXPECT_EQ(result["schema"], 1);
  EXPECT_EQ(result["scenario"], "pushing");
  EXPECT_EQ(result["method"], "ours");
  EXPECT_EQ(result["seed"], 0);
  for (const char* name : {"names", "lower", "upper", "initial", "learned"}) {
    EXPECT_EQ(result["theta"][name].size(), 7u) << name;
  }
  EXPECT_EQ(result["test"]["variations"], 6);
  for (const char* design : {"initial", "learned"}) {
    for (const char* figure : {"loss_mean", "loss_std", "success_rate"}) {
      EXPECT_TRUE(result["test"][design][figure].is_number()) << design << " " << figure;
    }
  }
  EXPECT_GT(result["rollouts"]["total"], 12);
  EXPECT_EQ(result["rollouts"]["distinct"], ReadCsv(run / "rollouts.csv")["id"].size());
  EXPECT_GT(result["wall_s"], 0.0);

  const std::vector<std::string> times = ReadCsv(run / "metrics.csv")["time_s"];
  ASSERT_GE(times.size(), 4u);
  for (std::size_t i = 1; i < times.size(); ++i) EXPECT_LT(std::stod(times[i - 1]), std::stod(times[i]));

  for (const char* name : {"tool/initial.stl", "tool/learned.stl"}) {
    const TriangleMesh mesh = ReadMesh(name, ReadText(run / name), 1e-3);
    EXPECT_EQ(FindDefects(mesh).Describe(), "") << name;
    const Eigen::Vector3d size = CalcBoundingBox(mesh).sizes();
    EXPECT_GT(size.x(), 0.05) << name;  // a tool that fits a hand, if the unit is right
    EXPECT_LE(size.x(), 0.12 + 1e-6) << name;
  }
  EXPECT_NE(ReadText(run / "tool/initial.stl"), ReadText(run / "tool/learned.stl"));

  // The run's own configuration runs, and is the same problem.
  RunWell({"learn", "runs/latest/config.yaml", "--out", "again", "--quiet"});
  EXPECT_EQ(ReadResult("again")["theta"], result["theta"]);
  // And the run can be evaluated: the same figures on the same variations.
  const Ended evaluated = Run({"evaluate", "runs/latest", "--json", "--quiet"});
  ASSERT_EQ(evaluated.code, 0) << evaluated.err;
  EXPECT_EQ(evaluated.err, "");
  const Json test = Json::parse(evaluated.out)["designs"][0]["test"];
  EXPECT_EQ(test["success_rate"], result["test"]["learned"]["success_rate"]);
  EXPECT_EQ(test["loss_mean"], result["test"]["learned"]["loss_mean"]);
}

// What lcm-spy shows, from the first to the last state; that it is told every second is DispatcherTest's.
TEST_F(LearnTest, PublishesItsProgressOnLcm) {
  const RunKey key = RunKey::MakeRandom();
  key.WriteFile(folder_ / "key");
  const std::string url = MakeOwnLcmUrl();
  const SteadyClock clock;
  LcmTransport transport(url, {std::string(kRunStatusChannel)}, &clock);
  ChildProcess knap(KNAP_PROGRAM, MakeSlowLearning("run", {"--lcm-url", url, "--key", "key"}), folder_ / "", "log");
  std::vector<run_status_t> heard;
  RefusalCounters refused;
  ASSERT_TRUE(WaitFor([&] {
    while (const auto message = transport.Receive(0)) {
      const auto status = Open<run_status_t>(message->bytes, key, &refused);
      if (status) heard.push_back(*status);
    }
    return (!heard.empty() && heard.back().state == run_status_t::kDone) || (knap.HasEnded() && knap.Wait() != 0);
  }));
  ASSERT_EQ(knap.Wait(), 0) << knap.ReadErr();
  EXPECT_EQ(refused.total(), 0);
  ASSERT_GE(heard.size(), 2u);
  for (std::size_t i = 1; i < heard.size(); ++i) {
    EXPECT_GE(heard[i].progress, heard[i - 1].progress);
    EXPECT_GE(heard[i].state, heard[i - 1].state);
  }
  EXPECT_EQ(heard.back().state, run_status_t::kDone);
  EXPECT_EQ(heard.back().progress, 1.0);
  EXPECT_EQ(heard.back().theta.size(), 7u);
  EXPECT_EQ(heard.back().scenario, "pushing");
  EXPECT_EQ(static_cast<std::size_t>(heard.back().iteration), ReadCsv(folder_ / "run/metrics.csv")["loss"].size());
}

TEST_F(LearnTest, MethodAndSeedReachTheRun) {
  RunWell(MakeShortRun("learn", "other", {"--method", "simple_continual", "--seed", "7"}));
  const Json result = ReadResult("other");
  EXPECT_EQ(result["method"], "simple_continual");
  EXPECT_EQ(result["seed"], 7);
  EXPECT_THAT(ReadText(folder_ / "other/config.yaml"), HasSubstr("simple_continual"));
  EXPECT_THAT(ReadCsv(folder_ / "other/rollouts.csv")["kind"], AllOf(Contains("task"), Not(Contains("distillation"))));
}

TEST_F(LearnTest, EvaluateTakesDesignsByName) {
  const std::vector<std::string> quick = {
      "evaluate", kConfig, "rollout.horizon=2 s", "rollout.step=4 ms", "--variations", "3", "--json"};
  const auto evaluate = [&](const std::string& theta) {
    std::vector<std::string> arguments = quick;
    arguments.insert(arguments.end(), {"--theta", theta});
    const Ended ended = Run(arguments);
    EXPECT_EQ(ended.code, 0) << ended.err;
    return Json::parse(ended.out);
  };
  const Json initial = evaluate("initial");
  EXPECT_EQ(initial["designs"][0]["name"], "initial");
  Json spelt = evaluate("middle_width=44 mm");
  EXPECT_EQ(spelt["designs"][0]["name"], "0");
  spelt["designs"][0]["name"] = "initial";
  EXPECT_EQ(spelt, initial);
  const Json other = evaluate("middle_width=5 cm,left_depth=10 mm");
  EXPECT_EQ(other["designs"][0]["theta"]["middle_width"], 0.05);
  EXPECT_NE(other["designs"][0]["test"]["loss_mean"], initial["designs"][0]["test"]["loss_mean"]);
  const Json random = evaluate("random:3");
  ASSERT_EQ(random["designs"].size(), 3u);
  std::vector<double> rates;
  for (const Json& design : random["designs"]) rates.push_back(design["test"]["success_rate"]);
  std::sort(rates.begin(), rates.end());
  EXPECT_EQ(random["median_success_rate"], rates[1]);
}

TEST_F(LearnTest, LandscapeIsTheSameForAnyNumberOfWorkers) {
  const auto draw = [&](const std::string& out, const std::string& workers) {
    RunWell({"landscape", kConfig, "rollout.horizon=2 s", "--x", "left_depth", "--y", "right_depth", "--grid", "3",
             "--variations", "2", "--workers", workers, "--out", out});
  };
  draw("one", "1");
  draw("two", "2");
  const std::string csv = ReadText(folder_ / "one/landscape.csv");
  EXPECT_EQ(ReadText(folder_ / "two/landscape.csv"), csv);
  EXPECT_EQ(ReadText(folder_ / "two/landscape.svg"), ReadText(folder_ / "one/landscape.svg"));
  auto columns = ReadCsv(folder_ / "one/landscape.csv");
  ASSERT_EQ(columns["loss"].size(), 9u);
  // From bound to bound, and what knap evaluate says at the first corner.
  EXPECT_THAT(columns["left_depth"], ::testing::ElementsAre("-0.015", "0.0125", "0.04", "-0.015", "0.0125", "0.04",
                                                            "-0.015", "0.0125", "0.04"));
  const Ended evaluated = Run({"evaluate", kConfig, "rollout.horizon=2 s", "--theta",
                               "left_depth=-15 mm,right_depth=-15 mm", "--variations", "2", "--json", "--quiet"});
  ASSERT_EQ(evaluated.code, 0) << evaluated.err;
  const double mean = Json::parse(evaluated.out)["designs"][0]["test"]["loss_mean"];
  EXPECT_EQ(std::stod(columns["loss"][0]), mean);
  EXPECT_NE(columns["loss"][8], columns["loss"][0]);
  EXPECT_THAT(ReadText(folder_ / "one/landscape.svg"),
              AllOf(HasSubstr("left_depth [mm]"), HasSubstr("right_depth [mm]"), HasSubstr("Success rate")));
  const Ended again = Run({"landscape", kConfig, "--x", "left_depth", "--y", "right_depth", "--out", "one"});
  EXPECT_EQ(again.code, 2);
  EXPECT_THAT(again.err, HasSubstr("not an empty folder"));
}

TEST_F(LearnTest, BadUsageExitsWithTwo) {
  const std::vector<std::vector<std::string>> lines = {
      {},
      {"nonsense"},
      {"learn"},
      {"learn", kConfig, "--nonsense"},
      {"learn", kConfig, "--workers", "0"},
      {"learn", kConfig, "--workers", "2", "--external"},
      {"learn", kConfig, "--resume", "run"},
      {"learn", "--resume", "nowhere", "--seed", "1"},
      {"learn", "--resume", "nowhere"},
      {"learn", kConfig, "--out", "/proc/self"},
      {"learn", "nowhere.yaml"},
      {"learn", kConfig, "--method", "best"},
      {"learn", kConfig, "learning.optimizer=LD_MAGIC"},
      {"learn", kConfig, "--lcm-url", "udpm://1.2.3.4:5"},
      {"evaluate"},
      {"evaluate", "."},
      {"evaluate", kConfig, "--theta", "learned"},
      {"evaluate", kConfig, "--theta", "width=1 mm"},
      {"evaluate", kConfig, "--theta", "middle_width=44"},
      {"evaluate", kConfig, "--theta", "random:0"},
      {"evaluate", kConfig, "--engine", "newton"},
      {"learn", kConfig, "--engine", "bullet"},
      {"evaluate", kConfig, "--variations", "1000000", "--theta", "random:100000"},
      {"evaluate", kConfig, "--variations", "4294967297"},
      {"rollout", kConfig, "rollout.horizon=17179869.584 s"},
      {"landscape", kConfig, "--x", "left_depth", "--y", "right_depth", "--grid", "1000", "--variations", "1000"},
      {"landscape", kConfig, "--x", "left_depth", "--y", "right_depth", "--grid", "4294967298"},
      {"landscape", kConfig, "--x", "left_depth"},
      {"landscape", kConfig, "--x", "left_depth", "--y", "left_depth"},
      {"landscape", kConfig, "--x", "left_depth", "--y", "depth"},
      {"landscape", kConfig, "--x", "left_depth", "--y", "right_depth", "--grid", "1"},
      {"landscape", kConfig, "--x", "left_depth", "--y", "right_depth", "--variation", "1", "--variations", "2"},
  };
  for (const std::vector<std::string>& line : lines) {
    const Ended ended = Run(line);
    EXPECT_EQ(ended.code, 2) << fmt::format("{}", fmt::join(line, " ")) << ": " << ended.err;
    EXPECT_EQ(ended.out, "");
    EXPECT_THAT(ended.err, Not(HasSubstr("terminate"))) << fmt::format("{}", fmt::join(line, " "));
    EXPECT_GT(ended.err.size(), 10u);
  }
  const Ended wrong = Run({"learn", kConfig, "bodies.pea.shapes[0].radius=10", "rollout.step=-1 s"});
  EXPECT_EQ(wrong.code, 2);
  EXPECT_THAT(wrong.err, AllOf(HasSubstr("bodies.pea.shapes[0].radius"), HasSubstr("rollout.step")));
  EXPECT_EQ(Run({"--help"}).code, 0);
  EXPECT_EQ(Run({"--version"}).code, 0);
}

TEST_F(LearnTest, DryRunTouchesNothing) {
  const Ended ended = Run({"learn", kConfig, "--dry-run", "--workers", "3"});
  EXPECT_EQ(ended.code, 0) << ended.err;
  EXPECT_THAT(ended.out, AllOf(HasSubstr("middle_width"), HasSubstr("20 batches of 5"), HasSubstr("3345")));
  EXPECT_FALSE(fs::exists(folder_ / "runs"));
}

TEST_F(LearnTest, NoWorkersExitsWithFour) {
  const Ended ended =
      Run(MakeShortRun("learn", "lonely", {"--external", "--wait", "0.5", "--lcm-url", MakeOwnLcmUrl()}));
  EXPECT_EQ(ended.code, 4);
  EXPECT_THAT(ended.err, HasSubstr("no worker"));
}

TEST_F(LearnTest, OtherConfigurationIsNotResumed) {
  RunWell(MakeShortRun("learn", "run", {}));
  std::string config = ReadText(folder_ / "run/config.yaml");
  const std::size_t place = config.find("alpha: 0.1");
  ASSERT_NE(place, std::string::npos);
  config.replace(place, 10, "alpha: 0.2");
  WriteFile(folder_ / "run/config.yaml", config);
  const Ended ended = Run({"learn", "--resume", "run"});
  EXPECT_NE(ended.code, 0);
  EXPECT_THAT(ended.err, HasSubstr("journal"));
}

// One byte behind its end makes the program another build; the loader does not look there.
TEST_F(LearnTest, AnotherBuildDoesNotResume) {
  RunWell(MakeShortRun("learn", "run", {}));
  WriteFile(folder_ / "knap", ReadText(KNAP_PROGRAM) + "x");
  fs::permissions(folder_ / "knap", fs::perms::owner_all);
  const auto resume = [this](const std::string& program) {
    ChildProcess knap(program, {"learn", "--resume", "run", "--dry-run"}, folder_ / "", "resume");
    return Ended{knap.Wait(), knap.ReadOut(), knap.ReadErr()};
  };
  const Ended other = resume(folder_ / "knap");
  EXPECT_EQ(other.code, 2) << other.err;
  const std::string build = Json::parse(ReadText(folder_ / "run/run.json"))["build"];
  EXPECT_THAT(other.err, HasSubstr("begun by another build of knap (" + build + ";"));
  EXPECT_EQ(resume(KNAP_PROGRAM).code, 0);
}

}  // namespace learn_test
}  // namespace knap
