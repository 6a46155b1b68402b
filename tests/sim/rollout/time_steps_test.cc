// What the scenario's user gets without a word about time steps: slopes of impacts that are the problem's, and an
// estimate of the loss's error that is one.
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "sim/rollout/rollout.h"
#include "sim/scenarios/scenario_files.h"

namespace knap {
namespace time_steps_test {

using Eigen::VectorXd;

constexpr char kPlate[] =
    "v -50 -50 -10\nv 50 -50 -10\nv 50 50 -10\nv -50 50 -10\nv -50 -50 10\nv 50 -50 10\nv 50 50 10\nv -50 50 10\n"
    "f 1 4 3\nf 1 3 2\nf 5 6 7\nf 5 7 8\nf 1 2 6\nf 1 6 5\nf 2 3 7\nf 2 7 6\nf 3 4 8\nf 3 8 7\nf 4 1 5\nf 4 5 8\n";
constexpr char kCage[] =
    "v -51 -51 -11\nv 51 -51 -11\nv 51 51 -11\nv -51 51 -11\nv -51 -51 11\nv 51 -51 11\nv 51 51 11\nv -51 51 11\n"
    "f 1 4 3\nf 1 3 2\nf 5 6 7\nf 5 7 8\nf 1 2 6\nf 1 6 5\nf 2 3 7\nf 2 7 6\nf 3 4 8\nf 3 8 7\nf 4 1 5\nf 4 5 8\n";

struct Throw {
  double speed = 0.5;     // downwards [m/s]
  double sideways = 0.0;  // [m/s]
  double gap = 0.02;      // above the plate [m]
  double gravity = 0.0;   // [m/s²]
  std::string material = "stiffness: 3e7 N/m^3, damping: 0 s/m, friction: 0.4";
  std::string rollout = "horizon: 0.4 s, newton_tolerance: 1e-13";
  std::string more;                         // sections of the file
  std::string axes = "[1 mm, 2 mm, -1 m]";  // the loss is the distance from there …
  std::string loss = "off";                 // … or "rise", the speed upwards, or "now", the time
  std::string when = "end";                 // of the loss
};

// A ball bounces off a plate whose height is the design.
RolloutModel MakeModel(const Throw& t) {
  const std::string text =
      "schema: 2\nname: bounce\ngravity: [0 m/s^2, 0 m/s^2, " + std::to_string(-t.gravity) +
      " m/s^2]\n"
      "bodies:\n"
      "  - {name: tool, joint: {type: fixed}, shapes: [{type: designed_mesh}]}\n"
      "  - name: ball\n"
      "    joint: {type: free}\n"
      "    shapes: [{type: sphere, radius: 7 mm}]\n"
      "    inertia: {type: solid, mass: 1.44 g}\n"
      "    initial: {position: [1 mm, 2 mm, " +
      std::to_string(17.0 + 1e3 * t.gap) + " mm], velocity: [" + std::to_string(t.sideways) + " m/s, 0 m/s, " +
      std::to_string(-t.speed) +
      " m/s]}\n"
      "contacts: [{bodies: [ball, tool], " +
      t.material +
      "}]\n"
      "design:\n"
      "  parameters: [{name: height, initial: 0 mm, lower: -10 mm, upper: 10 mm}]\n"
      "  bodies:\n"
      "    - {name: tool, mesh: plate.obj, cage: cage.obj, mesh_unit: 1 mm,\n"
      "       vertex_groups: [{name: all, vertices: [0, 1, 2, 3, 4, 5, 6, 7]}],\n"
      "       moves: [{parameter: height, group: all, direction: [0, 0, 1]}]}\n"
      "rollout: {" +
      t.rollout +
      "}\n"
      "signals:\n"
      "  - {name: off, type: distance, body: ball, targets: [{position: " +
      t.axes +
      "}]}\n"
      "  - {name: rise, type: velocity, body: ball, axis: z}\n"
      "  - {name: height, type: position, body: ball, axis: z}\n"
      "  - {name: now, type: time}\n"
      "loss: {task: [{signals: [" +
      t.loss + "], when: {type: " + t.when +
      "}, shape: absolute, side: above}]}\nlearning: {dimensions_per_batch: 1, variations: 1, batch: 1}\n" + t.more;
  return RolloutModel({{kScenarioFileName, text}, {"plate.obj", kPlate}, {"cage.obj", kCage}});
}

RolloutOutput RunInitial(RolloutModel* model) {
  RolloutInput input;
  input.theta = model->initial_theta();
  return model->Run(input, {});
}

class ImpactSlopeTest : public testing::TestWithParam<double> {};

TEST_P(ImpactSlopeTest, IsOnePlusTheRestitutionAtDefaultSettings) {
  for (int i = 0; i < 20; ++i) {
    Throw t;
    t.speed = GetParam();
    t.gap = t.speed * (0.15 + 0.00021 * i);
    RolloutModel model = MakeModel(t);
    EXPECT_EQ(model.scene().rollout.step, 4e-3);
    t.loss = "rise";
    RolloutModel speed = MakeModel(t);
    const double restitution = RunInitial(&speed).loss / t.speed;
    EXPECT_NEAR(restitution, 1.0, 0.02) << i;  // nothing damps
    const RolloutOutput out = RunInitial(&model);
    // Straight above the target, the loss is the ball's height above it.
    EXPECT_NEAR(out.gradient(0), 1.0 + restitution, 0.02 * (1.0 + restitution)) << i;
    EXPECT_TRUE(out.gradient_reliable) << i << (out.doubts.empty() ? "" : out.doubts[0]);
  }
}

INSTANTIATE_TEST_SUITE_P(Speeds, ImpactSlopeTest, testing::Values(0.06, 0.5, 2.0));

// When it is back, 20 mm higher than it began: a plate that is higher by dp sends it back dp/v earlier, and from dp
// higher.
TEST(ImpactSlope, OfTheTimeOfArrivalIsTheProblems) {
  for (int i = 0; i < 10; ++i) {
    Throw t;
    t.gap = 0.04 + 1.1e-4 * i;
    t.loss = "rise";
    RolloutModel speed = MakeModel(t);
    const double restitution = RunInitial(&speed).loss / t.speed;
    t.loss = "now";
    t.when = "crossing, signal: height, at: " + std::to_string(37.0 + 1e3 * t.gap) + " mm";
    RolloutModel model = MakeModel(t);
    const RolloutOutput out = RunInitial(&model);
    EXPECT_NEAR(out.loss, t.gap / t.speed + (t.gap + 0.02) / (restitution * t.speed), 8e-3)
        << i;  // and some milliseconds of impact
    EXPECT_NEAR(out.gradient(0), -(1.0 + 1.0 / restitution) / t.speed, 0.02 * 2.0 / t.speed) << i;
  }
}

// Thrown obliquely onto the plate, with friction and damping, against tolerances 100 times tighter.
TEST(LossError, IsWithinAFactorOfThreeOfTheTruth) {
  std::mt19937_64 generator(5);
  const auto uniform = [&generator](double from, double to) {
    return from + (to - from) * static_cast<double>(generator() >> 11) * 0x1p-53;
  };
  int close = 0;
  constexpr int kCount = 60;
  for (int i = 0; i < kCount; ++i) {
    Throw t;
    t.speed = uniform(0.1, 1.0);
    t.sideways = uniform(0.0, 0.5);
    t.gap = uniform(2e-3, 2e-2);
    t.gravity = 9.81;
    t.material = "stiffness: 3e7 N/m^3, damping: " + std::to_string(uniform(0.0, 1.0)) +
                 " s/m, friction: 0.3, rolling_resistance: 0.02, slip_speed: 10 mm/s";
    t.axes = "[0.3 m, 0.2 m, -0.2 m]";
    RolloutModel model = MakeModel(t);
    t.rollout += ", tolerance: 1e-5";
    RolloutModel exact = MakeModel(t);
    const RolloutOutput out = RunInitial(&model);
    const double truth = std::abs(RunInitial(&exact).loss - out.loss);
    const double ratio = out.loss_error / truth;
    if (ratio > 1.0 / 3.0 && ratio < 3.0) ++close;
    EXPECT_GT(truth, 0.0);
  }
  EXPECT_GE(close, kCount * 9 / 10);
}

TEST(LossError, IsNotKnownForFixedSteps) {
  Throw t;
  t.rollout = "horizon: 0.4 s, step: 4 ms, integrator: bdf2";
  RolloutModel model = MakeModel(t);
  EXPECT_TRUE(std::isnan(RunInitial(&model).loss_error));
}

// Throws whose ball touches down while the loss is taken: the last node cannot follow, and a finer grid tells.
TEST(GradientReliable, IsNotWhereATighterToleranceChangesTheGradient) {
  Throw t;
  t.gap = 0.5 * (0.4 - 2e-4);
  RolloutModel alone = MakeModel(t);
  EXPECT_EQ(RunInitial(&alone).gradient_change, 0.0);  // nobody asked
  t.more = "gradient: {compare: finer}\n";
  RolloutModel compared = MakeModel(t);
  const RolloutOutput out = RunInitial(&compared);
  EXPECT_GT(out.gradient_change, 0.08);
  EXPECT_FALSE(out.gradient_reliable);
  EXPECT_EQ(out.doubts.back(), "tolerance");
  // And where it does not.
  t.gap = 0.05;
  RolloutModel calm = MakeModel(t);
  EXPECT_LT(RunInitial(&calm).gradient_change, 1e-3);
  EXPECT_TRUE(RunInitial(&calm).gradient_reliable);
}

// As the smallest limits that a scenario can set show.
TEST(GradientReliable, NamesEveryLimitThatIsPassed) {
  Throw t;
  t.gap = 5e-3;
  t.gravity = 9.81;  // it bounces again and again
  t.more = "gradient: {loss_error: 1e-9, touchdown: 1e-9}\n";
  RolloutModel model = MakeModel(t);
  EXPECT_EQ(RunInitial(&model).doubts, (std::vector<std::string>{"time steps", "touchdowns"}));
  t.gravity = 0.0;
  RolloutModel once = MakeModel(t);
  EXPECT_EQ(RunInitial(&once).doubts, std::vector<std::string>{"time steps"});
  t.rollout = "horizon: 0.4 s, step: 4 ms, integrator: bdf2";
  t.more = "gradient: {step: 1e-12}\n";
  RolloutModel fixed = MakeModel(t);
  EXPECT_EQ(RunInitial(&fixed).doubts, std::vector<std::string>{"rounding"});
}

}  // namespace time_steps_test
}  // namespace knap
