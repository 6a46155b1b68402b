// A glancing contact with a moving wall against the impulsive collision of a rigid sphere with Coulomb friction
// (restitution 1, as nothing damps): with V the approach speed, s the slip of the touching point and μ,
//
//   J_n = 2 m V,   J_t = μ J_n while it slips throughout (|s| > 7 μ V),   J_t = 2/7 m |s| when it comes to stick.
//
// The sphere penetrates by δ ∝ E^(−1/3), so the result errs by O(δ/r); the step follows the duration ∝ δ/V.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "sim/multibody/motions.h"
#include "tests/sim/dynamics/scenes.h"

namespace knap {
namespace impact_test {

using Eigen::Vector3d;
using test::BallSample;
using test::BallScene;

constexpr double kWallFriction = 0.3;

struct Impact {
  Vector3d v;  // after the collision, in the world
  Vector3d w;
};

// The wall's face looks along +y and moves at `wall_velocity`; the ball starts just outside it.
Impact Collide(double stiffness, int steps_a_contact, const Vector3d& wall_velocity, const Vector3d& v,
               const Vector3d& w) {
  BallScene scene;
  scene.tree.gravity.setZero();
  scene.AddTool([=](double t) { return CalcConstantVelocity(wall_velocity, Vector3d::Zero(), t); });
  scene.AddBall();
  scene.Touch(scene.tool, {stiffness, 0.0, kWallFriction, 0.0, 1e-6},
              std::make_shared<ContactMesh>(test::MakeBar(0.03, 0.012, 0.03, 1, 1)));
  const double V = wall_velocity.y() - v.y();
  // Energy balance of the half-space: m V²/2 = π E r δ³/3; the contact lasts about 2.9 δ/V.
  const double depth = std::cbrt(1.5 * scene.mass * V * V / (std::numbers::pi * stiffness * scene.radius));
  const double duration = 2.9 * depth / V;
  // Within one of the face's two triangles: refined faces are mesh_refinement_test.cc's.
  scene.Start(Vector3d(0.008, scene.radius + 0.1 * depth, 0.009), v, w);
  const auto samples = RunBall(scene, test::MakeOptions(duration / steps_a_contact, 1.5 * duration, 2));
  EXPECT_EQ(samples.back().f.norm(), 0.0) << "still in contact";
  return {samples.back().v, samples.back().w};
}

// Impulses on a rigid sphere at its point −r y.
Impact CollideRigidly(const Vector3d& wall_velocity, const Vector3d& v, const Vector3d& w) {
  const BallScene scene;
  const double V = wall_velocity.y() - v.y();
  const Vector3d arm(0.0, -scene.radius, 0.0);
  Vector3d slip = v - wall_velocity + w.cross(arm);
  slip.y() = 0.0;
  const double tangential = std::min(kWallFriction * 2.0 * scene.mass * V, 2.0 / 7.0 * scene.mass * slip.norm());
  const Vector3d J = Vector3d(0.0, 2.0 * scene.mass * V, 0.0) - tangential * slip.normalized();
  return {v + J / scene.mass, w + arm.cross(J) / scene.inertia()};
}

class ImpactTest : public testing::TestWithParam<double> {};

TEST_P(ImpactTest, ApproachesTheRigidCollision) {
  // The slip's direction is oblique to the mesh's edges, partly from spin, partly from the wall. Nothing spins about
  // the normal: a spot of contact resists that, a rigid sphere's point does not.
  const double V = 0.2;
  const double slip = GetParam() * 7.0 * kWallFriction * V;
  const Vector3d wall(0.05, 0.15, -0.02);
  const Vector3d w(-0.3 * slip / 0.01, 0.0, 0.2 * slip / 0.01);
  const Vector3d v = wall + Vector3d(0.4 * slip, -V, 0.5 * slip);  // slip·(0.6, 0.8) in all
  const Impact rigid = CollideRigidly(wall, v, w);
  double previous = 0.0;
  for (const double stiffness : {1e8, 1e11, 1e14}) {
    const Impact impact = Collide(stiffness, 400, wall, v, w);
    const double error = (impact.v - rigid.v).norm() / V + 0.01 * (impact.w - rigid.w).norm() / V;
    RecordProperty("error at " + std::to_string(stiffness), std::to_string(error));
    // δ/r is 4.3% at 1e8 and a tenth of it at each next stiffness.
    if (previous > 0.0) {
      EXPECT_LT(error, 0.2 * previous) << stiffness;
    }
    previous = error;
  }
  EXPECT_LT(previous, 2e-3);
}

// Shares of the slip that friction can just stop.
INSTANTIATE_TEST_SUITE_P(Regimes, ImpactTest, testing::Values(0.3, 0.9, 1.1, 2.0));

TEST(Impact, ReturnsTheApproachSpeedAsTheStepFalls) {
  const Vector3d wall(0.0, 0.15, 0.0);
  const Vector3d v(0.0, -0.05, 0.0);
  double previous = 0.0;
  for (const int steps : {50, 100, 200}) {
    const double error = std::abs(Collide(1e11, steps, wall, v, Vector3d::Zero()).v.y() - 0.35) / 0.2;
    if (previous > 0.0) {
      EXPECT_LT(error, 0.35 * previous) << steps;  // second order
    }
    previous = error;
  }
  EXPECT_LT(previous, 1e-3);
}

}  // namespace impact_test
}  // namespace knap
