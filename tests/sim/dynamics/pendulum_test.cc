// A pendulum and a torque-free top: closed forms, the integrators' orders, and the adjoint against the variational
// equation.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

#include "sim/gradient/adjoint.h"
#include "tests/sim/dynamics/runge_kutta.h"
#include "tests/sim/dynamics/scenes.h"

namespace knap {
namespace pendulum_test {

using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kG = 9.81;
constexpr double kMass = 0.3;
constexpr double kLength = 0.25;   // pivot to centre of mass
constexpr double kInertia = 2e-3;  // about the centre of mass
// g over the length of the equivalent point pendulum [1/s²].
constexpr double kOmega2 = kMass * kG * kLength / (kInertia + kMass * kLength * kLength);

// Swings about y; its child "tip" marks the centre of mass.
Tree MakePendulum() {
  Tree tree;
  TreeBody rod;
  rod.joint = JointType::kRevolute;
  rod.axis = Vector3d::UnitY();
  rod.M = MakeSpatialInertia(kMass, Vector3d(0, 0, -kLength), Vector3d(kInertia, kInertia, 1e-3).asDiagonal());
  tree.AddBody(rod);
  TreeBody tip;
  tip.parent = 0;
  tip.X_PF.p = Vector3d(0, 0, -kLength);
  tree.AddBody(tip);
  return tree;
}

Trajectory Swing(const Tree& tree, Dynamics* dynamics, double angle, double rate, const SimulationOptions& options) {
  ContactModel none({});
  EXPECT_EQ(tree.nv(), 1);
  const Trajectory t =
      Simulator(dynamics, &none).Run(VectorXd::Constant(1, angle), VectorXd::Constant(1, rate), options);
  EXPECT_TRUE(t.certificate.converged);
  EXPECT_EQ(t.certificate.subdivided_steps, 0);
  return t;
}

// From rest at `amplitude`: twice the time between two passages through the lowest point.
double MeasurePeriod(double amplitude, double step) {
  const Tree tree = MakePendulum();
  Dynamics dynamics(tree);
  const Trajectory t = Swing(tree, &dynamics, amplitude, 0.0, test::MakeOptions(step, 4.0, 2));
  std::vector<double> passages;
  for (int k = 1; k < t.size(); ++k) {
    const double before = t.q(k - 1)(0);
    const double after = t.q(k)(0);
    if (before * after < 0.0) passages.push_back(t.time(k - 1) + before / (before - after) * step);
  }
  EXPECT_GE(passages.size(), 2u);
  return 2.0 * (passages.at(1) - passages.at(0));
}

TEST(Pendulum, SmallSwingsHaveTheHarmonicPeriod) {
  const double harmonic = 2.0 * std::numbers::pi / std::sqrt(kOmega2);
  // The period grows by amplitude²/16; BDF2 at 1 ms errs by (ω h)²/3 = 1e-5.
  EXPECT_NEAR(MeasurePeriod(0.01, 1e-3) / harmonic, 1.0, 0.01 * 0.01 / 16.0 + 3e-5);
}

TEST(Pendulum, LargeSwingsHaveThePeriodOfTheEllipticIntegral) {
  for (const double amplitude : {1.0, 2.0, 3.0}) {
    const double expected = 4.0 / std::sqrt(kOmega2) * std::comp_ellint_1(std::sin(0.5 * amplitude));
    double previous = 0.0;
    for (const double step : {2e-3, 1e-3, 5e-4}) {
      const double error = std::abs(MeasurePeriod(amplitude, step) / expected - 1.0);
      if (previous > 0.0) {
        EXPECT_LT(error, 0.4 * previous) << amplitude;  // second order
      }
      previous = error;
    }
    EXPECT_LT(previous, 1e-4) << amplitude;
  }
}

// theta'' = −ω² sin theta and its variational equation by RK4: (angle, rate, ∂/∂angle0 of both, ∂/∂rate0 of both).
std::array<double, 6> IntegrateReference(double angle, double rate, double duration) {
  using State = std::array<double, 6>;
  const auto slope = [](const State& s) {
    const double stiffness = -kOmega2 * std::cos(s[0]);
    return State{s[1], -kOmega2 * std::sin(s[0]), s[3], stiffness * s[2], s[5], stiffness * s[4]};
  };
  return test::IntegrateRungeKutta(slope, State{angle, rate, 1.0, 0.0, 0.0, 1.0}, duration, 20000);
}

enum class Scheme { kBdf1, kBdf2, kTrBdf2 };

class PendulumOrderTest : public testing::TestWithParam<Scheme> {
 protected:
  static int order() { return GetParam() == Scheme::kBdf1 ? 1 : 2; }
  static SimulationOptions MakeOptions(double step, double duration) {
    SimulationOptions options = test::MakeOptions(step, duration, order());
    // Every step is accepted, as long as it may be. Its error is some tenth of BDF2's, 1e-7 at the end: Newton, tested
    // before the first iteration, leaves as much at 1e-11 in thousands of well-predicted steps.
    if (GetParam() == Scheme::kTrBdf2) {
      options.tolerance = 1e9;
      options.newton_tolerance = 1e-13;
    }
    return options;
  }
};

TEST_P(PendulumOrderTest, FinalStateAndGradientConvergeAtTheIntegratorsOrder) {
  const double duration = 1.5;
  const std::array<double, 6> reference = IntegrateReference(2.0, -1.0, duration);
  const Tree tree = MakePendulum();
  Dynamics dynamics(tree);
  ContactModel none({});
  double previous_state = 0.0;
  double previous_gradient = 0.0;
  for (const double step : {1e-3, 5e-4, 2.5e-4}) {
    const Trajectory t = Swing(tree, &dynamics, 2.0, -1.0, MakeOptions(step, duration));
    const int last = t.size() - 1;
    const double angle = t.q(last)(0);
    const double state_error = std::hypot(angle - reference[0], t.v(last)(0) - reference[1]);
    // The tip is at (−L sin, 0, −L cos): this direction turns its displacement into the angle's.
    const Vector3d direction = Vector3d(-std::cos(angle), 0.0, std::sin(angle)) / kLength;
    const TrajectoryGradient g = SweepAdjoint(t, {{last, 1, direction, Vector3d::Zero()}}, &dynamics, &none);
    ASSERT_TRUE(g.finite && g.solvable);
    const double gradient_error = std::hypot(g.pose0(0) - reference[2], g.v0(0) - reference[4]);
    if (previous_state > 0.0) {
      EXPECT_NEAR(std::log2(previous_state / state_error), order(), 0.15) << step;
      EXPECT_NEAR(std::log2(previous_gradient / gradient_error), order(), 0.15) << step;
    }
    previous_state = state_error;
    previous_gradient = gradient_error;
  }
  EXPECT_GT(std::hypot(reference[2], reference[4]), 0.1);
  EXPECT_LT(previous_gradient, order() == 1 ? 0.1 : 1e-3);
}

TEST_P(PendulumOrderTest, ATorqueFreeTopKeepsItsAngularMomentumAndEnergyAtTheOrder) {
  Tree tree;
  tree.gravity.setZero();
  TreeBody top;
  top.joint = JointType::kBall;
  // The middle axis is unstable: the top tumbles.
  const Eigen::Matrix3d I = Vector3d(1e-3, 2e-3, 2.7e-3).asDiagonal();
  top.M = MakeSpatialInertia(0.5, Vector3d::Zero(), I);
  tree.AddBody(top);
  Dynamics dynamics(tree);
  ContactModel none({});
  const VectorXd v0 = Vector3d(0.3, 6.0, -0.2);
  const Vector3d momentum = I * v0;
  double previous = 0.0;
  double previous_energy = 0.0;
  for (const double step : {2e-3, 1e-3, 5e-4}) {
    const Trajectory t = Simulator(&dynamics, &none).Run(tree.MakeDefaultPositions(), v0, MakeOptions(step, 2.0));
    ASSERT_TRUE(t.certificate.converged);
    double error = 0.0;
    double energy_error = 0.0;
    double tumbled = 0.0;
    for (int k = 0; k < t.size(); ++k) {
      const Eigen::Quaterniond q(Eigen::Vector4d(t.q(k)));
      EXPECT_NEAR(q.norm(), 1.0, 1e-12);
      const Vector3d w = t.v(k);
      error = std::max(error, (q * (I * w) - momentum).norm() / momentum.norm());
      energy_error = std::max(energy_error, std::abs(w.dot(I * w) / v0.dot(I * v0) - 1.0));
      tumbled = std::max(tumbled, -w.y() / 6.0);
    }
    EXPECT_GT(tumbled, 0.5);
    if (previous > 0.0) {
      EXPECT_LT(error, (order() == 1 ? 0.62 : 0.32) * previous) << step;
      EXPECT_LT(energy_error, (order() == 1 ? 0.62 : 0.32) * previous_energy) << step;
    }
    previous = error;
    previous_energy = energy_error;
  }
  EXPECT_LT(previous, order() == 1 ? 0.05 : 1e-3);
}

INSTANTIATE_TEST_SUITE_P(Schemes, PendulumOrderTest, testing::Values(Scheme::kBdf1, Scheme::kBdf2, Scheme::kTrBdf2));

}  // namespace pendulum_test
}  // namespace knap
