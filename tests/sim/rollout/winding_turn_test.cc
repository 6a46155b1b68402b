// configs/winding_turn.yaml: the gripper winds the rope, from a start where none of it is wound, and lets go; losses
// and success say what became of it; the gradient is that of the loss.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "sim/rollout/height_loss.h"
#include "sim/scenarios/numeric_keys.h"
#include "tests/sim/rollout/differences.h"
#include "tests/sim/rollout/winding_scene.h"

namespace knap {
namespace {

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
  const RolloutModel rollout = test::LoadConfig("winding_turn.yaml", {"rollout.horizon=3.2 s"});
  const double pitch = rollout.scene().ropes[0].pitch;
  for (const auto& [azimuth, rise] : std::vector<std::pair<double, double>>{{0.0, -1.0}, {0.0, 0.0}, {3.6, 0.5}}) {
    Scene scene = rollout.scene();
    ApplyVariation(scene, std::vector{azimuth, rise});
    const SceneModel model = test::Build(rollout, scene, rollout.design()->initial_theta());
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

}  // namespace
}  // namespace knap
