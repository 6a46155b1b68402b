// How failed rollouts count, with what the engine really says of them: an arm on a hinge that rests, or that turns so
// fast that no step is short enough for Newton to find where it is.
#include "coordinator/learning/failed_rollouts.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>
#include <vector>

#include "coordinator/landscape/landscape.h"
#include "coordinator/learning/batch_objective.h"
#include "coordinator/learning/evaluation.h"
#include "worker/engine.h"
#include "worker/knap_engine.h"

namespace knap {
namespace failed_rollouts_test {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kSpins = 1e15, kRests = 0.0;  // [rad/s]

constexpr char kArm[] = R"(schema: 2
name: arm
gravity: [0 m/s^2, 0 m/s^2, 0 m/s^2]
bodies:
  - name: arm
    joint: {type: revolute, axis: [0, 1, 0], actuator: {type: force, limit: 1e20 N*m}}
    inertia: {type: explicit, mass: 1 kg, center: [100 mm, 0 mm, 0 mm],
              moments: [0.01 kg*m^2, 0.01 kg*m^2, 0.01 kg*m^2]}
rollout: {horizon: 40 ms, step: 10 ms}
controls: {actuators: [arm], interval: 20 ms}
signals:
  - {name: goal_away, type: distance, body: arm, targets: [{position: [1 m, 0 m, 0 m]}]}
  - {name: tip_away, type: distance, body: arm, point: [1 m, 0 m, 0 m], targets: [{position: [1 m, 0 m, 1 m]}]}
  - {name: x, type: position, body: arm, axis: x}
  - {name: y, type: position, body: arm, axis: y}
loss:
  task:
    - {signals: [goal_away], shape: absolute}
    - {signals: [tip_away], shape: absolute}
success: {type: within, signals: [x], above: -1 m, below: 1 m, when: {type: crossing, signal: y, at: 1 m}}
variation:
  - {key: "bodies.arm.initial.rate", distribution: uniform, lower: 0 rad/s, upper: 1e15 rad/s}
  - {key: "signals.goal_away.targets[0].position[0]", distribution: uniform, lower: 1 m, upper: 9 m}
learning: {method: diffhand, optimize: [control]}
)";

// The program knap-worker's engine without the cluster; theta are the controls.
class EngineService : public RolloutService {
 public:
  std::vector<RolloutOutcome> Evaluate(std::span<const RolloutQuery> queries) override {
    std::vector<RolloutOutcome> outcomes;
    for (const RolloutQuery& query : queries) {
      const EngineAnswer answer = scenario_->Run({.theta = {},
                                                  .controls = query.theta,
                                                  .reference = query.theta_reference,
                                                  .variation = query.variation,
                                                  .gradient = query.gradient},
                                                 [](std::int64_t, std::int64_t) {});
      EXPECT_EQ(answer.error, "");
      RolloutOutcome outcome{.loss = answer.loss, .success = answer.success, .gradient = answer.gradient};
      outcome.certificate = {
          .finite = answer.finite, .converged = answer.converged, .gradient_reliable = answer.gradient_reliable};
      outcomes.push_back(outcome);
    }
    return outcomes;
  }

