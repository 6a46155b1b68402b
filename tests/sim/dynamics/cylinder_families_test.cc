// Cylinders against closed forms: a coin that stands, is dropped flat and slides, a roller on an incline, a can that
// tips over its rim.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "tests/sim/dynamics/pair_scene.h"

namespace knap {
namespace cylinder_families_test {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;
using test::kGravity;
using test::MakeBox;
using test::MakeMesh;
using test::PairScene;

constexpr double kPi = std::numbers::pi;

enum class Ground { kHalfSpace, kBox, kMesh, kCylinder };

TriangleMesh MakePlate() {
  TriangleMesh mesh;
  for (const double z : {-0.02, 0.0}) {
    for (const double y : {-0.05, 0.05}) {
      for (const double x : {-0.05, 0.05}) mesh.vertices.push_back({x, y, z});
    }
  }
  mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return mesh;
}

ContactGeometry MakeGround(Ground stand) {
  switch (stand) {
    case Ground::kHalfSpace:
      return HalfSpaceGeometry{};
    case Ground::kBox:
      return BoxGeometry{{0.05, 0.05, 0.01}, {0.0, 0.0, -0.01}};
    case Ground::kMesh:
      return MakeMesh(MakePlate());
    case Ground::kCylinder:
      return CylinderGeometry{0.05, 0.01, {0.0, 0.0, -0.01}};
  }
  return HalfSpaceGeometry{};
}

// A cylinder along its own z on a fixed stand whose top is z = 0.
struct CylinderOnStand {
  PairScene scene;
  int cylinder = 0;

  CylinderOnStand(Ground stand, const CylinderGeometry& shape, double mass, const ContactMaterial& material,
                  const Vector3d& p, const Matrix3d& R, const Vector3d& velocity = Vector3d::Zero(),
                  const Vector3d& w = Vector3d::Zero()) {
    scene.tree.gravity = Vector3d(0.0, 0.0, -kGravity);
    const double r2 = shape.radius * shape.radius;
    const double across = mass * (shape.half_length * shape.half_length / 3.0 + r2 / 4.0);
    const int base = scene.AddFixed();
    cylinder = scene.AddFree(mass, {across, across, 0.5 * mass * r2}, p, Quaterniond(R), velocity, w);
    scene.Touch(cylinder, shape, base, MakeGround(stand), material);
  }

