// configs/reaching.yaml under an action against MuJoCo with the same inertias, placements and dampings.
#include <gtest/gtest.h>

#include <cmath>

#include "sim/integrators/simulate.h"
#include "sim/rollout/control_commands.h"
#include "sim/rollout/scene_design.h"
#include "sim/scenarios/scenario_files.h"
#include "tests/sim/dynamics/mujoco_reference.h"

namespace knap {
namespace reaching_mujoco_test {

using Eigen::MatrixXd;
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
  for (Eigen::Index i = 0; i < a.size(); ++i) a(i) = 0.6 * std::sin(0.05 * static_cast<double>(i) + 1.0);
  const ControlSequence controls = MakeControlSequence(scene, model, CalcCommands(*scene.controls, a));
  // MuJoCo with steps of 0.1 ms; every control is held for 0.1 s.
  const Eigen::Index n = controls.values.cols();
  test::MujocoReference reference(model.tree);
  reference.Set(model.q0, model.v0, VectorXd::Zero(4));
  MatrixXd expected(4, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    VectorXd effort(4);
    for (Eigen::Index k = 0; k < 4; ++k) {
      const Actuator& actuator = model.tree.actuators()[static_cast<std::size_t>(k)];
      effort(model.tree.bodies()[static_cast<std::size_t>(actuator.body)].v_start) =
          actuator.effort_limit * controls.values(k, i);
    }
    reference.SetEffort(effort);
    reference.Run(1e-4, 1000);
    expected.col(i) = reference.q();
  }

  // The step of the file, and a tenth of it, whose error is smaller in proportion: where a control jumps the scheme is
  // of first order.
  for (const int finer : {1, 10}) {
    Dynamics dynamics(model.tree);
    ContactModel none({});
    SimulationOptions options;
    options.step = scene.rollout.step / finer;
    options.steps = 600 * finer;
    ControlSequence held = controls;
    held.steps_per_interval *= finer;
    const Trajectory trajectory = Simulator(&dynamics, &none).Run(model.q0, model.v0, options, held);
    ASSERT_TRUE(trajectory.certificate.converged);
    MatrixXd error(4, n);
    for (Eigen::Index i = 0; i < n; ++i) {
      const int step = held.steps_per_interval * (static_cast<int>(i) + 1);
      error.col(i) = trajectory.q(trajectory.state_of_step(step)) - expected.col(i);
    }
    for (Eigen::Index k = 0; k < 4; ++k) {
      const double largest = expected.row(k).cwiseAbs().maxCoeff();
      EXPECT_GT(largest, 0.3) << k;  // [rad]: every joint takes part
      EXPECT_LT(error.row(k).cwiseAbs().maxCoeff(), 0.01 / finer * largest) << k << ", step " << options.step;
    }
  }
}

}  // namespace reaching_mujoco_test
}  // namespace knap
