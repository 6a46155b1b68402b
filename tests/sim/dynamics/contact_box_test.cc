// Boxes in contact against closed forms and invariants: a block on an incline, one at rest, momentum, refinement of a
// mesh, no adhesion, smoothness across edges and creases, and what must never pass through what.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>

#include "sim/math/so3.h"
#include "tests/sim/dynamics/pair_scene.h"

namespace knap {
namespace contact_box_test {

using Eigen::Quaterniond;
using Eigen::Vector3d;
using Eigen::VectorXd;
using test::MakeBox;
using test::PairScene;

constexpr double kGravity = 9.81;

Quaterniond MakeRandomTurn(std::mt19937_64* generator) {
  std::normal_distribution<double> normal;
  return Quaterniond(normal(*generator), normal(*generator), normal(*generator), normal(*generator)).normalized();
}

// The body's place and speed at each whole step.
struct Path {
  std::vector<Vector3d> p;
  std::vector<Vector3d> v;
  SimulationCertificate certificate;
};

Path RunScene(const PairScene& scene, int body, const SimulationOptions& options) {
  Dynamics dynamics(scene.tree);
  ContactModel contacts(scene.contacts);
  Path path;
  const Trajectory t = Simulator(&dynamics, &contacts).Run(scene.q0(), scene.v0(), options);
  path.certificate = t.certificate;
  for (int n = 0; n <= t.whole_steps(); ++n) {
    const int k = t.state_of_step(n);
    dynamics.CalcKinematics(t.q(k), t.v(k), t.vdot(k), t.time(k));
    const BodyKinematics& kin = dynamics.kinematics()[body];
    path.p.push_back(kin.X_WB.p);
    path.v.push_back(kin.X_WB.R * kin.V.tail<3>());
  }
  return path;
}

SimulationOptions MakeStepOptions(double step, double duration) {
  SimulationOptions options;
  options.step = step;
  options.steps = static_cast<int>(std::lround(duration / step));
  options.newton_tolerance = 1e-10;
  return options;
}

// A half-space, or a bar of as many cells.
ContactGeometry MakeFloor(double length, double width, double height, int cells_along, int cells_up) {
  if (cells_along == 0) return HalfSpaceGeometry{};
  return test::MakeMesh(test::MakeBar(length, width, height, cells_along, cells_up));
}

// A cube of water's density on the half-space or a mesh; gravity tilted by `angle`, so that x is downhill.
struct Incline {
  double size;
  bool on_mesh;
  PairScene scene;
  int cube;

