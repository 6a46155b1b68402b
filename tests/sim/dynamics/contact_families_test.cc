// Scenes beside the tuned path, each a family with its closed form: bars that slide without friction, cubes that stand,
// lean and fall, what is dropped flat, stacks, what is thrown at a table.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "tests/sim/dynamics/pair_scene.h"

namespace knap {
namespace contact_families_test {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;
using test::kGravity;
using test::MakeBox;
using test::MakeMesh;
using test::PairScene;

struct Path {
  std::vector<Pose> X_WB;
  std::vector<Vector3d> f_W;  // sums over all contacts, on the first body of each
  bool converged = false;
};

Path Simulate(const PairScene& scene, int body, double step, double duration) {
  Dynamics dynamics(scene.tree);
  ContactModel contacts(scene.contacts);
  Simulator simulator(&dynamics, &contacts);
  Path path;
  simulator.observer = [&](double) {
    path.X_WB.push_back(dynamics.kinematics()[body].X_WB);
    Vector3d f = Vector3d::Zero();
    for (const ContactReport& report : contacts.reports()) f += report.f_W;
    path.f_W.push_back(f);
  };
  SimulationOptions options;
  options.step = step;
  options.steps = static_cast<int>(std::lround(duration / step));
  path.converged = simulator.Run(scene.q0(), scene.v0(), options).certificate.converged;
  return path;
}

// Two rails along y at x = ±20 mm whose highest line is at z = 0.
enum class Rail { kCapsule, kBoxEdge, kMeshRidge };
enum class Bar { kCapsule, kBox };

TriangleMesh MakeRidges() {
  TriangleMesh mesh;
  for (const double x : {-0.02, 0.02}) {
    const int first = static_cast<int>(mesh.vertices.size());
    for (const double y : {-0.03, 0.03}) {
      mesh.vertices.insert(mesh.vertices.end(), {{x - 0.008, y, -0.008}, {x + 0.008, y, -0.008}, {x, y, 0.0}});
    }
    for (const Eigen::Vector3i& t :
         {Eigen::Vector3i(0, 1, 2), Eigen::Vector3i(5, 4, 3), Eigen::Vector3i(0, 3, 4), Eigen::Vector3i(0, 4, 1),
          Eigen::Vector3i(1, 4, 5), Eigen::Vector3i(1, 5, 2), Eigen::Vector3i(2, 5, 3), Eigen::Vector3i(2, 3, 0)}) {
      mesh.triangles.push_back(t + Eigen::Vector3i::Constant(first));
    }
  }
  return mesh;
}

// A frictionless bar 200 mm long and 10 mm thick across the rails, gravity tilted along it.
struct BarOnRails {
  PairScene scene;
  int bar = 0;
  double mass = 0.016;

