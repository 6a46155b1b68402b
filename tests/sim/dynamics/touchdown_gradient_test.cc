// The derivative of an impact's outcome against that of the problem: what bounces off a wall that stands elsewhere ends
// elsewhere by (1 + e) of that, e the restitution, whatever the phase of the touchdown within its step.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "sim/contact/convex_field.h"
#include "sim/gradient/adjoint.h"
#include "sim/gradient/node_windows.h"
#include "sim/integrators/touchdown.h"
#include "tests/sim/dynamics/pair_scene.h"
#include "tests/sim/dynamics/scenes.h"

namespace knap {
namespace touchdown_gradient_test {

using Eigen::Vector3d;
using Eigen::VectorXd;
using test::BallScene;

constexpr double kRadius = 7e-3;

SimulationOptions ChosenSteps(double duration) {
  SimulationOptions options = test::MakeOptions(4e-3, duration, 2);
  options.tolerance = 1e-3;
  options.newton_tolerance = 1e-13;
  return options;
}

// A ball thrown at a wall that faces +y, which it meets after `flight` seconds.
struct Bounce {
  double restitution = 0.0;
  double by_wall = 0.0;   // dy(end)/d(the wall's place)
  double by_start = 0.0;  // dy(end)/dy(start): −e
  int touchdowns = 0;
};

Bounce BounceOff(double speed, double flight, double damping, TimeNodes nodes) {
  BallScene scene;
  scene.tree.gravity.setZero();
  scene.radius = kRadius;
  scene.mass = 1.44e-3;
  scene.AddTool([](double) { return PrescribedState{}; });
  scene.AddBall();
  scene.Touch(scene.tool, {3e7, damping, 0.4, 0.0, 1e-3},
              std::make_shared<ContactMesh>(test::MakeBar(0.03, 0.012, 0.03, 1, 1)));
  scene.Start(Vector3d(0.001, kRadius + speed * flight, 0.012), Vector3d(0.0, -speed, 0.0), Vector3d::Zero());
  Dynamics dynamics(scene.tree);
  ContactModel contacts(scene.contacts);
  const Trajectory t = Simulator(&dynamics, &contacts).Run(scene.q0, scene.v0, ChosenSteps(0.4));
  EXPECT_TRUE(t.certificate.converged);
  const int last = t.size() - 1;
  Bounce out;
  out.restitution = t.v(last)(1) / speed;
  const TrajectoryGradient g =
      SweepAdjoint(t, {{last, scene.ball, Vector3d::UnitY(), Vector3d::Zero()}}, &dynamics, &contacts, nullptr, nodes);
  EXPECT_TRUE(g.finite && g.solvable);
  out.by_wall = g.vertices[0][1].row(1).sum();
  out.by_start = g.pose0(1);
  out.touchdowns = g.touchdowns;
  return out;
}

class TouchdownTest : public testing::TestWithParam<double> {};

TEST_P(TouchdownTest, FollowingNodesGiveTheProblemsDerivative) {
  const double speed = GetParam();
  double worst = 0.0;
  double worst_frozen = 0.0;
  for (const double damping : {0.0, 0.2 / speed}) {
    for (int i = 0; i < 20; ++i) {
      const double flight = 0.1 + 0.00021 * i;
      const Bounce bounce = BounceOff(speed, flight, damping, TimeNodes::kFollowing);
      EXPECT_EQ(bounce.touchdowns, 1);
      EXPECT_GT(bounce.restitution, 0.3);
      const double exact = 1.0 + bounce.restitution;
      worst = std::max(worst, std::abs(bounce.by_wall / exact - 1.0));
      // All displaced: the end too.
      EXPECT_NEAR(bounce.by_wall + bounce.by_start, 1.0, 1e-6);
      const Bounce frozen = BounceOff(speed, flight, damping, TimeNodes::kFrozen);
      worst_frozen = std::max(worst_frozen, std::abs(frozen.by_wall / exact - 1.0));
    }
  }
  RecordProperty("worst following", std::to_string(worst));
  RecordProperty("worst frozen", std::to_string(worst_frozen));
  EXPECT_LT(worst, 0.02);
  EXPECT_GT(worst_frozen, worst);
}

INSTANTIATE_TEST_SUITE_P(Speeds, TouchdownTest, testing::Values(0.06, 0.5, 2.0));

// Two equal balls, head on, undamped: they swap velocities, so x2 at the end hangs on the first one's start alone.
TEST(Touchdown, EqualBallsSwapTheirDerivatives) {
  constexpr double kT = 0.5;
  for (int i = 0; i < 20; ++i) {
    Tree tree;
    tree.gravity.setZero();
    for (int b = 0; b < 2; ++b) {
      TreeBody body;
      body.joint = JointType::kTranslation;
      body.M = MakeSpatialInertia(1.0, Vector3d::Zero(), 0.4 * 0.01 * Eigen::Matrix3d::Identity());
      tree.AddBody(body);
    }
    ContactPair pair;
    pair.bodies = {0, 1};
    pair.shapes = {SphereGeometry{0.1}, SphereGeometry{0.1}};
    pair.material.stiffness = 1e9;
    Dynamics dynamics(tree);
    ContactModel contacts({pair});
    VectorXd q0 = VectorXd::Zero(6);
    q0(3) = 0.2 + 0.1 + 0.0007 * i;
    VectorXd v0 = VectorXd::Zero(6);
    v0(0) = 1.0;
    SimulationOptions options = ChosenSteps(kT);
    options.step = 1e-3;
    options.steps = 500;
    const Trajectory t = Simulator(&dynamics, &contacts).Run(q0, v0, options);
    ASSERT_TRUE(t.certificate.converged);
    const int last = t.size() - 1;
    EXPECT_NEAR(t.v(last)(3), 1.0, 1e-3);
    const TrajectoryGradient g =
        SweepAdjoint(t, {{last, 1, Vector3d::UnitX(), Vector3d::Zero()}}, &dynamics, &contacts);
    EXPECT_NEAR(g.pose0(0), 1.0, 0.02);
    EXPECT_NEAR(g.pose0(3), 0.0, 0.02);
    EXPECT_NEAR(g.v0(0), kT, 0.02 * kT);
    EXPECT_NEAR(g.v0(3), 0.0, 0.02 * kT);
  }
}

// A ball that is thrown onto a floor and against a wall that moves, both with friction: touchdowns one after the other,
// and a prescribed motion, whose time counts.
struct Throw {
  BallScene scene;
  SimulationOptions options;

