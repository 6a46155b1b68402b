// configs/winding_turn.yaml: the gripper winds the rope, from a start where none of it is wound, and lets go; losses
// and success say what became of it; the gradient is that of the loss.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "sim/scenarios/apply_variation.h"
#include "tests/sim/rollout/winding_scene.h"

namespace knap {
namespace winding_turn_test {

using Eigen::Vector3d;
using Eigen::VectorXd;

// Turns of the rope around the spool's axis, and how far from it its joints are at most [m].
struct Winding {
  double turns = 0.0;
  double reach = 0.0;
};

Winding MeasureWinding(const SceneModel& model, const Dynamics& dynamics, double pitch) {
  const Pose& X_WS = dynamics.kinematics()[model.body_index.at("spool")].X_WB;
  const std::vector<int>& links = model.links.at("rope");
  Winding out;
  Vector3d before = Vector3d::Zero();
  for (std::size_t i = 0; i <= links.size(); ++i) {
    const Pose& X_WL = dynamics.kinematics()[links[std::min(i, links.size() - 1)]].X_WB;
    const Vector3d joint = X_WS.ApplyInverse(i < links.size() ? X_WL.p : X_WL * Vector3d(pitch, 0.0, 0.0));
    if (i > 0) {
      out.turns += std::atan2(before.y() * joint.z() - before.z() * joint.y(), before.tail<2>().dot(joint.tail<2>())) /
                   (2.0 * std::numbers::pi);
    }
    out.reach = std::max(out.reach, joint.tail<2>().norm());
    before = joint;
  }
  return out;
}

TEST(WindingTurn, TheGripperWindsTheRopeWhereverDownIs) {
  const RolloutModel rollout = test::LoadConfig(
      "winding_turn.yaml",
      {"rollout.horizon=3.2 s", "loss.task=[]", "loss.distillation=[]", "success.of[1].when.from=3.1 s"});
  const double pitch = rollout.scene().ropes[0].pitch;
  for (const auto& [azimuth, rise] : std::vector<std::pair<double, double>>{{0.0, -1.0}, {0.0, 0.0}, {3.6, 0.5}}) {
    Scene scene = rollout.scene();
    ApplyVariation(scene, std::vector{azimuth, rise});
    const SceneModel model = test::Build(rollout, scene, rollout.initial_theta());
    Dynamics dynamics(model.tree);
    ContactModel contacts(model.contacts, model.grips);
    Simulator simulator(&dynamics, &contacts);
    SimulationOptions options;
    options.step = scene.rollout.step;
    options.steps = static_cast<int>(std::lround(scene.rollout.horizon / scene.rollout.step));
    dynamics.CalcKinematics(model.q0, model.v0, model.v0, 0.0);
    const Winding start = MeasureWinding(model, dynamics, pitch);
    EXPECT_LT(std::abs(start.turns), 0.25);  // straight
    EXPECT_GT(start.reach, 0.85);
    Winding end;
    simulator.observer = [&](double) { end = MeasureWinding(model, dynamics, pitch); };
    ASSERT_TRUE(simulator.Run(model.q0, model.v0, options).certificate.converged);
    EXPECT_GT(std::abs(end.turns), 3.5) << azimuth << " " << rise;
    EXPECT_LT(end.reach, 0.1) << azimuth << " " << rise;
  }
}

TEST(WindingTurn, SuccessTellsAHeldRopeFromADroppedOne) {
  RolloutModel rollout = test::LoadConfig("winding_turn.yaml", {});
  RolloutInput input;
  input.variation = {4.8, -0.38};
  input.want_gradient = false;
  input.theta = test::MakeTheta(rollout, 0.05);
  const RolloutOutput prism = rollout.Run(input, {});
  ASSERT_TRUE(prism.certificate.converged);
  EXPECT_FALSE(prism.success);
  input.theta = test::MakeTheta(rollout, 0.125);
  const RolloutOutput wide = rollout.Run(input, {});
  ASSERT_TRUE(wide.certificate.converged);
  EXPECT_TRUE(wide.success);
  EXPECT_LT(wide.loss, 0.01 * prism.loss);
}

// In the middle of this one, 0.07 s after the release, Newton's method once found a root at which the rope had been
// thrown 1e7 times around, and took it.
TEST(WindingTurn, NothingIsThrownAwayWhereNewtonOvershoots) {
  RolloutModel rollout =
      test::LoadConfig("winding_turn.yaml", {"rollout.horizon=3.4 s", "loss.task[0].when.until=3.4 s",
                                             "loss.distillation[0].when.until=3.4 s", "success.of[1].when.from=3.3 s"});
  RolloutInput input;
  input.variation = {2.6350349082143723, -0.023004765494746948};
  input.want_gradient = false;
  input.theta.resize(4);
  input.theta << 0.09204957020519487, 0.10259176450643105, 0.07014830974267612, 0.060135642727003044;
  const RolloutOutput out = rollout.Run(input, {});
  ASSERT_TRUE(out.certificate.converged);
  EXPECT_LT(out.loss, 0.1);
}

// Winding begins, one end held at a point inside the spool, which moves with all of the cage, and the spool turns at
// once.
TEST(WindingTurn, GradientsEqualDifferences) {
  RolloutModel rollout = test::LoadConfig(
      "winding_turn.yaml",
      {"rollout.horizon=0.2 s", "grips[0].point[2]=20 mm", "rollout.newton_tolerance=1e-12",
       "bodies.spool.joint.motion.segments[0].duration=0.1 s", "bodies.spool.joint.motion.segments[0].ramp=0.05 s",
       "bodies.spool.joint.motion.segments[1].duration=0.5 s", "bodies.spool.joint.motion.segments[1].ramp=0.1 s",
       "signals.rise.since=0.1 s", "loss.task[0].when.from=0.1 s", "loss.task[0].when.until=0.2 s",
       "loss.distillation[0].when.from=0.1 s", "loss.distillation[0].when.until=0.2 s",
       "loss.distillation[0].when.reduce=sum", "success.of[1].when.from=0.1 s"});
  RolloutInput input;
  input.variation = {0.7, -0.6};
  input.theta = test::MakeTheta(rollout, 0.07);
  input.theta(1) = 0.09;
  test::ExpectGradientsEqualDifferences(&rollout, input, test::MakeTheta(rollout, 0.06), {1e-6, 1e-7}, 1e-5);
}

}  // namespace winding_turn_test
}  // namespace knap
