// The adjoint against central differences for every kind of contact, in contact and out of it, on both sides of onset,
// with both laws of friction: initial states, and vertices of meshes on fixed and on moving bodies.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>
#include <string>

#include "sim/contact/convex_field.h"
#include "sim/gradient/adjoint.h"
#include "sim/math/so3.h"
#include "tests/sim/contact/convex_meshes.h"
#include "tests/sim/contact/designed_meshes.h"
#include "tests/sim/dynamics/pair_scene.h"
#include "tests/sim/dynamics/slope_comparison.h"

namespace knap {
namespace contact_gradient_test {

using Eigen::Quaterniond;
using Eigen::Vector3d;
using Eigen::VectorXd;
using test::MakeBox;
using test::MakeDesigned;
using test::PairScene;
using test::SlopeComparison;

const ContactMaterial kBristle{2e7, 1.0, 0.4, 0.02, 1e-3, 2e-5};
const ContactMaterial kSlip{2e7, 1.0, 0.4, 0.02, 1e-2, 0.0};

TriangleMesh MakeBentBar() {
  TriangleMesh mesh = test::MakeBar(0.03, 0.02, 0.04, 10, 7);
  for (Vector3d& v : mesh.vertices) v.y() += 0.0015 * std::cos(150.0 * v.x());
  return mesh;
}

// A scene whose first contact is the one under test; `build` makes it from a mesh, which most leave alone.
struct Case {
  std::string name;
  std::function<PairScene(const TriangleMesh&)> build;
  bool has_mesh = false;
  int steps = 40;
};

void PrintTo(const Case& c, std::ostream* os) { *os << c.name; }

Quaterniond Turn(double x, double y, double z) { return ExpSo3(Vector3d(x, y, z)); }

PairScene OnFloor(const ContactGeometry& shape, const ContactGeometry& floor, const ContactMaterial& material,
                  double height, const Quaterniond& turn, const Pose& X_WF) {
  PairScene s;
  const int ground = s.AddFixed(X_WF);
  const int body = s.AddFree(0.02, Vector3d(2e-6, 3e-6, 2.5e-6), Vector3d(0.001, -0.002, height), turn,
                             Vector3d(0.05, 0.03, -0.1), Vector3d(1.0, -2.0, 0.5));
  s.Touch(body, shape, ground, floor, material);
  return s;
}

PairScene Collide(const ContactGeometry& a, const ContactGeometry& b, double distance,
                  const ContactMaterial& material) {
  PairScene s;
  s.tree.gravity.setZero();
  const int first = s.AddFree(0.02, Vector3d(2e-6, 3e-6, 2.5e-6), Vector3d::Zero(), Turn(0.1, 0.2, -0.1),
                              Vector3d(0.1, 0.02, 0.05), Vector3d(1.0, -2.0, 0.5));
  const int second = s.AddFree(0.03, Vector3d(3e-6, 3e-6, 2e-6), Vector3d(0.001, 0.002, distance), Turn(-0.2, 0.1, 0.3),
                               Vector3d(-0.02, 0.05, -0.1), Vector3d(-1.0, 1.0, 2.0));
  s.Touch(first, a, second, b, material);
  return s;
}

const BoxGeometry kBox = MakeBox({0.03, 0.02, 0.014});
const CapsuleGeometry kCapsule{0.006, 0.012, Vector3d(0.0, 0.0, 0.001)};
const SphereGeometry kSphere{0.008, Vector3d(0.001, 0.0, 0.0)};
const MeshGeometry kHull = *MakeConvexMesh(test::MakePyramid());
// The same and more, askew in their bodies.
const Pose kAskew{ExpSo3(Vector3d(0.5, -0.3, 0.8)).toRotationMatrix(), Vector3d(0.002, -0.001, 0.001)};
const BoxGeometry kAskewBox{kBox.half, kAskew.p, kAskew.R};
const CapsuleGeometry kAskewCapsule{0.006, 0.012, kAskew.p, kAskew.R.col(0)};
const CylinderGeometry kAskewCylinder{0.007, 0.009, kAskew.p, kAskew.R.col(1)};
const HalfSpaceGeometry kAskewHalfSpace{{kAskew.R.col(2), kAskew.R.col(2).dot(kAskew.p)}};

std::vector<Case> MakeCases() {
  const Pose floor{};
  const Pose mesh_floor = test::MakeFloorPose(0.04);
  const auto mesh_case = [&](const ContactGeometry& shape, double height, Quaterniond turn, ContactMaterial m) {
    return [=](const TriangleMesh& mesh) { return OnFloor(shape, test::MakeMesh(mesh), m, height, turn, mesh_floor); };
  };
  // Under whose askew half-space the floor is z = 0.
  const Pose askew_floor{kAskew.R.transpose(), -(kAskew.R.transpose() * kAskew.p)};
  const auto flat = [](PairScene s) { return [=](const TriangleMesh&) { return s; }; };
  std::vector<Case> cases{
      {"BoxOnHalfSpace", flat(OnFloor(kBox, HalfSpaceGeometry{}, kBristle, 0.009, Turn(0.2, 0.1, 0.3), floor))},
      {"BoxFlatOnHalfSpaceSlip", flat(OnFloor(kBox, HalfSpaceGeometry{}, kSlip, 0.007, Turn(0, 0, 0.3), floor))},
      {"BoxThatNeverTouches", flat(OnFloor(kBox, HalfSpaceGeometry{}, kBristle, 0.1, Turn(0.2, 0.1, 0.3), floor))},
      {"CapsuleOnHalfSpace", flat(OnFloor(kCapsule, HalfSpaceGeometry{}, kBristle, 0.008, Turn(1.4, 0, 0), floor))},
      {"SphereOnHalfSpaceBristle", flat(OnFloor(kSphere, HalfSpaceGeometry{}, kBristle, 0.0085, Turn(0, 0, 0), floor))},
      {"BoxOnMesh", mesh_case(kBox, 0.0105, Turn(0.2, 0.1, 0.3), kBristle), true},
      {"BoxFlatOnMeshSlip", mesh_case(kBox, 0.0088, Turn(0.0, 0.02, 0.3), kSlip), true},
      {"CapsuleOnMesh", mesh_case(kCapsule, 0.009, Turn(1.4, 0, 0), kBristle), true},
      {"SphereOnMeshBristle", mesh_case(kSphere, 0.0098, Turn(0, 0, 0), kBristle), true},
      {"MeshOnHalfSpace",
       [=](const TriangleMesh& mesh) {
         PairScene s = OnFloor(test::MakeMesh(mesh), HalfSpaceGeometry{}, kBristle, 0.004, Turn(1.5, 0.1, 0.0), floor);
         return s;
       },
       true},
      {"MovingMeshAgainstMovingBox",
       [=](const TriangleMesh& mesh) { return Collide(test::MakeMesh(mesh), kBox, 0.0485, kBristle); }, true},
      {"MovingMeshAgainstMovingSphere",
       [=](const TriangleMesh& mesh) { return Collide(test::MakeMesh(mesh), kSphere, 0.048, kBristle); }, true},
      {"TwoBoxes", flat(Collide(kBox, kBox, 0.0165, kBristle))},
      {"TwoBoxesSlip", flat(Collide(kBox, kBox, 0.0165, kSlip))},
      {"TwoSpheres", flat(Collide(kSphere, kSphere, 0.0165, kBristle))},
      {"SphereAndBox", flat(Collide(kSphere, kBox, 0.0165, kBristle))},
      {"SphereAndCapsule", flat(Collide(kSphere, kCapsule, 0.0275, kBristle))},
      {"CapsuleAndBox", flat(Collide(kBox, kCapsule, 0.0265, kBristle))},
      {"AskewBoxOnAskewHalfSpace",
       flat(OnFloor(kAskewBox, kAskewHalfSpace, kBristle, 0.015, Turn(0.2, 0.1, 0.3), askew_floor))},
      {"AskewCapsuleOnAskewHalfSpace",
       flat(OnFloor(kAskewCapsule, kAskewHalfSpace, kBristle, 0.012, Turn(0.3, 0.1, 0), askew_floor))},
      {"AskewCylinderOnAskewHalfSpace",
       flat(OnFloor(kAskewCylinder, kAskewHalfSpace, kBristle, 0.0105, Turn(0.3, 0.1, 0), askew_floor))},
      {"AskewCylinderAndSphere", flat(Collide(kAskewCylinder, kSphere, 0.0145, kBristle))},
      {"CapsuleAndAskewCylinder", flat(Collide(kCapsule, kAskewCylinder, 0.0235, kBristle))},
      {"TwoAskewCylinders", flat(Collide(kAskewCylinder, kAskewCylinder, 0.0145, kBristle))},
      {"TwoMovingMeshes",
       [=](const TriangleMesh& mesh) { return Collide(MakeDesigned(mesh), MakeDesigned(mesh), 0.043, kBristle); },
       true},
      {"AskewBoxOnMesh", mesh_case(kAskewBox, 0.0145, Turn(0.2, 0.1, 0.3), kBristle), true},
      {"AskewCapsuleAndAskewBox", flat(Collide(kAskewBox, kAskewCapsule, 0.019, kBristle))},
      {"AskewCylinderAndAskewBox", flat(Collide(kAskewBox, kAskewCylinder, 0.019, kBristle))},
      {"HullOnHalfSpace", flat(OnFloor(kHull, HalfSpaceGeometry{}, kBristle, 0.006, Turn(0.2, 0.1, 0.3), floor))},
      {"HullOnMesh", mesh_case(kHull, 0.0068, Turn(0.2, 0.1, 0.3), kBristle), true},
      {"MovingMeshAgainstMovingHull",
       [=](const TriangleMesh& mesh) { return Collide(test::MakeMesh(mesh), kHull, 0.0448, kBristle); }, true},
      {"TwoHulls", flat(Collide(kHull, kHull, 0.0135, kBristle))},
      {"SphereAndHull", flat(Collide(kSphere, kHull, 0.0125, kBristle))},
  };
  for (Case& c : cases) {
    if (c.name == "BoxThatNeverTouches") c.steps = 20;
  }
  return cases;
}

struct LinearLoss {
  int body;
  Vector3d a = Vector3d(0.3, -0.8, 0.5);
  Vector3d b = Vector3d(0.02, 0.05, -0.03);
  Vector3d c = Vector3d(0.01, 0.02, 0.015);

