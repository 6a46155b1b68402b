// Records that were dropped come back with the same bits, and the adjoint over them is the same.
#include "sim/integrators/trajectory.h"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>

#include "sim/gradient/adjoint.h"
#include "sim/integrators/simulate.h"
#include "sim/policy/closed_loop.h"
#include "sim/signals/coordinate_signals.h"
#include "tests/sim/dynamics/mechanisms.h"
#include "tests/sim/dynamics/rope.h"

namespace knap {
namespace trajectory_test {

using Eigen::Vector3d;
using Eigen::VectorXd;

struct Recorded {
  Trajectory trajectory;
  TrajectoryGradient gradient;
  VectorXd bar_weights;  // of the policy, if there is one
};

Recorded Record(const Tree& tree, const std::vector<ContactPair>& pairs, const VectorXd& q0,
                const ControlSequence& controls, std::optional<ClosedLoop> policy, const SimulationOptions& options) {
  Dynamics dynamics(tree);
  ContactModel contacts(pairs);
  Feedback* feedback = policy ? &*policy : nullptr;
  Trajectory t =
      Simulator(&dynamics, &contacts).Run(q0, VectorXd::Constant(tree.nv(), 0.3), options, controls, feedback);
  EXPECT_TRUE(t.certificate.converged);
  std::vector<StateCotangent> cotangents;
  for (int n = 50; n <= t.whole_steps(); n += 50) {
    cotangents.push_back({t.state_of_step(n), tree.size() - 1, Vector3d(0.3, -0.8, 0.5), Vector3d(0.1, 0.2, 0.0)});
  }
  TrajectoryGradient gradient = SweepAdjoint(t, cotangents, &dynamics, &contacts, feedback);
  return {std::move(t), std::move(gradient), policy ? policy->bar_weights() : VectorXd()};
}

void ExpectSameStates(const Trajectory& a, const Trajectory& b, int k) {
  EXPECT_EQ(a.q(k), b.q(k)) << k;
  EXPECT_EQ(a.v(k), b.v(k)) << k;
  EXPECT_EQ(a.xi(k), b.xi(k)) << k;
  EXPECT_EQ(a.vdot(k), b.vdot(k)) << k;
  BristleState of_a, of_b;
  a.GetBristles(k, &of_a);
  b.GetBristles(k, &of_b);
  EXPECT_EQ(of_a.bent.id, of_b.bent.id) << k;
  EXPECT_EQ(of_a.bent.z, of_b.bent.z) << k;
  EXPECT_EQ(of_a.rate, of_b.rate) << k;
}

// More than five blocks, of which a trajectory without memory keeps three. Returns how many steps were cut.
int ExpectTheSameWithoutMemory(const Tree& tree, const std::vector<ContactPair>& pairs, const VectorXd& q0,
                               const ControlSequence& controls, SimulationOptions options,
                               const std::optional<ClosedLoop>& policy = {}) {
  options.steps = 5 * kStepsPerBlock + 17;
  const Recorded whole = Record(tree, pairs, q0, controls, policy, options);
  EXPECT_EQ(whole.trajectory.replays(), 0);
  options.memory = 0;
  const Recorded bare = Record(tree, pairs, q0, controls, policy, options);
  EXPECT_EQ(bare.trajectory.replays(), 3);  // the sweep met its last three blocks as they were left
  EXPECT_EQ(whole.gradient.pose0, bare.gradient.pose0);
  EXPECT_EQ(whole.gradient.v0, bare.gradient.v0);
  EXPECT_EQ(whole.gradient.controls, bare.gradient.controls);
  EXPECT_EQ(whole.gradient.loss_rounding, bare.gradient.loss_rounding);
  EXPECT_EQ(whole.bar_weights, bare.bar_weights);
  EXPECT_GT(whole.gradient.v0.norm(), 0.0);
  const int states = whole.trajectory.size();
  EXPECT_EQ(bare.trajectory.size(), states);
  if (bare.trajectory.size() != states) return -1;
  for (int k = 0; k < states; ++k) ExpectSameStates(whole.trajectory, bare.trajectory, k);
  for (int k = states - 1; k >= 0; k -= 97) ExpectSameStates(whole.trajectory, bare.trajectory, k);
  return whole.trajectory.certificate.subdivided_steps;
}

TEST(Trajectory, ARopeInContactComesBackWithItsBristles) {
  const test::WoundRope rope = test::MakeWoundRope(test::MakeSpool(0.05, 0.1), {2e8, 2.0, 0.3, 0.0, 1e-3, 2e-5});
  SimulationOptions options;
  options.step = 2e-3;
  ExpectTheSameWithoutMemory(rope.scene.tree, rope.scene.contacts, rope.scene.q0(), {}, options);
}

TEST(Trajectory, AFingerComesBackUnderItsControls) {
  const Tree tree = test::MakeFinger();
  ControlSequence controls;
  controls.steps_per_interval = 20;
  controls.values.resize(tree.num_controls(), 30);
  for (int i = 0; i < controls.values.size(); ++i) controls.values.data()[i] = 0.2 * std::sin(1.0 + 0.7 * i);
  SimulationOptions options;
  options.step = 2e-3;
  ExpectTheSameWithoutMemory(tree, {}, tree.MakeDefaultPositions(), controls, options);
}

// Blocks begin within intervals, whose controls the policy set from states of the block before.
TEST(Trajectory, AFingerComesBackUnderItsPolicy) {
  const Tree tree = test::MakeFinger();
  std::vector<PolicyInput> inputs;
  std::vector<PolicyOutput> outputs;
  for (const TreeBody& body : tree.bodies()) {
    if (CountDof(body.joint) != 1) continue;
    inputs.push_back({MakeCoordinateSignal(body.q_start, body.v_start), 0.0, 1.0});
  }
  for (int i = 0; i < tree.num_controls(); ++i) outputs.push_back({i, 0.0, 0.5});
  const Network network(static_cast<int>(inputs.size()), {6}, tree.num_controls(), true);
  ControlSequence controls;
  controls.steps_per_interval = 20;
  controls.values.setZero(tree.num_controls(), 5 * kStepsPerBlock / 20 + 1);
  VectorXd weights(network.num_weights());
  for (int i = 0; i < weights.size(); ++i) weights(i) = std::sin(1.0 + 0.7 * i);
  const ClosedLoop policy(network, inputs, outputs, weights, static_cast<int>(controls.values.cols()), 0);
  SimulationOptions options;
  options.step = 2e-3;
  ExpectTheSameWithoutMemory(tree, {}, tree.MakeDefaultPositions(), controls, options, policy);
}

// So is what the choice of steps carries from one to the next.
TEST(Trajectory, ChosenStepsComeBackToo) {
  const test::WoundRope rope = test::MakeWoundRope(test::MakeSpool(0.05, 0.1), {2e8, 2.0, 0.3, 0.0, 1e-3, 2e-5});
  SimulationOptions options;
  options.step = 4e-3;
  options.tolerance = 1e-2;
  ExpectTheSameWithoutMemory(rope.scene.tree, rope.scene.contacts, rope.scene.q0(), {}, options);
}

TEST(Trajectory, ChosenStepsOfAFingerComeBackUnderItsControls) {
  const Tree tree = test::MakeFinger();
  ControlSequence controls;
  controls.steps_per_interval = 20;
  controls.values.resize(tree.num_controls(), 30);
  for (int i = 0; i < controls.values.size(); ++i) controls.values.data()[i] = 0.2 * std::sin(1.0 + 0.7 * i);
  SimulationOptions options;
  options.step = 2e-3;
  options.tolerance = 1e-4;
  ExpectTheSameWithoutMemory(tree, {}, tree.MakeDefaultPositions(), controls, options);
}

// Steps that had to be cut make a block longer than its whole steps.
TEST(Trajectory, SubstepsComeBackToo) {
  const test::WoundRope rope = test::MakeWoundRope(test::MakeSpool(0.05, 0.1), {2e8, 2.0, 0.3, 0.0, 1e-3, 2e-5});
  SimulationOptions options;
  options.step = 4e-3;
  options.newton_max_iterations = 6;
  EXPECT_GT(ExpectTheSameWithoutMemory(rope.scene.tree, rope.scene.contacts, rope.scene.q0(), {}, options), 0);
}

}  // namespace trajectory_test
}  // namespace knap