  // Its centre is `beside` the middle between the rails.
  BarOnRails(Rail rail, Bar kind, double tilt, double beside) {
    scene.tree.gravity = kGravity * Vector3d(std::sin(tilt), 0.0, -std::cos(tilt));
    const Matrix3d along = Eigen::AngleAxisd(0.5 * std::numbers::pi, Vector3d::UnitY()).toRotationMatrix();
    // Stiff: what it sinks in further on one rail than on the other tilts it, and it slides faster or slower.
    const ContactMaterial smooth{1e10, 20.0, 0.0, 0.0, 1e-3, 0.0};
    const ContactGeometry shape = kind == Bar::kCapsule ? ContactGeometry(CapsuleGeometry{0.005, 0.1, Vector3d::Zero()})
                                                        : MakeBox({0.01, 0.01, 0.2});
    const double i = mass * 0.2 * 0.2 / 12.0;
    bar = scene.AddFree(mass, Vector3d(i, i, mass * 2e-5), Vector3d(beside, 0.0, 0.005), Quaterniond(along),
                        Vector3d::Zero(), Vector3d::Zero());
    if (rail == Rail::kMeshRidge) {
      scene.Touch(bar, shape, scene.AddFixed(), MakeMesh(MakeRidges()), smooth);
      return;
    }
    for (const double x : {-0.02, 0.02}) {
      Pose X_WR;
      if (rail == Rail::kCapsule) {
        X_WR.R = Eigen::AngleAxisd(0.5 * std::numbers::pi, Vector3d::UnitX()).toRotationMatrix();
        X_WR.p = Vector3d(x, 0.0, -0.005);
        scene.Touch(bar, shape, scene.AddFixed(X_WR), CapsuleGeometry{0.005, 0.03, Vector3d::Zero()}, smooth);
      } else {
        X_WR.R = Eigen::AngleAxisd(0.25 * std::numbers::pi, Vector3d::UnitY()).toRotationMatrix();
        X_WR.p = Vector3d(x, 0.0, -0.006 * std::numbers::sqrt2);
        scene.Touch(bar, shape, scene.AddFixed(X_WR), MakeBox({0.012, 0.06, 0.012}), smooth);
      }
    }
  }
};

struct RailCase {
  Rail rail;
  Bar bar;
};

class BarOnRailsTest : public testing::TestWithParam<RailCase> {};

TEST_P(BarOnRailsTest, SlidesAsIfNothingHeldIt) {
  for (const double degrees : {1.0, 3.0, 6.0, 10.0, 20.0}) {
    const double tilt = degrees * std::numbers::pi / 180.0;
    const BarOnRails on(GetParam().rail, GetParam().bar, tilt, -0.001);
    const double h = 2e-4;
    // Until its centre is 15 mm on, still between the rails.
    const double duration = std::min(0.15, std::floor(std::sqrt(2.0 * 0.015 / (kGravity * std::sin(tilt))) / h) * h);
    const Path path = Simulate(on.scene, on.bar, h, duration);
    ASSERT_TRUE(path.converged);
    for (std::size_t k = 0; k < path.f_W.size(); ++k) {
      const Vector3d along = path.X_WB[k].R.col(2);
      EXPECT_LE(std::abs(path.f_W[k].dot(along)), 1e-6 * on.mass * kGravity) << degrees << " deg, state " << k;
    }
    const double expected = 0.5 * kGravity * std::sin(tilt) * duration * duration;
    const double moved = path.X_WB.back().p.x() + 0.001;
    EXPECT_NEAR(moved, expected, 0.01 * expected) << degrees << " deg";
  }
}

TEST_P(BarOnRailsTest, StaysWhereItIsLevel) {
  const BarOnRails on(GetParam().rail, GetParam().bar, 0.0, 0.0);
  const Path path = Simulate(on.scene, on.bar, 1e-3, 2.0);
  ASSERT_TRUE(path.converged);
  EXPECT_LE(path.X_WB.back().p.head<2>().norm(), 1e-5);
}

INSTANTIATE_TEST_SUITE_P(Families, BarOnRailsTest,
                         testing::Values(RailCase{Rail::kCapsule, Bar::kCapsule}, RailCase{Rail::kCapsule, Bar::kBox},
                                         RailCase{Rail::kBoxEdge, Bar::kCapsule}, RailCase{Rail::kBoxEdge, Bar::kBox},
                                         RailCase{Rail::kMeshRidge, Bar::kCapsule},
                                         RailCase{Rail::kMeshRidge, Bar::kBox}));

// What a cube of 20 mm and 10 g stands on, its upper face at z = 0.
enum class Stand { kHalfSpace, kBox, kMesh, kFineMesh };

struct CubeOnStand {
  PairScene scene;
  int cube = 0;
  static constexpr double kSide = 0.02;
  static constexpr double kMass = 0.01;

