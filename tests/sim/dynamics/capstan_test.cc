// A rope over a fixed cylinder, a load at either end. In the limit of a thin rope the tensions on its two sides differ
// at most by the capstan relation T1/T0 = e^(mu π) [Euler 1769]. A rope of thickness t pulls at the radius R + t/2 of
// its joints and rubs at R; the balance of moments about the axis, (R + t/2) dT = R mu T dφ, leaves
//
//   ln K = mu π R / (R + t/2)
//
// Links that turn by φ at a time change this by φ²/6, 0.6% here; that, and the inertia of the links on the cylinder, is
// what the tolerance of 2% in ln K is for.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "tests/sim/dynamics/pair_scene.h"

namespace knap {
namespace capstan_test {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kGravity = 9.81;
constexpr double kRadius = 0.04;
constexpr double kThickness = 0.003;
constexpr int kWrapped = 16;         // bends over half a turn
constexpr double kLightLoad = 0.05;  // [kg]

double CalcLogRatio(double friction) { return friction * std::numbers::pi * kRadius / (kRadius + 0.5 * kThickness); }

struct DrapedRope {
  test::PairScene scene;
  int heavy = 0;  // the links that carry the loads
  int light = 0;
};

// Around a cylinder along y, in the plane y = 0: 3 links hang on the side of the heavy load, at −x, 8 on that of the
// light one, which goes up.
DrapedRope MakeDrapedRope(double friction, double heavy_load) {
  constexpr int kHeavyLinks = 3, kLightLinks = 8;
  const double reach = kRadius + 0.5 * kThickness;
  const double bend = std::numbers::pi / kWrapped;
  const double pitch = 2.0 * reach * std::tan(0.5 * bend);
  // Joints from the heavy end to the light one: each link touches at its middle.
  std::vector<Vector2d> joints;
  for (int i = kHeavyLinks; i > 0; --i) joints.emplace_back(-reach, -(i + 0.5) * pitch);
  for (int i = 0; i <= kWrapped + 1; ++i) {
    const double angle = std::numbers::pi - (i - 0.5) * bend;
    joints.push_back(reach / std::cos(0.5 * bend) * Vector2d(std::cos(angle), std::sin(angle)));
  }
  for (int i = 1; i <= kLightLinks; ++i) joints.emplace_back(reach, -(i + 0.5) * pitch);

  DrapedRope out;
  test::PairScene& scene = out.scene;
  const int cylinder = scene.AddFixed(
      {Eigen::AngleAxisd(-0.5 * std::numbers::pi, Vector3d::UnitX()).toRotationMatrix(), Vector3d::Zero()});
  const CapsuleGeometry round{kRadius, 0.01, Vector3d::Zero()};
  const Vector3d size(pitch - 5e-4, kThickness, kThickness);
  const BoxGeometry box{0.5 * size, Vector3d(0.5 * pitch, 0.0, 0.0)};
  const ContactMaterial material{5e9, 2.0, friction, 0.0, 1e-3, 2e-5};
  constexpr double kLinkMass = 5e-5;
  const Matrix3d I = kLinkMass * pitch * pitch / 12.0 * Matrix3d::Identity();
  Matrix3d R_WP = Matrix3d::Identity();
  const int links = static_cast<int>(joints.size()) - 1;
  int parent = -1;
  for (int i = 0; i < links; ++i) {
    const Vector2d along = (joints[i + 1] - joints[i]).normalized();
    Matrix3d R_WB;
    R_WB.col(0) = Vector3d(along.x(), 0.0, along.y());
    R_WB.col(1) = Vector3d::UnitY();
    R_WB.col(2) = R_WB.col(0).cross(R_WB.col(1));
    TreeBody link;
    link.joint = JointType::kBall;
    link.law.damping = 1e-7;
    link.M = MakeSpatialInertia(kLinkMass, box.center, I);
    if (i == 0) {
      TreeBody slide;
      slide.joint = JointType::kTranslation;
      parent = scene.tree.AddBody(slide);
      scene.q.insert(scene.q.end(), {joints[0].x(), 0.0, joints[0].y()});
      scene.v.insert(scene.v.end(), 3, 0.0);
      link.law.damping = 0.0;
    } else {
      link.X_PF.p.x() = pitch;
    }
    link.parent = parent;
    if (i == 0) link.M += MakeSpatialInertia(heavy_load, Vector3d::Zero(), 1e-5 * Matrix3d::Identity());
    if (i == links - 1) {
      link.M += MakeSpatialInertia(kLightLoad, Vector3d(pitch, 0.0, 0.0), 1e-5 * Matrix3d::Identity());
    }
    const Eigen::Quaterniond q(Matrix3d(R_WP.transpose() * R_WB));
    scene.q.insert(scene.q.end(), {q.x(), q.y(), q.z(), q.w()});
    scene.v.insert(scene.v.end(), 3, 0.0);
    parent = scene.tree.AddBody(link);
    if (i == 0) out.heavy = parent;
    out.light = parent;
    scene.Touch(parent, box, cylinder, round, material);
    R_WP = R_WB;
  }
  return out;
}

// Height of the heavy load's end at whole steps.
std::vector<double> RunRope(const DrapedRope& rope, double step, int steps) {
  Dynamics dynamics(rope.scene.tree);
  ContactModel contacts(rope.scene.contacts);
  SimulationOptions options;
  options.step = step;
  options.steps = steps;
  const Trajectory t = Simulator(&dynamics, &contacts).Run(rope.scene.q0(), rope.scene.v0(), options);
  EXPECT_TRUE(t.certificate.converged);
  std::vector<double> heights;
  for (int n = 0; n <= t.whole_steps(); ++n) {
    const int k = t.state_of_step(n);
    dynamics.CalcKinematics(t.q(k), t.v(k), t.vdot(k), t.time(k));
    heights.push_back(dynamics.kinematics()[rope.heavy].X_WB.p.z());
  }
  return heights;
}

class CapstanTest : public testing::TestWithParam<double> {};

// While it slides, both loads accelerate by a: T1/T0 = m1 (g − a) / (m0 (g + a)).
TEST_P(CapstanTest, SlidesWithThatRatioOfTensions) {
  const double wanted = CalcLogRatio(GetParam());
  const double pull = 0.9;  // wanted acceleration [m/s²]
  const double heavy = kLightLoad * std::exp(wanted) * (kGravity + pull) / (kGravity - pull);
  const double step = 5e-4;
  const std::vector<double> z = RunRope(MakeDrapedRope(GetParam(), heavy), step, 500);
  // Mean speeds at 0.1 s and 0.25 s, the first pull over.
  const auto speed = [&](int n) { return (z[n] - z[n - 10]) / (10.0 * step); };
  const double a = -(speed(500) - speed(200)) / (300.0 * step);
  const double log_ratio = std::log(heavy * (kGravity - a) / (kLightLoad * (kGravity + a)));
  EXPECT_NEAR(log_ratio / wanted, 1.0, 0.02) << "a = " << a << " m/s²";
  EXPECT_LT(z[500] - z[200], -0.01);
}

TEST_P(CapstanTest, HoldsBelowThatRatioAndGivesWayAboveIt) {
  const double wanted = CalcLogRatio(GetParam());
  const auto creep = [&](double share) {
    const std::vector<double> z = RunRope(MakeDrapedRope(GetParam(), kLightLoad * std::exp(share * wanted)), 5e-4, 600);
    return z[400] - z[600];  // within the last 0.1 s
  };
  EXPECT_LT(std::abs(creep(0.95)), 5e-5);
  EXPECT_GT(creep(1.05), 1e-3);
}

INSTANTIATE_TEST_SUITE_P(Friction, CapstanTest, testing::Values(0.2, 0.4));

}  // namespace capstan_test
}  // namespace knap
