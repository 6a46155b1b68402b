// knap train-policy from outside: the same weights for any number of workers, and after a kill.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "coordinator/run_directory/temporary_folder.h"
#include "tests/cluster/child_process.h"
#include "tests/cluster/run_files.h"
#include "tests/support/wait_for.h"

namespace knap {
namespace train_policy_test {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using Json = nlohmann::json;

const std::string kConfig = KNAP_SOURCE_DIR "/configs/reaching_policy.yaml";

class TrainPolicyTest : public ::testing::Test {
 protected:
  // Six goals, and few evaluations for each: not every one of them is reached.
  static std::vector<std::string> MakeArguments(const std::string& out, const std::string& workers) {
    return {"train-policy",
            kConfig,
            "success={type: within, signals: [tip_error], below: 12 mm}",
            "policy.hidden=[4]",
            "--demonstrations",
            "6",
            "--evaluations",
            "10",
            "--rounds",
            "2",
            "--seed",
            "3",
            "--out",
            out,
            "--workers",
            workers};
  }

  int Run(const std::vector<std::string>& arguments) {
    ChildProcess knap(KNAP_PROGRAM, arguments, folder_ / "", "log");
    const int code = knap.Wait();
    out_ = knap.ReadOut();
    err_ = knap.ReadErr();
    return code;
  }

  std::string ReadWeights(const std::string& training) { return ReadText(folder_ / training / "policy/trained.txt"); }

  Json ReadTraining(const std::string& training) {
    Json json = Json::parse(ReadText(folder_ / training / "training.json"));
    json.erase("wall_s");
    return json;
  }

  TemporaryFolder folder_;
  std::string out_, err_;
};

TEST_F(TrainPolicyTest, WeightsAreTheSameForAnyNumberOfWorkersAndAfterAKill) {
  ASSERT_EQ(Run(MakeArguments("one", "1")), 0) << err_;
  EXPECT_THAT(err_, HasSubstr("demonstrations"));
  EXPECT_THAT(err_, HasSubstr("trained.txt"));
  const Json one = ReadTraining("one");
  ASSERT_EQ(one["results"].size(), 6u);
  const int imitated = one["imitated"];
  EXPECT_GT(imitated, 0) << one;
  // Some goals were only reached from where others were.
  EXPECT_THAT(one["results"], ::testing::Contains(::testing::Truly([](const Json& d) { return d["round"] == 1; })));
  EXPECT_EQ(one["examples"], 30 * imitated);  // intervals of 50 ms in 1.5 s
  EXPECT_LT(one["error"].get<double>(), 0.3 * one["start_error"].get<double>());
  EXPECT_THAT(ReadWeights("one"), HasSubstr("# demonstrations 6, evaluations 10, rounds 2, seed 3"));

  ASSERT_EQ(Run(MakeArguments("two", "2")), 0) << err_;
  EXPECT_EQ(ReadWeights("two"), ReadWeights("one"));
  EXPECT_EQ(ReadTraining("two"), one);

  {
    ChildProcess knap(KNAP_PROGRAM, MakeArguments("killed", "1"), folder_ / "", "killed_log");
    const auto has_begun = [&] {
      std::error_code none;
      return fs::file_size(folder_ / "killed/journal", none) > 8192 && !none;
    };
    ASSERT_TRUE(WaitFor([&] { return knap.HasEnded() || has_begun(); }));
    ASSERT_FALSE(knap.HasEnded()) << knap.ReadErr();
    knap.Signal(SIGKILL);
    knap.Wait();
  }
  ASSERT_FALSE(fs::exists(folder_ / "killed/policy"));
  ASSERT_EQ(Run({"train-policy", "--resume", "killed", "--workers", "2"}), 0) << err_;
  EXPECT_EQ(ReadWeights("killed"), ReadWeights("one"));
  EXPECT_EQ(ReadTraining("killed"), one);

  // A scenario may start from the weights, and training again from there gives the same: they do not count.
  std::string text = ReadText(kConfig);
  const std::string random = "initial: {type: random, seed: 1, scale: 0.5}";
  text.replace(text.find(random), random.size(), "initial: {type: file, file: trained.txt}");
  std::ofstream(folder_ / "next.yaml") << text;
  fs::copy(KNAP_SOURCE_DIR "/configs/meshes", folder_ / "meshes");
  fs::copy(folder_ / "one/policy/trained.txt", folder_ / "trained.txt");
  ASSERT_EQ(Run({"rollout", "next.yaml", "policy.hidden=[4]", "--json"}), 0) << err_;
  std::vector<std::string> again = MakeArguments("again", "2");
  again[1] = "next.yaml";
  ASSERT_EQ(Run(again), 0) << err_;
  EXPECT_EQ(ReadWeights("again"), ReadWeights("one"));
}

TEST_F(TrainPolicyTest, BadUsageIsNamed) {
  const auto expect = [this](const std::vector<std::string>& arguments, const std::string& message) {
    EXPECT_EQ(Run(arguments), 2) << err_;
    EXPECT_THAT(err_, HasSubstr(message));
  };
  expect({"train-policy"}, "either a CONFIG or --resume");
  expect({"train-policy", KNAP_SOURCE_DIR "/configs/reaching.yaml"}, "no section policy");
  expect({"train-policy", kConfig, "--demonstrations", "0"}, "--demonstrations");
  expect({"train-policy", "--resume", "."}, "config.yaml");
  // Nothing succeeds: that is a failure, not a bad command.
  std::vector<std::string> hopeless = MakeArguments("hopeless", "2");
  hopeless[2] = "success={type: within, signals: [tip_error], above: 1 m}";
  EXPECT_EQ(Run(hopeless), 1);
  EXPECT_THAT(err_, HasSubstr("none of 6 demonstrations succeeded"));
}

}  // namespace train_policy_test
}  // namespace knap