  // The cube's centre of mass is `off` beside its middle.
  CubeOnStand(Stand stand, double stiffness, const Vector3d& start, const Vector3d& off) {
    const double i = kMass * kSide * kSide / 6.0;
    cube = scene.AddFree(kMass, Vector3d::Constant(i), start, Quaterniond::Identity(), Vector3d::Zero(),
                         Vector3d::Zero(), off);
    const ContactMaterial material{stiffness, 10.0, 0.5, 0.0, 1e-3, 1e-5};
    Pose X_WS;
    ContactGeometry shape = HalfSpaceGeometry{};
    if (stand != Stand::kHalfSpace) X_WS.p.z() = -0.5 * kSide;
    if (stand == Stand::kBox) shape = MakeBox(Vector3d::Constant(kSide));
    if (stand == Stand::kMesh || stand == Stand::kFineMesh) {
      const int cells = stand == Stand::kMesh ? 1 : 7;
      X_WS = test::MakeFloorPose(kSide);
      shape = MakeMesh(test::MakeBar(0.5 * kSide, kSide, kSide, cells, cells));
    }
    scene.Touch(cube, MakeBox(Vector3d::Constant(kSide)), scene.AddFixed(X_WS), shape, material);
  }
};

class CubeTest : public testing::TestWithParam<Stand> {};

TEST_P(CubeTest, SagsByItsPressure) {
  for (const double stiffness : {1e8, 1e9}) {
    for (const double beside : {0.0, 1e-6, 1e-3}) {
      const CubeOnStand on(GetParam(), stiffness, Vector3d(beside, 0.5 * beside, 0.01), Vector3d::Zero());
      const Path path = Simulate(on.scene, on.cube, 1e-3, 0.5);
      ASSERT_TRUE(path.converged);
      const double shared =
          GetParam() == Stand::kHalfSpace ? on.kSide * on.kSide : (on.kSide - beside) * (on.kSide - 0.5 * beside);
      const double sag = on.kMass * kGravity / (stiffness * shared);
      const Vector3d moved = path.X_WB.back().p - Vector3d(beside, 0.5 * beside, 0.01);
      // Beside the middle it leans a little as well.
      EXPECT_NEAR(-moved.z(), sag, (beside > 1e-4 ? 0.12 : 0.02) * sag) << stiffness << ", beside " << beside;
      EXPECT_LE(moved.head<2>().norm(), 1e-6);
    }
  }
}

TEST_P(CubeTest, FallsWhenAndOnlyWhenItsCentreOfMassIsOutside) {
  for (const double off : {0.001, 0.009, 0.011, 0.0125}) {
    const CubeOnStand on(GetParam(), 1e9, Vector3d(0.0, 0.0, 0.01), Vector3d(off, 0.0, 0.0));
    const Path path = Simulate(on.scene, on.cube, 1e-3, 0.3);
    ASSERT_TRUE(path.converged);
    const double lean = std::acos(std::clamp(path.X_WB.back().R(2, 2), -1.0, 1.0));
    if (off < 0.01) {
      // Carried by a strip three times as wide as the centre is from the edge: up to 1.1e-3, and it rocks.
      EXPECT_LE(lean, 3e-3) << off;
    } else {
      EXPECT_GE(lean, 0.2) << off;
    }
  }
}

TEST_P(CubeTest, IsNotKickedSidewaysWhenDroppedFlat) {
  const CubeOnStand on(GetParam(), 1e9, Vector3d(0.0, 0.0, 0.015), Vector3d::Zero());
  const Path path = Simulate(on.scene, on.cube, 2e-4, 0.3);
  ASSERT_TRUE(path.converged);
  EXPECT_LE(path.X_WB.back().p.head<2>().norm(), 1e-6);
  EXPECT_GE(path.X_WB.back().R(2, 2), 1.0 - 1e-9);
}

INSTANTIATE_TEST_SUITE_P(Stands, CubeTest,
                         testing::Values(Stand::kHalfSpace, Stand::kBox, Stand::kMesh, Stand::kFineMesh));

TEST(StackTest, FiveCubesStandForTenSeconds) {
  PairScene scene;
  int below = scene.AddFixed();
  std::vector<int> cubes;
  const double side = 0.02;
  for (int k = 0; k < 5; ++k) {
    // Each a little beside the one below.
    const Vector3d p(1e-4 * (k % 2), -5e-5 * k, (k + 0.5) * side);
    const int cube = scene.AddFreeBox(Vector3d::Constant(side), 0.01, p);
    const ContactMaterial material{1e9, 10.0, 0.5, 0.0, 1e-3, 1e-5};
    const ContactGeometry under = k == 0 ? ContactGeometry(HalfSpaceGeometry{}) : MakeBox(Vector3d::Constant(side));
    scene.Touch(cube, MakeBox(Vector3d::Constant(side)), below, under, material);
    below = cube;
    cubes.push_back(cube);
  }
  const Path path = Simulate(scene, cubes.back(), 2e-3, 10.0);
  ASSERT_TRUE(path.converged);
  EXPECT_LE((path.X_WB.back().p - Vector3d(0.0, -2e-4, 4.5 * side)).norm(), 1e-4);
}

// Whatever the step that a user has chosen: nothing falls through a half-space.
TEST(PeaTest, StaysOnTheTableHoweverItIsThrown) {
  for (const double speed : {0.5, 2.0, 5.0, 10.0, 20.0}) {
    for (const double step : {4e-3, 1e-3}) {
      PairScene scene;
      const double r = 0.007;
      const double mass = 0.00144;
      const int pea = scene.AddFree(mass, Vector3d::Constant(0.4 * mass * r * r), Vector3d(0.0, 0.0, 0.008),
                                    Quaterniond::Identity(), Vector3d(0.1, 0.0, -speed), Vector3d::Zero());
      scene.Touch(pea, SphereGeometry{r, Vector3d::Zero()}, scene.AddFixed(), HalfSpaceGeometry{},
                  {3e7, 10.0, 0.4, 0.05, 1e-3, 0.0});
      const Path path = Simulate(scene, pea, step, 0.4);
      ASSERT_TRUE(path.converged) << speed;
      EXPECT_GE(path.X_WB.back().p.z(), 0.0065) << speed << " m/s, step " << step;
    }
  }
}

}  // namespace contact_families_test
}  // namespace knap
