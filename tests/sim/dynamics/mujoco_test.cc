// The dynamics of mechanisms against MuJoCo 2.2.2: accelerations at random states, short trajectories at tiny
// steps.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "sim/integrators/simulate.h"
#include "tests/sim/dynamics/mechanisms.h"
#include "tests/sim/dynamics/mujoco_reference.h"

namespace knap {
namespace mujoco_test {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// The residual is affine in vdot: its columns are the mass matrix.
VectorXd SolveAcceleration(Dynamics* dynamics, const VectorXd& q, const VectorXd& v) {
  const int nv = dynamics->tree().nv();
  const auto residual = [&](const VectorXd& vdot) {
    VectorXd r(nv);
    VectorXd magnitude(nv);
    dynamics->CalcKinematics(q, v, vdot, 0.0);
    dynamics->CalcResidual(0.0, &r, &magnitude);
    return r;
  };
  const VectorXd r0 = residual(VectorXd::Zero(nv));
  MatrixXd M(nv, nv);
  for (int k = 0; k < nv; ++k) M.col(k) = residual(VectorXd::Unit(nv, k)) - r0;
  return M.ldlt().solve(-r0);
}

Tree MakeFreeChain() {
  const Tree hung = test::MakeChain(15, 2e-5);
  Tree tree;
  TreeBody slide;
  slide.joint = JointType::kTranslation;
  tree.AddBody(slide);
  for (TreeBody body : hung.bodies()) {
    ++body.parent;
    // The first link hangs from nothing.
    if (body.parent == 0) body.law.damping = 0.0;
    tree.AddBody(body);
  }
  return tree;
}

struct Mechanism {
  const char* name;
  Tree tree;
  double rate;      // of the random rates
  double duration;  // of the trajectory [s]
};

class MujocoTest : public testing::TestWithParam<int> {
 protected:
  static Mechanism Make(int which) {
    if (which == 0) return {"chain", MakeFreeChain(), 3.0, 0.05};
    return {"finger", test::MakeFinger(), 2.0, 0.2};
  }
};

TEST_P(MujocoTest, AccelerationsAgreeAtRandomStates) {
  const Mechanism mechanism = Make(GetParam());
  const Tree& tree = mechanism.tree;
  Dynamics dynamics(tree);
  test::MujocoReference reference(tree);
  std::mt19937_64 generator(5);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  const auto random = [&](Eigen::Index n, double scale) {
    return VectorXd(scale * VectorXd::NullaryExpr(n, [&] { return uniform(generator); }));
  };
  for (int sample = 0; sample < 20; ++sample) {
    VectorXd q(tree.nq());
    tree.AddIncrement(tree.MakeDefaultPositions(), random(tree.nv(), 1.0), &q);
    const VectorXd v = random(tree.nv(), mechanism.rate);
    dynamics.controls() = random(tree.num_controls(), 1.0);
    VectorXd effort = VectorXd::Zero(tree.nv());
    for (int a = 0; a < tree.num_controls(); ++a) {
      const Actuator& actuator = tree.actuators()[a];
      effort(tree.bodies()[actuator.body].v_start) = actuator.effort_limit * dynamics.controls()(a);
    }
    reference.Set(q, v, effort);
    const VectorXd theirs = reference.CalcAcceleration();
    const VectorXd ours = SolveAcceleration(&dynamics, q, v);
    EXPECT_GT(theirs.norm(), 1.0);
    // Two factorisations of a mass matrix whose condition is about 1e6.
    EXPECT_LT((ours - theirs).norm(), 1e-8 * theirs.norm()) << mechanism.name << " " << sample;
  }
}

TEST_P(MujocoTest, ShortTrajectoriesAgreeAtTinySteps) {
  const Mechanism mechanism = Make(GetParam());
  const Tree& tree = mechanism.tree;
  Dynamics dynamics(tree);
  ContactModel none({});
  test::MujocoReference reference(tree);
  VectorXd start(tree.nv());
  VectorXd v0(tree.nv());
  for (int k = 0; k < tree.nv(); ++k) {
    start(k) = 0.4 * std::sin(1.0 + k);
    v0(k) = mechanism.rate * std::cos(2.0 * k);
  }
  VectorXd q0(tree.nq());
  tree.AddIncrement(tree.MakeDefaultPositions(), start, &q0);
  reference.Set(q0, v0, VectorXd::Zero(tree.nv()));
  reference.Run(1e-5, static_cast<int>(std::lround(mechanism.duration / 1e-5)));
  double previous = 0.0;
  for (const double step : {2e-4, 1e-4, 5e-5}) {
    SimulationOptions options;
    options.step = step;
    options.steps = static_cast<int>(std::lround(mechanism.duration / step));
    options.newton_tolerance = 1e-13;
    const Trajectory t = Simulator(&dynamics, &none).Run(q0, v0, options);
    ASSERT_TRUE(t.certificate.converged);
    const int last = t.size() - 1;
    const double error = (t.q(last) - reference.q()).norm() + mechanism.duration * (t.v(last) - reference.v()).norm();
    if (previous > 0.0) {
      EXPECT_NEAR(std::log2(previous / error), 2.0, 0.25) << mechanism.name << " " << step;
    }
    previous = error;
  }
  const double moved = (reference.q() - q0).norm();
  EXPECT_GT(moved, 0.1);
  EXPECT_LT(previous, 1e-3 * moved);
}

INSTANTIATE_TEST_SUITE_P(ChainAndFinger, MujocoTest, testing::Values(0, 1));

}  // namespace mujoco_test
}  // namespace knap
