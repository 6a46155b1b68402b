// knap explain, beside real runs whose workers die, that wait for workers, or that are broken off.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "coordinator/run_directory/temporary_folder.h"
#include "tests/cluster/child_process.h"
#include "tests/cluster/run_files.h"
#include "tests/cluster/short_runs.h"
#include "tests/support/own_lcm_url.h"
#include "tests/support/wait_for.h"

namespace knap {
namespace explain_test {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using Json = nlohmann::json;

class ExplainProgramTest : public ::testing::Test {
 protected:
  Ended Run(std::vector<std::string> arguments) {
    return RunToEnd(KNAP_PROGRAM, std::move(arguments), folder_ / "", "command");
  }

  std::vector<Json> ReadEvents(const std::string& run, const std::string& name) {
    std::istringstream lines(ReadText(folder_ / run / "events.jsonl"));
    std::vector<Json> events;
    for (std::string line; std::getline(lines, line);) {
      Json event = Json::parse(line, nullptr, false);
      if (event.is_object() && event.value("event", "") == name) events.push_back(std::move(event));
    }
    return events;
  }

  // Every file's bytes, by path.
  std::map<std::string, std::string> ReadFolder(const std::string& run) {
    std::map<std::string, std::string> files;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder_ / run)) {
      if (entry.is_regular_file()) files[entry.path().string()] = ReadText(entry.path());
    }
    return files;
  }

  // Of a request that a worker held when it was killed, and another one answered: its full id, and who held it.
  struct SentAgain {
    std::string id, worker, answered_by;
  };
  std::optional<SentAgain> FindSentAgain(const std::string& run) {
    auto rows = ReadCsv(folder_ / run / "rollouts.csv");
    for (const Json& gone : ReadEvents(run, "worker_gone")) {
      if (gone["why"] != "died") continue;
      for (const Json& request : gone["requests"]) {
        for (std::size_t i = 0; i < rows["held_s"].size(); ++i) {
          if (rows["id"][i].rfind(request["id"].get<std::string>(), 0) != 0) continue;
          if (std::stoi(rows["attempt"][i]) != request["attempt"].get<int>() + 1) continue;
          return SentAgain{rows["id"][i], gone["worker"], rows["worker"][i]};
        }
      }
    }
    return std::nullopt;
  }

  TemporaryFolder folder_;
};

TEST_F(ExplainProgramTest, NamesTheRequestOfAKilledWorkerAndWhoTookItOver) {
  ChildProcess knap(KNAP_PROGRAM, MakeSlowLearning("run", {"--workers", "2"}), folder_ / "", "learn");
  // All workers are killed whenever two more answers have come, until one of their requests was answered by another.
  std::size_t answers = 0;
  std::optional<SentAgain> found;
  ASSERT_TRUE(WaitFor([&] {
    found = FindSentAgain("run");
    if (found || knap.HasEnded()) return true;
    const std::size_t now = ReadCsv(folder_ / "run/rollouts.csv")["id"].size();
    if (now < answers + 2) return false;
    const std::vector<pid_t> workers = knap.ListChildren();
    if (workers.empty()) return false;
    answers = now;
    for (const pid_t worker : workers) kill(worker, SIGKILL);
    return false;
  }));
  ASSERT_EQ(knap.Wait(), 0) << knap.ReadErr();
  if (!found) found = FindSentAgain("run");
  ASSERT_TRUE(found.has_value()) << ReadText(folder_ / "run/events.jsonl");

  const auto before = ReadFolder("run");
  const Ended whole = Run({"explain", "run"});
  ASSERT_EQ(whole.code, 0) << whole.err;
  EXPECT_THAT(whole.out,
              AllOf(HasSubstr("pushing, ours, seed 0"), HasSubstr("its worker died"), HasSubstr(found->worker + " on "),
                    HasSubstr(": died, with "), HasSubstr("it has ended")));
  const Ended one = Run({"explain", "run", found->id.substr(0, 12)});
  ASSERT_EQ(one.code, 0) << one.err;
  EXPECT_THAT(one.out, AllOf(HasSubstr("request    " + found->id), HasSubstr("  " + found->worker + ", given at "),
                             HasSubstr("its worker died at "), HasSubstr("  " + found->answered_by + ", given at "),
                             HasSubstr("answered at "), HasSubstr("variation"), HasSubstr("finite and converged")));
  EXPECT_THAT(one.out, HasSubstr("left_depth "));  // theta, by name
  EXPECT_EQ(ReadFolder("run"), before);            // it reads alone

  // The command that it names computes the same loss.
  const std::size_t begin = one.out.find("knap rollout ") + 5;
  std::istringstream words(one.out.substr(begin, one.out.find('\n', begin) - begin));
  std::vector<std::string> arguments;
  for (std::string word; words >> word;) arguments.push_back(word);
  arguments.emplace_back("--json");
  const Ended again = Run(arguments);
  ASSERT_EQ(again.code, 0) << again.err;
  auto rows = ReadCsv(folder_ / "run/rollouts.csv");
  const auto row = std::find(rows["id"].begin(), rows["id"].end(), found->id) - rows["id"].begin();
  EXPECT_EQ(Json::parse(again.out)["loss"].get<double>(), std::stod(rows["loss"][static_cast<std::size_t>(row)]));
}

