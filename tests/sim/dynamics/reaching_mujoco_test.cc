// configs/reaching.yaml under an action against MuJoCo with the same inertias, placements and dampings.
#include <gtest/gtest.h>

#include <cmath>

#include "sim/integrators/simulate.h"
#include "sim/rollout/control_commands.h"
#include "sim/rollout/scene_design.h"
#include "sim/scenarios/scenario_files.h"
#include "tests/sim/dynamics/mujoco_reference.h"

namespace knap {
namespace {

using Eigen::VectorXd;

TEST(ReachingMujoco, TrajectoriesUnderAnActionAgree) {
  const LoadedScenario scenario = LoadScenario(KNAP_CONFIGS "/reaching.yaml");
  ASSERT_TRUE(scenario.parsed.ok()) << scenario.parsed.FormatErrors();
  Scene scene = scenario.parsed.scene;
  const SceneDesign design(scene, scenario.files);
  // Another finger than that on file, so that the design counts: longer, wider, a slender tip.
  VectorXd theta(9);
  theta << 1.2, 0.9, 0.8, 1.1, 0.6, 0.7, 1.3, 0.8, 1.5;
  const DesignedShapes shapes = design.CalcShapes(theta);
  design.MoveAttachments(theta, &scene);
  const SceneModel model = BuildModel(scene, shapes);
  ASSERT_EQ(model.tree.nv(), 4);

  VectorXd a(CountControls(scene));
  for (Eigen::Index i = 0; i < a.size(); ++i) a(i) = 0.4 * std::sin(0.9 * static_cast<double>(i));
  const ControlSequence controls = MakeControlSequence(scene, model, CalcCommands(*scene.controls, a));
  Dynamics dynamics(model.tree);
  ContactModel none({});
  SimulationOptions options;
  options.step = scene.rollout.step;
  options.steps = 600;
  const Trajectory trajectory = Simulator(&dynamics, &none).Run(model.q0, model.v0, options, controls);
  ASSERT_TRUE(trajectory.certificate.converged);

  test::MujocoReference reference(model.tree);
  reference.Set(model.q0, model.v0, VectorXd::Zero(4));
  VectorXd largest = VectorXd::Zero(4);
  VectorXd error = VectorXd::Zero(4);
  for (Eigen::Index i = 0; i < controls.values.cols(); ++i) {
    VectorXd effort(4);
    for (Eigen::Index k = 0; k < 4; ++k) {
      const Actuator& actuator = model.tree.actuators()[static_cast<std::size_t>(k)];
      effort(model.tree.bodies()[static_cast<std::size_t>(actuator.body)].v_start) =
          actuator.effort_limit * controls.values(k, i);
    }
    reference.SetEffort(effort);
    reference.Run(1e-4, 1000);
    const VectorXd q = trajectory.q(trajectory.state_of_step(20 * (static_cast<int>(i) + 1)));
    largest = largest.cwiseMax(reference.q().cwiseAbs());
    error = error.cwiseMax((q - reference.q()).cwiseAbs());
  }
  for (Eigen::Index k = 0; k < 4; ++k) {
    EXPECT_GT(largest(k), 0.1) << k;  // [rad]: every joint takes part
    EXPECT_LT(error(k), 0.01 * largest(k)) << k;
  }
}

}  // namespace
}  // namespace knap
