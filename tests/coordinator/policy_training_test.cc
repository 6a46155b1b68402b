// What a policy's training makes of a scenario and of its demonstrations.
#include "coordinator/run/policy_training.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <string>
#include <vector>

#include "coordinator/run/loaded_run.h"
#include "sim/rollout/build_policy.h"

namespace knap {
namespace policy_training_test {

using Eigen::VectorXd;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

LoadedScenario Load(const std::string& config) { return LoadValidScenario(KNAP_CONFIGS "/" + config, {}); }

// The policy's own commands as open-loop controls: what it sees in that rollout, it must answer with just these.
TEST(PolicyTraining, ExamplesOfAPolicysOwnCommandsAreWhatItDoes) {
  const LoadedScenario scenario = Load("reaching_policy.yaml");
  const Policy& policy = *scenario.parsed.scene.policy;
  RolloutModel closed_loop(scenario.files);
  RolloutModel open_loop(MakeOpenLoopScenario(scenario).files);
  ASSERT_EQ(open_loop.num_controls(), 4 * 30);
  ASSERT_EQ(open_loop.num_parameters(), 9);

  const std::vector<double> weights = MakeImitationStart(policy, 5);
  EXPECT_NE(weights, MakeImitationStart(policy, 6));
  RolloutInput input;
  input.theta = closed_loop.initial_theta();
  input.theta(6) = 1.3;
  input.controls = Eigen::Map<const VectorXd>(weights.data(), static_cast<Eigen::Index>(weights.size()));
  input.variation = {0.03, -0.04};
  const Recording recording = closed_loop.Record(input, 0.0).recording;
  ASSERT_EQ(recording.time.size(), 301u);  // ten steps an interval

  Demonstration demonstration{.variation = input.variation, .success = true};
  demonstration.theta.assign(input.theta.begin(), input.theta.end());
  std::vector<double> commands;
  for (std::size_t k = 0; k < 30; ++k) {
    for (const char* name : {"u_knuckle", "u_0", "u_1", "u_2"}) {
      for (const Recording::Signal& signal : recording.signals) {
        // A command's signal at the end of an interval is what was held through it.
        if (signal.name == name) commands.push_back(signal.values.at(10 * (k + 1)));
      }
    }
  }
  ASSERT_EQ(commands.size(), 120u);
  for (const double u : commands) demonstration.theta.push_back(std::atanh(u));
  Demonstration failed = demonstration;
  failed.success = false;
  const Examples examples = CollectExamples(policy, open_loop, std::vector{failed, demonstration});
  ASSERT_EQ(examples.seen.size(), 30u);  // nothing of the failed one
  Network network = MakeNetwork(policy);
  double largest = 0.0;
  for (std::size_t k = 0; k < 30; ++k) {
    const VectorXd& u = network.Calc(input.controls, examples.seen[k]);
    for (Eigen::Index i = 0; i < 4; ++i) {
      EXPECT_NEAR(u(i), commands[4 * k + static_cast<std::size_t>(i)], 1e-8) << k;
      EXPECT_NEAR(examples.wanted[k](i), commands[4 * k + static_cast<std::size_t>(i)], 1e-12) << k;
      largest = std::max(largest, std::abs(u(i)));
    }
  }
  EXPECT_GT(largest, 0.1);
}

TEST(PolicyTraining, AScenarioThatHasNothingToTrainIsRefused) {
  EXPECT_THAT([] { MakeOpenLoopScenario(Load("reaching.yaml")); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("no section policy")));
  LoadedScenario both = Load("reaching_policy.yaml");
  both.parsed.scene.controls.emplace();
  EXPECT_THAT([&] { MakeOpenLoopScenario(both); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("open-loop controls beside its policy")));
}

// The weights that a scenario starts from do not come along, and what trained them is not asked again.
TEST(PolicyTraining, TheOpenLoopKnowsNothingOfThePolicy) {
  LoadedScenario scenario = Load("reaching_policy.yaml");
  const LoadedScenario random = MakeOpenLoopScenario(scenario);
  EXPECT_FALSE(random.parsed.scene.policy);
  EXPECT_EQ(random.parsed.scene.controls->actuators, scenario.parsed.scene.policy->actuators);
  EXPECT_EQ(random.parsed.scene.learning.optimize, (std::vector{LearnedPart::kDesign, LearnedPart::kControl}));
  scenario.parsed.scene.policy->initial = WeightsFile{"weights.txt"};
  scenario.files["weights.txt"] = "0.1";
  EXPECT_EQ(MakeOpenLoopScenario(scenario).files, random.files);
}

}  // namespace policy_training_test
}  // namespace knap
