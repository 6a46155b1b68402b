// The adjoint against central differences on whole trajectories: free flight, pendulums, contact with a plane and with
// a mesh, before and after onset, by both formulas.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <random>
#include <string>

#include "sim/geometry/triangle_mesh.h"
#include "sim/gradient/adjoint.h"
#include "tests/sim/dynamics/scenes.h"
#include "tests/sim/dynamics/slope_comparison.h"

namespace knap {
namespace rollout_gradient_test {

using Eigen::Vector3d;
using Eigen::VectorXd;
using test::BallScene;
using test::SlopeComparison;

SimulationOptions Options(double step, int steps, int order) {
  SimulationOptions options;
  options.step = step;
  options.steps = steps;
  options.order = order;
  options.newton_tolerance = 1e-12;
  return options;
}

// Loss: a·p of one body and b·v at the last state, plus a·p halfway.
struct LinearLoss {
  int body = 0;
  Vector3d a = Vector3d(0.3, -0.8, 0.5);
  Vector3d b = Vector3d(0.02, 0.05, -0.03);

  double Evaluate(const Trajectory& t, Dynamics* dynamics) const {
    double sum = 0.0;
    for (const int k : {t.size() / 2, t.size() - 1}) {
      dynamics->CalcKinematics(t.q(k), t.v(k), t.vdot(k), t.time(k));
      const BodyKinematics& kin = dynamics->kinematics()[body];
      sum += a.dot(kin.X_WB.p);
      if (k == t.size() - 1) sum += b.dot(kin.X_WB.R * kin.V.tail<3>());
    }
    return sum;
  }
  std::vector<StateCotangent> Cotangents(const Trajectory& t) const {
    return {{t.size() / 2, body, a, Vector3d::Zero()}, {t.size() - 1, body, a, b}};
  }
};

// Checks d(loss)/d(initial pose, initial rates) of a tree.
void CheckInitialState(const Tree& tree, std::vector<ContactPair> contact_list, const VectorXd& q0, const VectorXd& v0,
                       const SimulationOptions& options, const LinearLoss& loss, double tolerance) {
  Dynamics dynamics(tree);
  ContactModel contacts(std::move(contact_list));
  Simulator simulator(&dynamics, &contacts);
  const auto run = [&](const VectorXd& dq, const VectorXd& dv) {
    VectorXd q(q0.size());
    tree.AddIncrement(q0, dq, &q);
    const Trajectory t = simulator.Run(q, v0 + dv, options);
    EXPECT_TRUE(t.certificate.converged);
    return loss.Evaluate(t, &dynamics);
  };
  const Trajectory trajectory = simulator.Run(q0, v0, options);
  ASSERT_TRUE(trajectory.certificate.converged);
  const TrajectoryGradient gradient = SweepAdjoint(trajectory, loss.Cotangents(trajectory), &dynamics, &contacts);
  ASSERT_TRUE(gradient.finite && gradient.solvable);
  const VectorXd zero = VectorXd::Zero(tree.nv());
  // Contact depths are about 1e-5 m: the ladder's first steps are a tenth of that and less.
  SlopeComparison slopes;
  for (int k = 0; k < tree.nv(); ++k) {
    const VectorXd d = VectorXd::Unit(tree.nv(), k);
    const std::string number = std::to_string(k);
    slopes.Add(
        "pose " + number, gradient.pose0(k), [&run, &zero, d](double s) { return run(s * d, zero); }, 0.5);
    slopes.Add(
        "rate " + number, gradient.v0(k), [&run, &zero, d](double s) { return run(zero, s * d); }, 0.5);
  }
  EXPECT_EQ(slopes.Compare(tolerance, nullptr), "");
}

class RolloutGradientOrderTest : public testing::TestWithParam<int> {};

TEST_P(RolloutGradientOrderTest, DoublePendulumWithBallJoint) {
  Tree tree;
  TreeBody upper;
  upper.joint = JointType::kRevolute;
  upper.axis = Vector3d::UnitY();
  upper.law.damping = 1e-3;
  upper.M = MakeSpatialInertia(0.3, Vector3d(0, 0, -0.1), 1e-3 * Eigen::Matrix3d::Identity());
  tree.AddBody(upper);
  TreeBody lower;
  lower.parent = 0;
  lower.joint = JointType::kBall;
  lower.X_PF.p = Vector3d(0, 0, -0.2);
  lower.M = MakeSpatialInertia(0.2, Vector3d(0, 0.02, -0.1), Vector3d(1e-3, 2e-3, 5e-4).asDiagonal());
  tree.AddBody(lower);
  VectorXd q0 = tree.MakeDefaultPositions();
  q0(0) = 0.7;
  VectorXd v0(4);
  v0 << 0.5, 1.0, -2.0, 3.0;
  LinearLoss loss;
  loss.body = 1;
  CheckInitialState(tree, {}, q0, v0, Options(5e-3, 100, GetParam()), loss, 1e-7);
}

TEST_P(RolloutGradientOrderTest, BallThatFallsBouncesAndRolls) {
  BallScene scene;
  scene.AddGround({});
  scene.AddBall();
  const ContactMaterial material{2e8, 1.0, 0.4, 0.03, 1e-3};
  scene.Touch(scene.ground, material);
  scene.Start(Vector3d(0, 0, 0.02), Vector3d(0.2, 0.1, -0.1), Vector3d(3, -5, 10));
  LinearLoss loss;
  loss.body = scene.ball;
  CheckInitialState(scene.tree, scene.contacts, scene.q0, scene.v0, Options(1e-3, 200, GetParam()), loss, 1e-6);
}

TEST_P(RolloutGradientOrderTest, BallAgainstAMovingMeshFollowsItsVertices) {
  BallScene scene;
  scene.AddGround({});
  scene.AddTool([](double t) {
    PrescribedState s;
    s.X_FB.p = Vector3d(0.01 * std::sin(5 * t), 0.1 * t, 0.0);
    s.V.tail<3>() = Vector3d(0.05 * std::cos(5 * t), 0.1, 0.0);
    s.A.tail<3>() = Vector3d(-0.25 * std::sin(5 * t), 0.0, 0.0);
    return s;
  });
  scene.AddBall();
  const ContactMaterial material{2e8, 1.0, 0.4, 0.03, 1e-3};
  // A bar with bent front, so that creases and convex edges are rolled over.
  TriangleMesh mesh = test::MakeBar(0.03, 0.012, 0.02, 12, 5);
  ASSERT_TRUE(FindDefects(mesh).empty()) << FindDefects(mesh).Describe();
  for (Vector3d& v : mesh.vertices) v.y() += 0.003 * std::cos(300.0 * v.x());
  scene.Touch(scene.ground, material);
  scene.Touch(scene.tool, material, std::make_shared<ContactMesh>(mesh));
  scene.Start(Vector3d(0.004, 0.02, 0.00995), Vector3d(-0.03, -0.01, 0), Vector3d::Zero());
  const SimulationOptions options = Options(1e-3, 400, GetParam());
  LinearLoss loss;
  loss.body = scene.ball;
  CheckInitialState(scene.tree, scene.contacts, scene.q0, scene.v0, options, loss, 1e-5);

  Dynamics dynamics(scene.tree);
  const auto evaluate = [&](const TriangleMesh& shape, Eigen::Matrix3Xd* bar) {
    auto list = scene.contacts;
    list[1].shapes[1] = MeshGeometry{std::make_shared<ContactMesh>(shape)};
    ContactModel contacts(list);
    const Trajectory t = Simulator(&dynamics, &contacts).Run(scene.q0, scene.v0, options);
    EXPECT_TRUE(t.certificate.converged);
    EXPECT_GE(t.certificate.contact_onsets, 1);
    if (bar != nullptr) *bar = SweepAdjoint(t, loss.Cotangents(t), &dynamics, &contacts).vertices[1][1];
    return loss.Evaluate(t, &dynamics);
  };
  Eigen::Matrix3Xd bar;
  evaluate(mesh, &bar);
  // Along random smooth deformations and along single vertices.
  std::mt19937_64 generator(7);
  std::normal_distribution<double> normal;
  EXPECT_GT(bar.cwiseAbs().maxCoeff(), 1e-3);
  SlopeComparison slopes;
  for (int trial = 0; trial < 12; ++trial) {
    Eigen::Matrix3Xd direction = Eigen::Matrix3Xd::Zero(3, bar.cols());
    if (trial < 4) {
      direction = Eigen::Matrix3Xd::NullaryExpr(3, bar.cols(), [&] { return normal(generator); });
    } else {
      direction(static_cast<int>(generator() % 3), static_cast<int>(generator() % bar.cols())) = 1.0;
    }
    slopes.Add(
        "trial", bar.cwiseProduct(direction).sum(),
        [&, direction](double s) {
          TriangleMesh shape = mesh;
          for (int i = 0; i < bar.cols(); ++i) shape.vertices[i] += s * direction.col(i);
          return evaluate(shape, nullptr);
        },
        0.01);
  }
  std::map<std::string, int> compared;
  EXPECT_EQ(slopes.Compare(1e-5, &compared), "");
  EXPECT_GE(compared["trial"], 4);
}

INSTANTIATE_TEST_SUITE_P(Bdf, RolloutGradientOrderTest, testing::Values(1, 2));

}  // namespace rollout_gradient_test
}  // namespace knap
