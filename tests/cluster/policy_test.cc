// A policy learned together with a design by real workers: the programs from outside.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "coordinator/run_directory/temporary_folder.h"
#include "tests/cluster/child_process.h"
#include "tests/cluster/run_files.h"

namespace knap {
namespace policy_test {

namespace fs = std::filesystem;

const std::string kConfig = KNAP_SOURCE_DIR "/configs/reaching_policy.yaml";

class PolicyTest : public ::testing::Test {
 protected:
  int Run(std::vector<std::string> arguments) {
    ChildProcess knap(KNAP_PROGRAM, std::move(arguments), folder_ / "", "log");
    const int code = knap.Wait();
    out_ = knap.ReadOut();
    err_ = knap.ReadErr();
    return code;
  }

  // Few evaluations on four goals: a run takes a second or two.
  int Learn(const std::string& out, const std::vector<std::string>& more) {
    std::vector<std::string> arguments = {"learn",
                                          kConfig,
                                          "learning.variations=4",
                                          "learning.batch=4",
                                          "learning.max_evaluations=25",
                                          "evaluation.variations=8"};
    arguments.insert(arguments.end(), {"--out", out});
    arguments.insert(arguments.end(), more.begin(), more.end());
    return Run(arguments);
  }

  nlohmann::json ReadResult(const std::string& run) {
    return nlohmann::json::parse(ReadText(folder_ / (run + "/result.json")));
  }

  TemporaryFolder folder_;
  std::string out_, err_;
};

TEST_F(PolicyTest, IsLearnedWithTheDesignAndResumedToTheSameBits) {
  ASSERT_EQ(Learn("run", {"--workers", "2"}), 0) << err_;
  const nlohmann::json result = ReadResult("run");
  const auto initial = result["test"]["initial"]["loss_mean"].get<double>();
  const auto learned = result["test"]["learned"]["loss_mean"].get<double>();
  EXPECT_LT(learned, 0.3 * initial) << initial;  // on goals that were not seen; measured: 0.17
  const nlohmann::json theta = result["theta"];
  ASSERT_EQ(theta["names"].size(), 9u + 220u);
  EXPECT_EQ(theta["names"][9 + 17], "policy[17]");
  EXPECT_NE(theta["learned"][0], theta["initial"][0]);
  EXPECT_NE(theta["learned"][9 + 17], theta["initial"][9 + 17]);

  // Half of its journal lost, and another number of workers.
  fs::copy(folder_ / "run", folder_ / "again", fs::copy_options::recursive);
  const std::string journal = ReadText(folder_ / "run/journal");
  std::ofstream(folder_ / "again/journal", std::ios::binary | std::ios::trunc) << journal.substr(0, journal.size() / 2);
  fs::remove(folder_ / "again/result.json");
  ASSERT_EQ(Run({"learn", "--resume", "again", "--workers", "1"}), 0) << err_;
  ExpectSameRun(folder_ / "again", folder_ / "run");

  // What was learned is what another scenario may start from.
  std::string text = ReadText(kConfig);
  const std::string random = "initial: {type: random, seed: 1, scale: 0.5}";
  text.replace(text.find(random), random.size(), "initial: {type: file, file: learned.txt}");
  std::ofstream(folder_ / "next.yaml") << text;
  fs::copy(KNAP_SOURCE_DIR "/configs/meshes", folder_ / "meshes");
  fs::copy(folder_ / "run/policy/learned.txt", folder_ / "learned.txt");
  ASSERT_EQ(Run({"rollout", "next.yaml", "--json"}), 0) << err_;
  const nlohmann::json next = nlohmann::json::parse(out_);
  EXPECT_EQ(next["theta"]["policy[17]"], theta["learned"][9 + 17]);
  EXPECT_NE(next["gradient"]["policy[17]"], 0.0);
}

TEST_F(PolicyTest, StaysWhereItIsNotOptimised) {
  ASSERT_EQ(Learn("run", {"learning.optimize=[design]", "learning.max_evaluations=5", "--workers", "2"}), 0) << err_;
  const nlohmann::json theta = ReadResult("run")["theta"];
  EXPECT_NE(theta["learned"][6], theta["initial"][6]);
  for (std::size_t i = 9; i < theta["names"].size(); ++i) EXPECT_EQ(theta["learned"][i], theta["initial"][i]) << i;
}

TEST_F(PolicyTest, GradientsAgreeWithDifferences) {
  // A small network: every weight costs six rollouts and more.
  ASSERT_EQ(Run({"gradcheck", kConfig, "policy.hidden=[2]", "--rollouts", "2", "--tolerance", "1e-7", "--workers", "2",
                 "--json"}),
            0)
      << err_ << out_;
  const nlohmann::json report = nlohmann::json::parse(out_);
  EXPECT_EQ(report["checked"], 2);
  EXPECT_LE(report["max_rel_error"].get<double>(), 1e-7);
}

}  // namespace policy_test
}  // namespace knap