  Throw() {
    scene.AddGround({});
    scene.AddTool([](double t) {
      PrescribedState s;
      s.X_FB.p = Vector3d(0.0, 0.004 * std::sin(20.0 * t), 0.0);
      s.V(4) = 0.08 * std::cos(20.0 * t);
      s.A(4) = -1.6 * std::sin(20.0 * t);
      s.jerk(4) = -32.0 * std::cos(20.0 * t);
      return s;
    });
    scene.AddBall();
    const ContactMaterial material{1e8, 0.3, 0.4, 0.03, 1e-2};
    scene.Touch(scene.ground, material);
    scene.Touch(scene.tool, material, std::make_shared<ContactMesh>(test::MakeBar(0.2, 0.012, 0.1, 1, 1)));
    options = test::MakeOptions(4e-3, 0.24, 2);
    options.tolerance = 1e-3;
    options.newton_tolerance = 1e-14;
  }

  Trajectory Run(const VectorXd& x, const TimeNodeList* nodes) const {
    SimulationOptions o = options;
    if (nodes != nullptr) o.nodes = std::make_shared<TimeNodeList>(*nodes);
    BallScene at = scene;
    at.Start(Vector3d(0.01, 0.03, 0.03) + x.head<3>(), Vector3d(0.1, -0.25, -0.3) + x.tail<3>(), Vector3d(2, -3, 1));
    Dynamics dynamics(at.tree);
    ContactModel contacts(at.contacts);
    Trajectory t = Simulator(&dynamics, &contacts).Run(at.q0, at.v0, o);
    EXPECT_TRUE(t.certificate.converged);
    return t;
  }