  std::vector<BodyKinematics> Simulate(double step, double duration) {
    Dynamics dynamics(scene.tree);
    ContactModel contacts(scene.contacts);
    Simulator simulator(&dynamics, &contacts);
    std::vector<BodyKinematics> path;
    simulator.observer = [&](double) { path.push_back(dynamics.kinematics()[cylinder]); };
    SimulationOptions options;
    options.step = step;
    options.steps = static_cast<int>(std::lround(duration / step));
    EXPECT_TRUE(simulator.Run(scene.q0(), scene.v0(), options).certificate.converged);
    return path;
  }
};

const CylinderGeometry kCoin{0.012, 0.0015};
constexpr double kCoinMass = 0.0077;

class CylinderTest : public testing::TestWithParam<Ground> {};

TEST_P(CylinderTest, ACoinSagsByItsPressure) {
  for (const double stiffness : {1e8, 1e9}) {
    const ContactMaterial material{stiffness, 20.0, 0.5, 0.0, 1e-3, 1e-4};
    CylinderOnStand on(GetParam(), kCoin, kCoinMass, material, {0.003, 0.002, kCoin.half_length}, Matrix3d::Identity());
    const Pose end = on.Simulate(1e-3, 0.3).back().X_WB;
    const double sag = kCoinMass * kGravity / (stiffness * kPi * kCoin.radius * kCoin.radius);
    EXPECT_NEAR(kCoin.half_length - end.p.z(), sag, 0.02 * sag);
    EXPECT_LE((end.p.head<2>() - Eigen::Vector2d(0.003, 0.002)).norm(), 1e-9);
    EXPECT_LE((end.R - Matrix3d::Identity()).norm(), 1e-7) << "it stays level";
  }
}

TEST_P(CylinderTest, DroppedFlatItIsNotKickedSideways) {
  const ContactMaterial material{1e8, 10.0, 0.0, 0.0, 1e-3, 0.0};
  CylinderOnStand on(GetParam(), kCoin, kCoinMass, material, {0.003, 0.002, kCoin.half_length + 0.005},
                     Matrix3d::Identity());
  for (const BodyKinematics& k : on.Simulate(2.5e-4, 0.3)) {
    ASSERT_LE((k.X_WB.p.head<2>() - Eigen::Vector2d(0.003, 0.002)).norm(), 1e-6);
    ASSERT_GE(k.X_WB.p.z(), kCoin.half_length - 2e-4);
  }
}

// A sliding coin is braked by its friction alone.
TEST_P(CylinderTest, ACoinSlidesToAStop) {
  const double mu = 0.3;
  const double speed = 0.25;
  const ContactMaterial material{1e9, 20.0, mu, 0.0, 1e-3, 1e-5};
  const double sag = kCoinMass * kGravity / (1e9 * kPi * kCoin.radius * kCoin.radius);
  CylinderOnStand on(GetParam(), kCoin, kCoinMass, material, {-0.015, 0.0, kCoin.half_length - sag},
                     Matrix3d::Identity(), {speed, 0.0, 0.0});
  const std::vector<BodyKinematics> path = on.Simulate(5e-4, 0.3);
  const double way = speed * speed / (2.0 * mu * kGravity);
  EXPECT_NEAR(path.back().X_WB.p.x() + 0.015, way, 0.02 * way);
  EXPECT_LE(path.back().V.norm(), 1e-4);
}

// How deep a cylinder lies in the plane that bears the force with E times the volume below it: by halving.
double FindDepth(const CylinderGeometry& c, double force, double stiffness) {
  double low = 0.0;
  double high = c.radius;
  for (int i = 0; i < 100; ++i) {
    const double depth = 0.5 * (low + high);
    const double cosine = 1.0 - depth / c.radius;
    const double segment = c.radius * c.radius * (std::acos(cosine) - cosine * std::sqrt(1.0 - cosine * cosine));
    (stiffness * 2.0 * c.half_length * segment < force ? low : high) = depth;
  }
  return low;
}

// A lying cylinder that does not slip goes down an incline with 2/3 g sin, without bumps on its way.
TEST_P(CylinderTest, ARollerRollsWithTwoThirds) {
  const CylinderGeometry roller{0.008, 0.01};
  const double mass = 0.02;
  const double tilt = 6.0 * kPi / 180.0;
  const ContactMaterial material{1e9, 2.0, 0.5, 0.0, 1e-3, 1e-6};
  const Matrix3d lying = Eigen::AngleAxisd(0.5 * kPi, Vector3d::UnitX()).toRotationMatrix();
  const double depth = FindDepth(roller, mass * kGravity * std::cos(tilt), 1e9);
  CylinderOnStand on(GetParam(), roller, mass, material, {-0.03, 0.0, roller.radius - depth}, lying);
  on.scene.tree.gravity = kGravity * Vector3d(std::sin(tilt), 0.0, -std::cos(tilt));
  const double duration = 0.3;
  const std::vector<BodyKinematics> path = on.Simulate(5e-4, duration);
  const double way = 0.5 * (2.0 / 3.0) * kGravity * std::sin(tilt) * duration * duration;
  EXPECT_NEAR(path.back().X_WB.p.x() + 0.03, way, 0.01 * way);
  EXPECT_LE(std::abs(path.back().X_WB.p.y()), 1e-6) << "it keeps its line";
  double highest = 0.0;
  double lowest = 1.0;
  for (std::size_t k = path.size() / 2; k < path.size(); ++k) {
    highest = std::max(highest, path[k].X_WB.p.z());
    lowest = std::min(lowest, path[k].X_WB.p.z());
  }
  // On a cylinder it is a prism, pressed in by 15 µm.
  EXPECT_LE(highest - lowest, GetParam() == Ground::kCylinder ? 3e-7 : 1e-7) << "no bumps";
}

// A can whose centre of mass stands just within or beyond the line over its rim falls back or over.
TEST_P(CylinderTest, ACanTipsOverItsRim) {
  const CylinderGeometry can{0.01, 0.02};
  const double edge = std::atan(can.radius / can.half_length);
  const ContactMaterial material{1e9, 20.0, 0.8, 0.0, 1e-3, 1e-6};
  for (const double share : {0.95, 1.05}) {
    const double lean = share * edge;
    const Matrix3d R = Eigen::AngleAxisd(lean, Vector3d::UnitY()).toRotationMatrix();
    // The rim's lowest point touches the plane.
    const double z = can.half_length * std::cos(lean) + can.radius * std::sin(lean);
    CylinderOnStand on(GetParam(), can, 0.05, material, {0.0, 0.0, z}, R);
    const Pose end = on.Simulate(1e-3, 1.0).back().X_WB;
    const double upright = end.R(2, 2);
    if (share < 1.0) {
      EXPECT_GT(upright, 0.999) << "it stands again";
    } else {
      EXPECT_LT(std::abs(upright), 0.01) << "it lies";
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Stands, CylinderTest,
                         testing::Values(Ground::kHalfSpace, Ground::kBox, Ground::kMesh, Ground::kCylinder));

}  // namespace cylinder_families_test
}  // namespace knap