 private:
  std::unique_ptr<EngineScenario> scenario_ = MakeKnapEngine()->Load({{"scenario.yaml", kArm}});
};

const std::vector<double> kStill = {0.0, 0.0};

// The first term of the loss is the distance of the target, 1 to 9 m; the second is 1 m for an arm that rests.
std::vector<RolloutOutcome> Ask(const std::vector<std::vector<double>>& variations) {
  EngineService service;
  std::vector<RolloutQuery> queries;
  for (const std::vector<double>& variation : variations) queries.push_back({kStill, {}, variation, false});
  return service.Evaluate(queries);
}

TEST(FailedRolloutsTest, TheEngineSaysThatItFailed) {
  const std::vector<RolloutOutcome> outcomes = Ask({{kSpins, 2.0}, {kRests, 2.0}});
  EXPECT_FALSE(outcomes[0].certificate.converged);
  EXPECT_TRUE(std::isnan(outcomes[0].loss));
  EXPECT_TRUE(HasFailed(outcomes[0]));
  EXPECT_TRUE(outcomes[1].certificate.converged);
  EXPECT_DOUBLE_EQ(outcomes[1].loss, 3.0);
  EXPECT_FALSE(HasFailed(outcomes[1]));
}

TEST(FailedRolloutsTest, ATestCountsThemAsItsWorst) {
  const TestSummary summary = SummarizeTest(
      Ask({{kRests, 1.0}, {kSpins, 1.0}, {kRests, 7.0}, {kSpins, 1.0}, {kRests, 3.0}}), 0);  // 2, 8, 8, 8, 4
  EXPECT_EQ(summary.not_finite, 2);
  EXPECT_DOUBLE_EQ(summary.loss_mean, 6.0);
  EXPECT_NEAR(summary.loss_std, std::sqrt(32.0 / 4.0), 1e-14);
  EXPECT_DOUBLE_EQ(summary.worst_decile_loss, 8.0);
  EXPECT_EQ(summary.success_rate, 0.0);
  EXPECT_EQ(SummarizeTest(Ask({{kSpins, 1.0}, {kSpins, 2.0}}), 0).loss_mean, kInfinity);
}

TEST(FailedRolloutsTest, ABatchCountsThemAsItsWorstWhereItStarts) {
  EngineService service;
  const std::vector<double> range = {6.0, 6.0};
  const auto evaluate = [&](const std::vector<std::vector<double>>& variations) {
    return BatchObjective(variations, {}, kStill, range, 0.1, service).EvaluateStart();
  };
  const BatchEvaluation sound = evaluate({{kRests, 1.0}, {kRests, 5.0}});
  EXPECT_DOUBLE_EQ(sound.loss, 4.0);
  EXPECT_GT(sound.gradient_norm, 0.0);
  const BatchEvaluation failing = evaluate({{kRests, 1.0}, {kSpins, 1.0}, {kRests, 5.0}, {kSpins, 1.0}});
  EXPECT_TRUE(failing.accepted);
  EXPECT_EQ(failing.untrusted, 2);
  EXPECT_DOUBLE_EQ(failing.loss, (2.0 + 6.0 + 6.0 + 6.0) / 4.0);
  EXPECT_DOUBLE_EQ(failing.gradient_norm, 0.5 * sound.gradient_norm);  // what is constant has no slope
  const BatchEvaluation hopeless = evaluate({{kSpins, 1.0}, {kSpins, 5.0}});
  EXPECT_FALSE(hopeless.accepted);
  EXPECT_EQ(hopeless.loss, kInfinity);
}

// A command throws the arm around, and no step of it converges: the optimizer sees infinity.
TEST(FailedRolloutsTest, ALaterFailureRejectsTheEvaluation) {
  EngineService service;
  const std::vector<double> range = {6.0, 6.0};
  BatchObjective objective({{kRests, 1.0}, {kRests, 5.0}}, {}, kStill, range, 0.1, service);
  ASSERT_TRUE(objective.EvaluateStart().accepted);
  const std::vector<double> theta{0.5, -0.5};
  const BatchEvaluation moved = objective.Evaluate({&theta, 1}, true).front();
  EXPECT_FALSE(moved.accepted);
  EXPECT_EQ(moved.loss, kInfinity);
  EXPECT_EQ(moved.untrusted, 2);
}

TEST(FailedRolloutsTest, ALandscapeCountsThemInTheirCell) {
  EngineService service;
  LandscapePlan plan{{0, {0.0, 1.0}}, {1, {0.0, 1.0}}, kStill, {{kRests, 1.0}, {kSpins, 1.0}, {kRests, 4.0}}};
  const Landscape landscape = EvaluateLandscape(plan, service);
  EXPECT_DOUBLE_EQ(landscape.cells[0].loss, (2.0 + 5.0 + 5.0) / 3.0);
  for (std::size_t k = 1; k < 4; ++k) EXPECT_EQ(landscape.cells[k].loss, kInfinity) << k;
}

}  // namespace failed_rollouts_test
}  // namespace knap