  // The step from state `from` to state `to`, in which a contact begins.
  struct Window {
    int from = 0;
    int contact = 0;
    double tau = 0.0;
  };
  double FindTau(const Trajectory& t, int state, int contact, bool* found) const {
    Dynamics dynamics(scene.tree);
    dynamics.CalcKinematics(t.q(state), t.v(state), t.vdot(state), t.time(state));
    const std::optional<Touchdown> touchdown = FindTouchdown(scene.contacts[contact], dynamics.kinematics());
    *found = touchdown.has_value();
    return touchdown ? t.time(state) + touchdown->in : 0.0;
  }
  std::vector<Window> ListWindows(const Trajectory& t) const {
    Dynamics dynamics(scene.tree);
    ContactModel contacts(scene.contacts);
    std::vector<Window> windows;
    std::vector<bool> before(2, true);
    int node = 0;
    for (int k = 0; k < t.size(); ++k) {
      dynamics.CalcKinematics(t.q(k), t.v(k), t.vdot(k), t.time(k));
      contacts.BeginStep(0.0, {});
      contacts.AddWrenches(&dynamics);
      for (int c = 0; c < 2; ++c) {
        const bool active = contacts.reports()[c].active;
        Window window{node, c, 0.0};
        bool found = false;
        if (active && !before[c]) window.tau = FindTau(t, node, c, &found);
        if (found) windows.push_back(window);
        // What touched within the step no longer begins at its end.
        if (!t.formula(k).is_stage || active) before[c] = active;
      }
      if (!t.formula(k).is_stage) node = k;
    }
    return windows;
  }