// Nobody comes to work for it: all that it asks waits, for as long as this test likes.
TEST_F(ExplainProgramTest, TellsWhatWaitsAndWhatAnInterruptionCancelled) {
  ChildProcess knap(KNAP_PROGRAM,
                    MakeSlowLearning("run", {"--external", "--wait", "6000", "--lcm-url", MakeOwnLcmUrl()}),
                    folder_ / "", "learn");
  ASSERT_TRUE(WaitFor([&] { return knap.HasEnded() || !ReadEvents("run", "begin").empty(); }));
  ASSERT_FALSE(knap.HasEnded()) << knap.ReadErr();
  // The first word may come before the first question.
  Ended live;
  ASSERT_TRUE(WaitFor([&] {
    live = Run({"explain", "run", "--wait", "600"});
    return live.code != 0 || live.out.find(" requests open, 0 workers") != std::string::npos;
  }));
  EXPECT_EQ(live.code, 0) << live.err;
  EXPECT_THAT(live.out, AllOf(HasSubstr("goes on: "), HasSubstr("with no worker, or on the way to one"),
                              HasSubstr("0 answered")));
  knap.Signal(SIGINT);
  ASSERT_EQ(knap.Wait(), 130);
  const Ended over = Run({"explain", "run"});
  EXPECT_THAT(over.out, AllOf(HasSubstr("it was interrupted"), HasSubstr("knap learn --resume run"),
                              HasSubstr("the run was broken off while it was open")));
  const std::vector<Json> dropped = ReadEvents("run", "requests_dropped");
  ASSERT_EQ(dropped.size(), 1u);
  const std::string id = dropped.front()["requests"][0]["id"];
  const Ended one = Run({"explain", "run", id});
  EXPECT_EQ(one.code, 0) << one.err;
  EXPECT_THAT(one.out, AllOf(HasSubstr("waited for a worker"), HasSubstr("as the run was broken off"),
                             HasSubstr("answer     none"), HasSubstr("knap rollout run --request " + id)));
}

TEST_F(ExplainProgramTest, WhatItCannotExplainIsOneLine) {
  ASSERT_EQ(Run(MakeSlowLearning("run", {"learning.variations=2"})).code, 0);
  EXPECT_TRUE(ReadEvents("run", "requests_dropped").empty());  // it went to its end
  const auto expect_line = [&](const std::vector<std::string>& arguments, const auto& matcher) {
    const Ended ended = Run(arguments);
    EXPECT_EQ(ended.code, 2);
    EXPECT_THAT(ended.err, matcher);
    EXPECT_EQ(std::count(ended.err.begin(), ended.err.end(), '\n'), 1) << ended.err;
    EXPECT_EQ(ended.out, "");
  };
  expect_line({"explain", "nowhere"}, HasSubstr("nowhere: no run directory"));
  expect_line({"explain", "run", "abc"}, AllOf(HasSubstr("'abc'"), HasSubstr("the first 4 to 64 digits")));
  expect_line({"explain", "run", "wxyz"}, HasSubstr("'wxyz'"));
  expect_line({"explain", "run", std::string(64, '0')}, HasSubstr("no request on record begins with 0000"));
  // Two that begin alike.
  std::string rows = ReadText(folder_ / "run/rollouts.csv");
  const std::string first = rows.substr(rows.find('\n') + 1, 64);
  std::string second = first;
  second.back() = first.back() == '0' ? '1' : '0';
  const std::size_t begin = rows.find('\n') + 1;
  std::string copy = rows.substr(begin, rows.find('\n', begin) + 1 - begin);
  std::ofstream(folder_ / "run/rollouts.csv", std::ios::app) << copy.replace(0, 64, second);
  expect_line({"explain", "run", first.substr(0, 20)},
              AllOf(HasSubstr("2 requests begin with "), HasSubstr(first.substr(0, 12) + ", ")));
  std::filesystem::remove(folder_ / "run/rollouts.csv");
  expect_line({"explain", "run"}, AllOf(HasSubstr("run: "), HasSubstr("rollouts.csv is missing")));
}

}  // namespace explain_test
}  // namespace knap
