// Mechanisms against closed forms and independent integrations: a double pendulum, a tumbling top, a chain at rest
// under a sideways pull.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "sim/math/so3.h"
#include "tests/sim/dynamics/mechanisms.h"
#include "tests/sim/dynamics/runge_kutta.h"
#include "tests/sim/dynamics/scenes.h"

namespace knap {
namespace multibody_oracle_test {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kG = 9.81;

// Two point masses on massless rods; angles from the vertical, the second one relative to the first.
struct DoublePendulum {
  double m1 = 0.7, m2 = 0.4, l1 = 0.3, l2 = 0.45;

  Tree MakeTree() const {
    Tree tree;
    TreeBody rod;
    rod.joint = JointType::kRevolute;
    rod.axis = Vector3d::UnitY();
    rod.M = MakeSpatialInertia(m1, Vector3d(0, 0, -l1), Matrix3d::Zero());
    tree.AddBody(rod);
    rod.parent = 0;
    rod.X_PF.p = Vector3d(0, 0, -l1);
    rod.M = MakeSpatialInertia(m2, Vector3d(0, 0, -l2), Matrix3d::Zero());
    tree.AddBody(rod);
    return tree;
  }

  // (a, a', b, b') with a, b the absolute angles; Lagrange's equations of the textbooks.
  std::array<double, 4> Slope(const std::array<double, 4>& s) const {
    const double d = s[0] - s[2];
    const double M11 = (m1 + m2) * l1;
    const double M12 = m2 * l2 * std::cos(d);
    const double M21 = l1 * std::cos(d);
    const double M22 = l2;
    const double f1 = -m2 * l2 * s[3] * s[3] * std::sin(d) - (m1 + m2) * kG * std::sin(s[0]);
    const double f2 = l1 * s[1] * s[1] * std::sin(d) - kG * std::sin(s[2]);
    const double det = M11 * M22 - M12 * M21;
    return {s[1], (f1 * M22 - M12 * f2) / det, s[3], (M11 * f2 - M21 * f1) / det};
  }