  // The last state's y and z, with nodes that follow the touchdowns of `base`.
  double RunMoved(const VectorXd& x, const Trajectory& base, const std::vector<Window>& windows) const {
    std::vector<double> shift(base.size(), 0.0);  // of every state that may move
    const auto make_nodes = [&] {
      TimeNodeList nodes;
      nodes.ends.resize(base.whole_steps());
      for (int n = 0; n < base.whole_steps(); ++n) {
        for (int k = base.state_of_step(n) + 1; k <= base.state_of_step(n + 1); ++k) {
          if (!base.formula(k).is_stage) nodes.ends[n].push_back({.time = base.time(k) + shift[k]});
        }
      }
      return nodes;
    };
    for (const Window& window : windows) {
      const TimeNodeList nodes = make_nodes();
      const Trajectory probe = Run(x, &nodes);
      bool found = false;
      const double by = FindTau(probe, window.from, window.contact, &found) - window.tau;
      EXPECT_TRUE(found);
      for (int k = window.from; k + 1 < base.size(); ++k) {
        const bool between = k > 0 && base.formula(k - 1).is_stage && base.formula(k + 1).is_stage;
        if (between) shift[k] = by;
      }
    }
    const TimeNodeList nodes = make_nodes();
    return Weigh(Run(x, &nodes));
  }
  static double Weigh(const Trajectory& t) {
    const int last = t.size() - 1;
    return t.q(last)(0) - 0.7 * t.q(last)(1) + 0.4 * t.q(last)(2) + 0.05 * t.v(last)(1);
  }
};

TEST(Touchdown, FollowingNodesEqualDifferencesOverNodesThatMove) {
  const Throw at;
  const VectorXd zero = VectorXd::Zero(6);
  const Trajectory base = at.Run(zero, nullptr);
  const std::vector<Throw::Window> windows = at.ListWindows(base);
  ASSERT_GE(windows.size(), 3u);
  Dynamics dynamics(at.scene.tree);
  ContactModel contacts(at.scene.contacts);
  const int last = base.size() - 1;
  const std::vector<StateCotangent> loss = {{last, at.scene.ball, Vector3d(1.0, -0.7, 0.4), Vector3d(0.0, 0.05, 0.0)}};
  const TrajectoryGradient g = SweepAdjoint(base, loss, &dynamics, &contacts);
  const TrajectoryGradient frozen = SweepAdjoint(base, loss, &dynamics, &contacts, nullptr, TimeNodes::kFrozen);
  EXPECT_EQ(g.touchdowns, static_cast<int>(windows.size()));
  VectorXd predicted(6);
  predicted << g.pose0.head<3>(), g.v0.head<3>();
  VectorXd at_rest(6);
  at_rest << frozen.pose0.head<3>(), frozen.v0.head<3>();
  EXPECT_GT((predicted - at_rest).norm(), 1e-2 * predicted.norm());  // following changes something
  const TimeNodeList nodes = base.ListNodes();
  const TimeNodeList following = ListFollowingNodes(base, loss, &dynamics, &contacts);
  EXPECT_DOUBLE_EQ(Throw::Weigh(at.Run(zero, &following)), Throw::Weigh(base));
  double moved_by = 0.0;
  for (int i = 0; i < 6; ++i) {
    const double s = 1e-7;
    const VectorXd d = VectorXd::Unit(6, i) * s;
    // Found here by as many runs as there are touchdowns, and by the simulator on its way.
    const double by_simulator = Throw::Weigh(at.Run(10.0 * d, &following));
    EXPECT_NEAR(by_simulator, at.RunMoved(10.0 * d, base, windows), 1e-11) << i;
    moved_by = std::max(moved_by, std::abs(by_simulator - Throw::Weigh(at.Run(10.0 * d, &nodes))));
    const double moved = (at.RunMoved(d, base, windows) - at.RunMoved(-d, base, windows)) / (2.0 * s);
    EXPECT_NEAR(predicted(i), moved, 2e-5 * predicted.norm()) << i;
    const double still = (Throw::Weigh(at.Run(d, &nodes)) - Throw::Weigh(at.Run(-d, &nodes))) / (2.0 * s);
    EXPECT_NEAR(at_rest(i), still, 2e-5 * at_rest.norm()) << i;
  }
  EXPECT_GT(moved_by, 1e-8);
}

// The vertices of a mesh that no design shapes have no cotangents, and the contact has no place for any.
TEST(Touchdown, OnAMeshThatIsNotDesignedHasNoVertices) {
  const TriangleMesh bar = test::MakeBar(0.03, 0.02, 0.04, 1, 1);
  const auto find = [&](const MeshGeometry& mesh) {
    test::PairScene scene;
    const int floor = scene.AddFixed(test::MakeFloorPose(0.04));
    const int ball = scene.AddFree(0.001, Vector3d::Constant(1e-8), Vector3d(0.001, 0.002, 0.01),
                                   Eigen::Quaterniond::Identity(), Vector3d(0.0, 0.0, -0.5), Vector3d::Zero());
    scene.Touch(ball, SphereGeometry{0.007, Vector3d::Zero()}, floor, mesh, {});
    Dynamics dynamics(scene.tree);
    dynamics.CalcKinematics(scene.q0(), scene.v0(), VectorXd::Zero(6), 0.0);
    return FindTouchdown(scene.contacts[0], dynamics.kinematics());
  };
  const std::optional<Touchdown> designed = find(test::MakeMesh(bar));
  const std::optional<Touchdown> fixed = find(*MakeConvexMesh(bar));
  ASSERT_TRUE(designed && fixed);
  EXPECT_NEAR(designed->in, 0.006, 1e-9);
  EXPECT_EQ(fixed->in, designed->in);
  EXPECT_EQ(designed->vertices.size(), 3u);
  EXPECT_TRUE(fixed->vertices.empty());
}

}  // namespace touchdown_gradient_test
}  // namespace knap