  double Evaluate(const Trajectory& t, Dynamics* dynamics) const {
    const int k = t.size() - 1;
    dynamics->CalcKinematics(t.q(k), t.v(k), t.vdot(k), t.time(k));
    const BodyKinematics& kin = dynamics->kinematics()[body];
    return a.dot(kin.X_WB.p) + b.dot(kin.X_WB.R * kin.V.tail<3>()) + c.dot(kin.X_WB.R * kin.V.head<3>()) * 0.01;
  }
  std::vector<StateCotangent> Cotangents(const Trajectory& t) const {
    StateCotangent at;
    at.state = t.size() - 1;
    at.body = body;
    at.p_W = a;
    at.v_W = b;
    at.w_W = 0.01 * c;
    return {at};
  }
};

class ContactGradientTest : public testing::TestWithParam<Case> {};

TEST_P(ContactGradientTest, EqualsDifferences) {
  const Case& test = GetParam();
  const TriangleMesh mesh = MakeBentBar();
  SimulationOptions options;
  options.step = 1e-3;
  options.steps = test.steps;
  options.newton_tolerance = 1e-12;
  options.newton_max_iterations = 60;
  const PairScene scene = test.build(mesh);
  const Tree& tree = scene.tree;
  const LinearLoss loss{scene.contacts[0].bodies[0]};
  const auto run = [&](const PairScene& s, const VectorXd& dq, const VectorXd& dv, TrajectoryGradient* gradient) {
    Dynamics dynamics(s.tree);
    ContactModel contacts(s.contacts);
    VectorXd q(s.q0().size());
    tree.AddIncrement(s.q0(), dq, &q);
    const Trajectory t = Simulator(&dynamics, &contacts).Run(q, s.v0() + dv, options);
    EXPECT_TRUE(t.certificate.converged);
    EXPECT_EQ(t.certificate.subdivided_steps, 0);
    if (gradient != nullptr) {
      *gradient = SweepAdjoint(t, loss.Cotangents(t), &dynamics, &contacts);
      EXPECT_EQ(t.certificate.contact_onsets > 0 || contacts.reports()[0].active, test.name != "BoxThatNeverTouches");
    }
    return loss.Evaluate(t, &dynamics);
  };
  const VectorXd zero = VectorXd::Zero(tree.nv());
  TrajectoryGradient gradient;
  run(scene, zero, zero, &gradient);
  ASSERT_TRUE(gradient.finite && gradient.solvable);
  // Depths are some 1e-5 m, where forces bend over kOnsetDepth: steps of 3e-8 and 3e-8 · 100/s, and around.
  SlopeComparison poses, rates;
  for (int k = 0; k < tree.nv(); ++k) {
    const VectorXd d = VectorXd::Unit(tree.nv(), k);
    const std::string number = std::to_string(k);
    poses.Add(
        "pose " + number, gradient.pose0(k),
        [&run, &scene, &zero, d](double s) { return run(scene, s * d, zero, nullptr); }, 0.03);
    rates.Add(
        "rate " + number, gradient.v0(k),
        [&run, &scene, &zero, d](double s) { return run(scene, zero, s * d, nullptr); }, 3.0);
  }
  EXPECT_EQ(poses.Compare(1e-5, nullptr), "");
  EXPECT_EQ(rates.Compare(1e-5, nullptr), "");
  if (!test.has_mesh) return;
  // Where both are the mesh it moves both.
  Eigen::Matrix3Xd bar = Eigen::Matrix3Xd::Zero(3, static_cast<Eigen::Index>(mesh.vertices.size()));
  for (const Eigen::Matrix3Xd& of_shape : gradient.vertices[0]) {
    if (of_shape.cols() > 0) bar += of_shape;
  }
  const double largest = bar.cwiseAbs().maxCoeff();
  EXPECT_GT(largest, 1e-6);
  std::mt19937_64 generator(3);
  std::normal_distribution<double> normal;
  SlopeComparison vertices;
  for (int trial = 0; trial < 6; ++trial) {
    Eigen::Matrix3Xd direction = Eigen::Matrix3Xd::NullaryExpr(3, bar.cols(), [&] { return normal(generator); });
    if (trial >= 3) {
      // One vertex that counts.
      Eigen::Index row = 0;
      Eigen::Index col = 0;
      (bar.cwiseAbs().array() * direction.cwiseAbs().array()).maxCoeff(&row, &col);
      direction.setZero();
      direction(row, col) = 1.0;
      direction((row + trial) % 3, col) = 1.0;
    }
    const auto moved = [&, direction](double h) {
      TriangleMesh shape = mesh;
      for (int i = 0; i < bar.cols(); ++i) shape.vertices[i] += h * direction.col(i);
      PairScene s = scene;
      for (ContactGeometry& g : s.contacts[0].shapes) {
        const auto* designed = std::get_if<MeshGeometry>(&g);
        if (designed == nullptr || !designed->IsDesigned()) continue;
        g = designed->pieces ? MakeDesigned(shape, designed->pieces->faces) : test::MakeMesh(shape);
      }
      return run(s, zero, zero, nullptr);
    };
    vertices.Add("vertices, trial " + std::to_string(trial), bar.cwiseProduct(direction).sum(), moved, 0.03);
  }
  EXPECT_EQ(vertices.Compare(1e-5, nullptr), "");
}

INSTANTIATE_TEST_SUITE_P(Pairs, ContactGradientTest, testing::ValuesIn(MakeCases()),
                         [](const auto& test) { return test.param.name; });

}  // namespace contact_gradient_test
}  // namespace knap
