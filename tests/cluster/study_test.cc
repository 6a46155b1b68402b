// knap study from outside: its runs are those of knap learn, and it survives being killed.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "coordinator/run_directory/temporary_folder.h"
#include "tests/cluster/child_process.h"
#include "tests/cluster/run_files.h"
#include "tests/cluster/short_runs.h"
#include "tests/support/wait_for.h"

namespace knap {
namespace study_test {

using ::testing::AllOf;
using ::testing::HasSubstr;
using Json = nlohmann::json;

class StudyTest : public ::testing::Test {
 protected:
  void RunWell(const std::vector<std::string>& arguments) {
    ChildProcess knap(KNAP_PROGRAM, arguments, folder_ / "", "run");
    ASSERT_EQ(knap.Wait(), 0) << knap.ReadErr();
    err_ = knap.ReadErr();
  }

  Json ReadStudy(const std::string& study) { return Json::parse(ReadText(folder_ / study / "study.json")); }

  TemporaryFolder folder_;
  std::string err_;
};

TEST_F(StudyTest, RunsAreThoseOfLearnAndSurviveAKill) {
  const std::vector<std::string> which = {"--seeds", "2", "--seed", "5", "--methods", "ours,diffhand"};
  RunWell(MakeShortRun("study", "calm", which));
  EXPECT_THAT(err_, AllOf(HasSubstr("diffhand"), HasSubstr("median"), HasSubstr("6 variations that no run saw")));
  const Json calm = ReadStudy("calm");
  ASSERT_EQ(calm["runs"].size(), 4u);
  EXPECT_EQ(calm["runs"][1]["folder"], "ours-6");
  EXPECT_EQ(calm["runs"][1]["seed"], 6);

  // `ours` is the run of knap learn; so is diffhand with the same budget.
  RunWell(MakeShortRun("learn", "alone", {"--seed", "6"}));
  const auto read_theta = [this](const std::string& run) {
    return Json::parse(ReadText(folder_ / run / "result.json"))["theta"]["learned"];
  };
  EXPECT_EQ(read_theta("alone"), calm["runs"][1]["theta"]);
  EXPECT_EQ(read_theta("calm/ours-6"), calm["runs"][1]["theta"]);
  const std::string budget = "learning.rollout_budget=" + calm["runs"][3]["rollout_budget"].dump();
  EXPECT_EQ(calm["runs"][3]["rollout_budget"], calm["runs"][1]["rollouts"]);
  RunWell(MakeShortRun("learn", "baseline", {"--seed", "6", "--method", "diffhand", budget}));
  EXPECT_EQ(read_theta("baseline"), calm["runs"][3]["theta"]);

  // A run's folder is one that other commands take.
  RunWell({"evaluate", "calm/diffhand-6", "--variations", "3"});

  // Its page, and that of two of its runs.
  EXPECT_THAT(ReadText(folder_ / "calm/report.html"), HasSubstr("\"name\":\"diffhand-6\""));
  RunWell({"report", "calm", "--out", "again.html"});
  EXPECT_EQ(ReadText(folder_ / "again.html"), ReadText(folder_ / "calm/report.html"));
  RunWell({"report", "calm/ours-6", "calm/diffhand-6", "--out", "two.html"});
  EXPECT_THAT(ReadText(folder_ / "two.html"), AllOf(HasSubstr("\"of_runs\":true"), HasSubstr("ours-6")));
  ChildProcess alone(KNAP_PROGRAM, {"report", "calm/ours-6"}, folder_ / "", "report_alone");
  EXPECT_EQ(alone.Wait(), 2);
  EXPECT_THAT(alone.ReadErr(), HasSubstr("see the study's own report"));

  // Killed in the middle, and continued.
  {
    ChildProcess knap(KNAP_PROGRAM, MakeShortRun("study", "killed", which), folder_ / "", "killed_log");
    ASSERT_TRUE(
        WaitFor([&] { return knap.HasEnded() || ReadCsv(folder_ / "killed/ours-5/metrics.csv")["loss"].size() >= 3; }));
    ASSERT_FALSE(knap.HasEnded()) << knap.ReadErr();
    knap.Signal(SIGKILL);
    knap.Wait();
  }
  RunWell({"study", "--resume", "killed"});
  Json killed = ReadStudy("killed");
  Json reference = calm;
  killed.erase("wall_s");
  reference.erase("wall_s");
  EXPECT_EQ(killed, reference);
}

TEST_F(StudyTest, BadUsageIsNamed) {
  const auto expect = [this](const std::vector<std::string>& arguments, const std::string& message) {
    ChildProcess knap(KNAP_PROGRAM, arguments, folder_ / "", "bad");
    EXPECT_EQ(knap.Wait(), 2);
    EXPECT_THAT(knap.ReadErr(), HasSubstr(message));
  };
  expect({"study"}, "either a CONFIG or --resume");
  expect(MakeShortRun("study", "x", {"--methods", "ours,theirs"}), "theirs");
  expect(MakeShortRun("study", "x", {"--methods", "ours,ours"}), "given twice");
  expect({"study", "--resume", "."}, "config.yaml");
}

}  // namespace study_test
}  // namespace knap