  std::array<double, 4> Integrate(const std::array<double, 4>& s, double duration) const {
    return test::IntegrateRungeKutta([this](const std::array<double, 4>& at) { return Slope(at); }, s, duration, 20000);
  }
};

class OracleOrderTest : public testing::TestWithParam<int> {};

TEST_P(OracleOrderTest, ADoublePendulumConvergesAtTheIntegratorsOrder) {
  const DoublePendulum pendulum;
  const double duration = 0.8;
  const std::array<double, 4> end = pendulum.Integrate({1.2, 0.5, -0.4, -1.0}, duration);
  const Tree tree = pendulum.MakeTree();
  Dynamics dynamics(tree);
  ContactModel none({});
  double previous = 0.0;
  for (const double step : {4e-4, 2e-4, 1e-4}) {
    // The tree's second coordinate is relative.
    const SimulationOptions options = test::MakeOptions(step, duration, GetParam());
    const Trajectory t = Simulator(&dynamics, &none).Run(Vector2d(1.2, -1.6), Vector2d(0.5, -1.5), options);
    ASSERT_TRUE(t.certificate.converged);
    const int last = t.size() - 1;
    // A turn about y by a positive angle moves what hangs to −x: the textbook's angle is the other way round, and the
    // equations are odd in it.
    const double error = std::hypot(t.q(last)(0) - end[0], t.q(last).sum() - end[2], t.v(last)(0) - end[1]);
    if (previous > 0.0) {
      EXPECT_NEAR(std::log2(previous / error), GetParam(), 0.1) << step;
    }
    previous = error;
  }
  EXPECT_LT(previous, GetParam() == 1 ? 1e-2 : 1e-5);
}

INSTANTIATE_TEST_SUITE_P(Bdf, OracleOrderTest, testing::Values(1, 2));

// Largest relative change of energy of a torque-free top tumbling about its middle axis.
double MeasureEnergyDrift(int order, double step) {
  Tree tree;
  tree.gravity.setZero();
  TreeBody top;
  top.joint = JointType::kBall;
  const Matrix3d I = Vector3d(1e-3, 2e-3, 2.7e-3).asDiagonal();
  top.M = MakeSpatialInertia(0.5, Vector3d::Zero(), I);
  tree.AddBody(top);
  Dynamics dynamics(tree);
  ContactModel none({});
  const Vector3d v0(0.3, 6.0, -0.2);
  const Trajectory t =
      Simulator(&dynamics, &none).Run(tree.MakeDefaultPositions(), v0, test::MakeOptions(step, 2.0, order));
  EXPECT_TRUE(t.certificate.converged);
  double drift = 0.0;
  for (int k = 0; k < t.size(); ++k) {
    const Vector3d w = t.v(k);
    drift = std::max(drift, std::abs(w.dot(I * w) / v0.dot(I * v0) - 1.0));
  }
  return drift;
}

TEST(Top, EnergyDriftIsRankedByOrderAndStep) {
  EXPECT_LT(MeasureEnergyDrift(2, 1e-3), 0.1 * MeasureEnergyDrift(1, 1e-3));
  EXPECT_LT(MeasureEnergyDrift(2, 5e-4), 0.3 * MeasureEnergyDrift(2, 1e-3));
}

// Hung at one end and pulled sideways at the other one by a force H, link i of n stands at rest at
//
//   tan(angle_i) = H / (weight of the links below + half its own)
//
// the half of a discrete catenary whose lowest point is the pulled end.
TEST(Chain, AtRestIsADiscreteCatenary) {
  constexpr int kLinks = 15;
  constexpr double kMass = 0.0015;
  constexpr double kPitch = 0.03;
  constexpr double kPull = 0.08;  // [N]
  Tree tree;
  for (int i = 0; i < kLinks; ++i) {
    TreeBody link;
    link.parent = i - 1;
    link.joint = JointType::kRevolute;
    link.axis = Vector3d::UnitY();
    if (i > 0) link.X_PF.p.z() = -kPitch;
    link.M = MakeSpatialInertia(kMass, Vector3d(0, 0, -0.5 * kPitch), 1e-7 * Matrix3d::Identity());
    tree.AddBody(link);
  }
  Dynamics dynamics(tree);
  const VectorXd zero = VectorXd::Zero(kLinks);
  VectorXd q = zero;
  VectorXd r(kLinks), magnitude(kLinks), dx(kLinks);
  // Newton on the residual at rest: with c_v = c_a = 0 the linearisation is the static one.
  for (int iteration = 0; iteration < 50; ++iteration) {
    dynamics.CalcKinematics(q, zero, zero, 0.0);
    const Matrix3d R_BW = dynamics.kinematics()[kLinks - 1].X_WB.R.transpose();
    const Vector3d f = R_BW * Vector3d(kPull, 0.0, 0.0);
    const Vector3d arm(0.0, 0.0, -kPitch);
    ExternalWrench& pull = dynamics.external()[kLinks - 1];
    pull.F << arm.cross(f), f;
    // The force keeps its direction in the world: in B it turns against the body, df = f × eta.
    pull.dF_deta.topLeftCorner<3, 3>() = Skew(arm) * Skew(f);
    pull.dF_deta.bottomLeftCorner<3, 3>() = Skew(f);
    dynamics.CalcResidual(0.0, &r, &magnitude);
    if ((r.array().abs() <= 1e-14 * magnitude.array()).all()) break;
    ASSERT_TRUE(dynamics.Factor(zero, 0.0, 0.0));
    dynamics.Solve(r, &dx);
    q -= dx * std::min(1.0, 0.5 / dx.cwiseAbs().maxCoeff());
  }
  EXPECT_TRUE((r.array().abs() <= 1e-13 * magnitude.array()).all());
  double absolute = 0.0;
  for (int i = 0; i < kLinks; ++i) {
    absolute += q(i);
    const double below = kMass * kG * (kLinks - 1 - i + 0.5);
    EXPECT_NEAR(std::tan(-absolute), kPull / below, 1e-11 * (1.0 + kPull / below)) << i;
  }
}

// Nothing acts on three of the four joints at first: their rows have no scale until the first Newton step.
TEST(Finger, StartsFromRestUnderOneMotor) {
  const Tree tree = test::MakeFinger();
  for (int motor = 0; motor < tree.num_controls(); ++motor) {
    Dynamics dynamics(tree);
    ContactModel none({});
    ControlSequence controls;
    controls.values = 0.2 * VectorXd::Unit(tree.num_controls(), motor);
    const VectorXd start = VectorXd::Constant(tree.nv(), 0.3);
    const Trajectory t =
        Simulator(&dynamics, &none).Run(start, VectorXd::Zero(tree.nv()), test::MakeOptions(5e-3, 0.1, 2), controls);
    EXPECT_TRUE(t.certificate.converged) << motor;
    EXPECT_EQ(t.certificate.subdivided_steps, 0) << motor;
    EXPECT_GT((t.q(t.size() - 1) - start).norm(), 0.01) << motor;
  }
}

}  // namespace multibody_oracle_test
}  // namespace knap