  Incline(double size_in, bool on_mesh_in, double angle, double friction) : size(size_in), on_mesh(on_mesh_in) {
    scene.tree.gravity = kGravity * Vector3d(std::sin(angle), 0.0, -std::cos(angle));
    const BoxGeometry box = MakeBox(Vector3d::Constant(size));
    const double c = 6.0 * size;
    const int floor = scene.AddFixed(on_mesh ? test::MakeFloorPose(c) : Pose{});
    const double mass = 1000.0 * size * size * size;
    // Where it will rest, so that it does not rock first.
    const double sag = mass * kGravity * std::cos(angle) / (1e8 * size * size);
    cube = scene.AddFreeBox(Vector3d::Constant(size), mass, Vector3d(0.0, 0.0, 0.5 * size - sag));
    scene.Touch(cube, box, floor, MakeFloor(0.2 + 2.0 * size, size, c, on_mesh ? 12 : 0, 6),
                {1e8, 2.0, friction, 0.0, 1e-3, 2e-5});
  }
};

class InclineTest : public testing::TestWithParam<std::pair<double, bool>> {};

TEST_P(InclineTest, SticksBelowTheFrictionAngleAndSlidesAboveWithTheRightAcceleration) {
  const auto [size, on_mesh] = GetParam();
  const double mu = 0.4;
  for (const double share : {0.95, 1.1, 1.4}) {
    const double angle = share * std::atan(mu);
    const Incline incline(size, on_mesh, angle, mu);
    const Path path = RunScene(incline.scene, incline.cube, MakeStepOptions(2e-3, 0.4));
    ASSERT_TRUE(path.certificate.converged);
    const double moved = (path.p.back() - path.p.front()).x();
    if (share < 1.0) {
      // Bristles begin unbent: it starts to move, and what it gains until they are bent, (0.95 − 0.5) mu g z_s, takes
      // 0.05 mu g to stop, 9 z_s in all = 0.18 mm; and friction takes hold below the middle, so that it rocks.
      EXPECT_LT(std::abs(moved), 3e-4) << share;
      EXPECT_LT(std::abs(path.v.back().x()), 1e-4) << share;
      continue;
    }
    const double expected = kGravity * (std::sin(angle) - mu * std::cos(angle));
    // Between 0.2 s and 0.4 s, when it no longer rocks.
    const double actual = (path.v[200] - path.v[100]).x() / 0.2;
    EXPECT_NEAR(actual, expected, 0.01 * kGravity * std::sin(angle)) << share;
  }
}

TEST_P(InclineTest, RestsStill) {
  const auto [size, on_mesh] = GetParam();
  const double mu = 0.4;
  const Incline incline(size, on_mesh, 0.8 * std::atan(mu), mu);
  const Path path = RunScene(incline.scene, incline.cube, MakeStepOptions(5e-3, 10.0));
  ASSERT_TRUE(path.certificate.converged);
  EXPECT_LT((path.p.back() - path.p.front()).norm(), 1e-4);
  // And in the last half nothing moves at all.
  EXPECT_LT((path.p.back() - path.p[path.p.size() / 2]).norm(), 1e-8);
}

INSTANTIATE_TEST_SUITE_P(Sizes, InclineTest,
                         testing::Values(std::pair{0.02, false}, std::pair{0.1, false}, std::pair{0.02, true},
                                         std::pair{0.1, true}));

// The force on a box pressed flat, or edge or corner first, into floors of different triangulation.
TEST(BoxOnMesh, StiffnessDoesNotHangOnTheTriangulation) {
  const BoxGeometry box = MakeBox({0.03, 0.02, 0.016});
  const double c = 0.08;
  for (const Vector3d& turn : {Vector3d(0, 0, 0.3), Vector3d(0.785, 0, 0), Vector3d(0.6, 0.5, 0)}) {
    std::vector<double> forces;
    for (const int cells : {0, 1, 4, 9, 20, 40}) {
      PairScene scene;
      const int floor = scene.AddFixed(cells > 0 ? test::MakeFloorPose(c) : Pose{});
      const Quaterniond q = ExpSo3(turn);
      // The lowest corner goes 20 µm deep.
      const Vector3d up = q.conjugate() * Vector3d::UnitZ();
      const double reach = box.half.dot(up.cwiseAbs());
      const int body = scene.AddFreeBox(2.0 * box.half, 0.01, Vector3d(0.0013, 0.0021, reach - 2e-5), q);
      scene.Touch(body, box, floor, MakeFloor(0.04, 0.02, c, cells, cells), {1e8, 0.0, 0.0, 0.0, 1e-3, 0.0});
      Dynamics dynamics(scene.tree);
      ContactModel contacts(scene.contacts);
      dynamics.CalcKinematics(scene.q0(), scene.v0(), VectorXd::Zero(6), 0.0);
      contacts.AddWrenches(&dynamics);
      forces.push_back(contacts.reports()[0].f_W.z());
    }
    EXPECT_GT(forces[1], 1e-7);
    // An edge has another pressure in the box's own field than in the plane's; cutting faces changes nothing.
    for (std::size_t i = 2; i < forces.size(); ++i) {
      EXPECT_NEAR(forces[i] / forces[1], 1.0, 1e-10) << "mesh " << i << ", turn " << turn.transpose();
    }
  }
}

TEST(MovingPairs, TwoBoxesKeepTheirMomentum) {
  PairScene scene;
  scene.tree.gravity.setZero();
  const Vector3d size(0.03, 0.02, 0.016);
  const BoxGeometry box = MakeBox(size);
  const int a = scene.AddFreeBox(size, 0.02, Vector3d(0, 0, 0), ExpSo3(Vector3d(0.3, 0.2, 0.1)),
                                 Vector3d(0.3, 0.05, 0.4), Vector3d(3, -2, 5));
  const int b = scene.AddFreeBox(size, 0.03, Vector3d(0.004, 0.003, 0.026), ExpSo3(Vector3d(-0.2, 0.5, 1.0)),
                                 Vector3d(-0.1, 0.1, -0.3), Vector3d(-5, 1, 2));
  scene.Touch(a, box, b, box, {1e8, 0.0, 0.3, 0.0, 1e-3, 2e-5});
  Dynamics dynamics(scene.tree);
  ContactModel contacts(scene.contacts);
  SimulationOptions options = MakeStepOptions(2e-5, 0.03);
  options.newton_tolerance = 1e-12;
  const Trajectory t = Simulator(&dynamics, &contacts).Run(scene.q0(), scene.v0(), options);
  ASSERT_TRUE(t.certificate.converged);
  EXPECT_GE(t.certificate.contact_onsets, 1);
  const auto momenta = [&](int k) {
    dynamics.CalcKinematics(t.q(k), t.v(k), t.vdot(k), t.time(k));
    Vector6d sum = Vector6d::Zero();
    for (const int body : {a, b}) {
      const BodyKinematics& kin = dynamics.kinematics()[body];
      const Vector3d p = scene.tree.bodies()[body].M(5, 5) * (kin.X_WB.R * kin.V.tail<3>());
      const Vector3d L =
          kin.X_WB.R * (scene.tree.bodies()[body].M.topLeftCorner<3, 3>() * kin.V.head<3>()) + kin.X_WB.p.cross(p);
      sum.head<3>() += L;
      sum.tail<3>() += p;
    }
    return sum;
  };
  const Vector6d before = momenta(0);
  const Vector6d after = momenta(t.size() - 1);
  EXPECT_LT((after - before).tail<3>().norm(), 1e-9 * 0.02 * 0.5);
  // The integrator turns free bodies to second order only; contact itself exchanges no angular momentum with nothing.
  EXPECT_LT((after - before).head<3>().norm(), 2e-3 * before.head<3>().norm());
}

// Without friction, which may well drag a steep face down, a floor pushes up, whatever the pose and the speed.
TEST(BoxOnMesh, NeverPulls) {
  std::mt19937_64 generator(5);
  std::uniform_real_distribution<double> u(-1.0, 1.0);
  const BoxGeometry box = MakeBox({0.03, 0.02, 0.016});
  const MeshGeometry mesh = test::MakeMesh(test::MakeBar(0.03, 0.02, 0.04, 12, 8));
  int active = 0;
  for (int trial = 0; trial < 400; ++trial) {
    PairScene scene;
    const int floor = scene.AddFixed(test::MakeFloorPose(0.04));
    const Quaterniond q = MakeRandomTurn(&generator);
    const Vector3d up = q.conjugate() * Vector3d::UnitZ();
    const double reach = box.half.dot(up.cwiseAbs());
    const Vector3d p(0.01 * u(generator), 0.008 * u(generator), reach - 4e-4 * (1 + u(generator)));
    const Vector3d direction(u(generator), u(generator), u(generator));
    const Vector3d velocity = std::pow(10.0, 2.0 * u(generator)) * direction;
    const Vector3d w(10 * u(generator), 10 * u(generator), 10 * u(generator));
    const int body = scene.AddFreeBox(2.0 * box.half, 0.01, p, q, velocity, w);
    scene.Touch(body, box, floor, mesh, {1e8, 5.0, 0.0, 0.0, 1e-3, 2e-5});
    Dynamics dynamics(scene.tree);
    ContactModel contacts(scene.contacts);
    dynamics.CalcKinematics(scene.q0(), scene.v0(), VectorXd::Zero(6), 0.0);
    contacts.BeginStep(1e-3, {});
    contacts.AddWrenches(&dynamics);
    const Vector3d f = contacts.reports()[0].f_W;
    active += f.norm() > 0.0;
    EXPECT_GE(f.z(), -1e-12 * f.norm()) << trial;
  }
  EXPECT_GT(active, 200);
}

// As contact_smoothness_test.cc does for spheres: second differences along scans over creases and edges stay bounded.
TEST(BoxOnMesh, ForceIsSmoothAcrossEdgesAndCreases) {
  TriangleMesh bent = test::MakeBar(0.024, 0.012, 0.02, 12, 5);
  for (Vector3d& v : bent.vertices) {
    const double x = std::abs(v.x());
    v.y() += 0.36 * std::min(x, 0.008) - 0.36 * std::max(0.0, x - 0.016);
  }
  const BoxGeometry box = MakeBox({0.012, 0.008, 0.008});
  const MeshGeometry mesh = test::MakeMesh(bent);
  struct Scan {
    Vector3d from, to, turn;
  };
  const Scan scans[] = {{{-0.004, 0.0083, 0.0103}, {0.0037, 0.0083, 0.0091}, {0.2, 0.1, 0.4}},
                        {{0.004, 0.0088, 0.0103}, {0.02, 0.0091, 0.0111}, {0.1, 0.0, 0.7}},
                        {{0.021, 0.006, 0.0103}, {0.031, 0.002, 0.0111}, {0.6, 0.5, 0.2}},
                        {{0.0123, 0.0072, 0.0093}, {0.0121, 0.0062, 0.0091}, {0.3, 0.2, 0.1}}};
  for (const Scan& scan : scans) {
    double coarse = 0.0;
    double force = 0.0;
    for (const int n : {16000, 64000, 128000}) {
      PairScene scene;
      const int wall = scene.AddFixed();
      const int body = scene.AddFreeBox(2.0 * box.half, 0.01, scan.from, ExpSo3(scan.turn), Vector3d(0.03, -0.01, 0.02),
                                        Vector3d(2, -1, 3));
      scene.Touch(body, box, wall, mesh, {1e8, 2.0, 0.4, 0.0, 1e-2, 0.0});
      Dynamics dynamics(scene.tree);
      ContactModel contacts(scene.contacts);
      VectorXd q = scene.q0();
      const double step = (scan.to - scan.from).norm() / n;
      const auto at = [&](int i) {
        q.head<3>() = scan.from + (scan.to - scan.from) * i / n;
        dynamics.CalcKinematics(q, scene.v0(), VectorXd::Zero(6), 0.0);
        contacts.AddWrenches(&dynamics);
        Vector6d wrench;
        wrench << contacts.reports()[0].f_W, contacts.reports()[0].m_W / 0.01;
        return wrench;
      };
      Vector6d before = at(0);
      Vector6d here = at(1);
      double worst = 0.0;
      for (int i = 2; i <= n; ++i) {
        const Vector6d next = at(i);
        worst = std::max(worst, (next - 2.0 * here + before).norm() / (step * step));
        force = std::max(force, here.norm());
        before = here;
        here = next;
      }
      if (n == 16000) coarse = worst;
      // Curvature peaks over kOnsetDepth, which all scans resolve; a jump of the slope would give ×4, then ×2.
      EXPECT_LT(worst, 2.0 * coarse) << n << " from " << scan.from.transpose();
    }
    EXPECT_GT(force, 0.02);
  }
}

TEST(ContactModel, WhatRanBeforeChangesNoBit) {
  std::mt19937_64 generator(9);
  std::uniform_real_distribution<double> u(-1.0, 1.0);
  const BoxGeometry box = MakeBox({0.012, 0.008, 0.008});
  const MeshGeometry mesh = test::MakeMesh(test::MakeBar(0.024, 0.012, 0.02, 12, 5));
  PairScene scene;
  const int wall = scene.AddFixed();
  const int body = scene.AddFreeBox(2.0 * box.half, 0.01, Vector3d::Zero());
  scene.Touch(body, box, wall, mesh, {1e8, 2.0, 0.4, 0.0, 1e-2, 0.0});
  Dynamics dynamics(scene.tree);
  ContactModel used(scene.contacts);
  VectorXd q = scene.q0();
  int active = 0;
  for (int i = 0; i < 500; ++i) {
    // A walk of small steps with a jump now and then.
    const double size = i % 20 == 0 ? 1.0 : 0.1;
    q.head<3>() += size * 0.004 * Vector3d(u(generator), u(generator), u(generator));
    if (i % 20 == 0) q.head<3>() = Vector3d(0.01 * u(generator), 0.005 + 0.002 * u(generator), 0.01);
    q.tail<4>() += size * 0.3 * Eigen::Vector4d(u(generator), u(generator), u(generator), u(generator));
    q.tail<4>().normalize();
    ContactModel fresh(scene.contacts);
    Vector3d forces[2];
    int k = 0;
    for (ContactModel* model : {&used, &fresh}) {
      dynamics.CalcKinematics(q, scene.v0(), VectorXd::Zero(6), 0.0);
      model->AddWrenches(&dynamics);
      forces[k++] = model->reports()[0].f_W;
    }
    EXPECT_EQ(forces[0], forces[1]) << i;
    active += forces[0].norm() > 0.0;
  }
  EXPECT_GT(active, 100);
}

TEST(BoxOnMesh, DroppedInAnyPoseNeverPassesThrough) {
  std::mt19937_64 generator(13);
  std::uniform_real_distribution<double> u(-1.0, 1.0);
  // A rope link onto a plate 12 mm thick, at up to 2.4 m/s.
  const Vector3d size(0.029, 0.008, 0.008);
  const BoxGeometry box = MakeBox(size);
  const MeshGeometry mesh = test::MakeMesh(test::MakeBar(0.06, 0.012, 0.12, 12, 12));
  for (int trial = 0; trial < 60; ++trial) {
    PairScene scene;
    const int floor = scene.AddFixed(test::MakeFloorPose(0.12));
    const double speed = 1.2 * (1.0 + u(generator));
    const int body =
        scene.AddFreeBox(size, 0.0015, Vector3d(0.01 * u(generator), 0.01 * u(generator), 0.017),
                         MakeRandomTurn(&generator), Vector3d(0.2 * u(generator), 0.2 * u(generator), -speed),
                         Vector3d(10 * u(generator), 10 * u(generator), 10 * u(generator)));
    scene.Touch(body, box, floor, mesh, {3e8, 1.0, 0.3, 0.0, 1e-3, 2e-5});
    const Path path = RunScene(scene, body, MakeStepOptions(2e-3, 0.2));
    EXPECT_TRUE(path.certificate.converged) << trial;
    double lowest = 1.0;
    for (const Vector3d& p : path.p) {
      if (std::abs(p.x()) < 0.05 && std::abs(p.y()) < 0.05) lowest = std::min(lowest, p.z());
    }
    // Its centre stays above the plate by nearly half its least width.
    EXPECT_GT(lowest, 0.002) << trial << " at " << speed;
  }
}

}  // namespace contact_box_test
}  // namespace knap
