// knap evaluate --engine bullet from outside: two engines side by side, the same bits whoever computes and dies, and
// what is refused.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "coordinator/run_directory/temporary_folder.h"
#include "tests/cluster/child_process.h"
#include "tests/cluster/run_files.h"
#include "tests/support/own_lcm_url.h"
#include "tests/support/wait_for.h"

namespace knap {
namespace transfer_test {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using Json = nlohmann::json;

const std::string kConfigs = KNAP_SOURCE_DIR "/configs/";

// The pea is met and swept aside.
std::vector<std::string> MakeArguments(int variations, std::vector<std::string> more) {
  std::vector<std::string> arguments = {
      "evaluate",     kConfigs + "pushing.yaml",     "--engine", "bullet", "--perturb", "rollout.horizon=2 s",
      "--variations", fmt::format("{}", variations), "--quiet"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

class TransferTest : public ::testing::Test {
 protected:
  void RunWell(const std::vector<std::string>& arguments, std::string* out = nullptr) {
    ChildProcess knap(KNAP_PROGRAM, arguments, folder_ / "", "run");
    ASSERT_EQ(knap.Wait(), 0) << knap.ReadErr();
    if (out != nullptr) *out = knap.ReadOut();
  }

  TemporaryFolder folder_;
};

TEST_F(TransferTest, SameBitsForAnyNumberOfWorkersAndBothEngines) {
  std::string out;
  RunWell(MakeArguments(8, {"--workers", "1", "--csv", "one.csv", "--json"}), &out);
  RunWell(MakeArguments(8, {"--workers", "2", "--csv", "two.csv"}));
  RunWell(MakeArguments(8, {"--workers", "4", "--csv", "four.csv"}));
  const std::string one = ReadText(folder_ / "one.csv");
  EXPECT_EQ(ReadText(folder_ / "two.csv"), one);
  EXPECT_EQ(ReadText(folder_ / "four.csv"), one);
  auto columns = ReadCsv(folder_ / "one.csv");
  ASSERT_EQ(columns["engine"].size(), 16u);
  for (std::size_t i = 0; i < 8; ++i) {
    EXPECT_EQ(columns["engine"][i], "knap");
    EXPECT_EQ(columns["engine"][i + 8], "bullet");
    // The same variation in both, and another one than the next.
    for (const char* key : {"bodies.pea.initial.position[0]", "perturbation.friction", "perturbation.mass",
                            "perturbation.speed", "perturbation.starts.pea.along"}) {
      ASSERT_EQ(columns[key].size(), 16u) << key;
      EXPECT_EQ(columns[key][i], columns[key][i + 8]) << key;
      EXPECT_NE(columns[key][i], columns[key][(i + 1) % 8]) << key;
    }
    for (const char* key : {"perturbation.friction", "perturbation.mass", "perturbation.speed"}) {
      EXPECT_LE(std::abs(std::stod(columns[key][i]) - 1.0), 0.25) << key;
    }
    // Two engines, and no copies of one.
    EXPECT_NE(columns["loss"][i], columns["loss"][i + 8]);
    EXPECT_NE(columns["steps"][i], columns["steps"][i + 8]);
  }
  const Json json = Json::parse(out);
  EXPECT_EQ(json["perturbed"], true);
  ASSERT_EQ(json["designs"].size(), 2u);
  EXPECT_EQ(json["designs"][1]["engine"], "bullet");
  EXPECT_EQ(json["engines_agree"][0]["variations"], 8);
}

TEST_F(TransferTest, APerturbationLeavesTheRestOfAVariationAsItIs) {
  RunWell({"evaluate", kConfigs + "pushing.yaml", "rollout.horizon=100 ms", "--variations", "5", "--csv", "plain.csv",
           "--quiet"});
  RunWell({"evaluate", kConfigs + "pushing.yaml", "rollout.horizon=100 ms", "--variations", "5", "--perturb", "--csv",
           "perturbed.csv", "--quiet"});
  auto plain = ReadCsv(folder_ / "plain.csv"), perturbed = ReadCsv(folder_ / "perturbed.csv");
  for (const char* key : {"bodies.pea.initial.position[0]", "bodies.pea.initial.position[1]"}) {
    ASSERT_EQ(plain[key].size(), 5u);
    EXPECT_EQ(plain[key], perturbed[key]) << key;
  }
  EXPECT_EQ(plain.count("perturbation.friction"), 0u);
  EXPECT_NE(plain["loss"], perturbed["loss"]);
}

// Clock ticks that a process has computed; 0 when it is gone.
long ReadTicks(pid_t pid) {
  std::ifstream file(fmt::format("/proc/{}/stat", pid));
  std::string text((std::istreambuf_iterator<char>(file)), {});
  std::istringstream words(text.substr(std::min(text.size(), text.find(')') + 1)));
  std::string word;
  for (int i = 0; i < 11 && words >> word; ++i) continue;
  long user = 0;
  words >> user;
  return user;
}

bool RunsBullet(pid_t pid) {
  const std::string line = ReadText(fmt::format("/proc/{}/cmdline", pid));
  return line.find("bullet") != std::string::npos;
}

TEST_F(TransferTest, KilledWorkersChangeNothing) {
  RunWell(MakeArguments(24, {"--workers", "1", "--csv", "calm.csv"}));
  ChildProcess knap(KNAP_PROGRAM, MakeArguments(24, {"--workers", "2", "--csv", "stormy.csv"}), folder_ / "", "stormy");
  std::set<pid_t> killed;
  ASSERT_TRUE(WaitFor([&] {
    // Each worker of Bullet's, for a while, once it has computed more than it takes to start.
    for (const pid_t worker : knap.ListChildren()) {
      if (killed.size() >= 6 || killed.count(worker) != 0 || !RunsBullet(worker) || ReadTicks(worker) < 15) continue;
      kill(worker, SIGKILL);
      killed.insert(worker);
    }
    return knap.HasEnded();
  }));
  ASSERT_EQ(knap.Wait(), 0) << knap.ReadErr();
  EXPECT_GE(killed.size(), 2u);
  EXPECT_EQ(ReadText(folder_ / "stormy.csv"), ReadText(folder_ / "calm.csv"));
}

TEST_F(TransferTest, WhatBulletCannotRepresentIsRefusedBeforeAnyRollout) {
  const auto refuse = [&](const std::string& config) {
    ChildProcess knap(KNAP_PROGRAM, {"evaluate", kConfigs + config, "--engine", "bullet"}, folder_ / "", "refused");
    EXPECT_EQ(knap.Wait(), 2);
    EXPECT_EQ(knap.ReadOut(), "");
    return knap.ReadErr();
  };
  EXPECT_THAT(refuse("reaching.yaml"),
              AllOf(HasSubstr("bodies.knuckle.joint.type: the engine bullet has no revolute joints"),
                    HasSubstr("controls: the engine bullet has no actuators")));
}

TEST_F(TransferTest, AGradientIsRefusedByName) {
  const std::string url = MakeOwnLcmUrl();
  ChildProcess worker(KNAP_WORKER, {"--engine", "bullet", "--lcm-url", url}, folder_ / "", "worker");
  ChildProcess knap(KNAP_PROGRAM,
                    {"learn", kConfigs + "pushing.yaml", "learning.validation=0", "--external", "--engine", "bullet",
                     "--lcm-url", url, "--wait", "600", "--out", "run"},
                    folder_ / "", "learn");
  EXPECT_EQ(knap.Wait(), 1);
  EXPECT_THAT(knap.ReadErr(), HasSubstr("the engine bullet has no gradients"));
  worker.Signal(SIGTERM);
}

}  // namespace transfer_test
}  // namespace knap
