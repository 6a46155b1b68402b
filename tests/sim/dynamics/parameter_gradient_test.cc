// The adjoint's gradient in every kind of parameter against differences, on random trees in free motion: placements,
// axes, inertias, joint laws, gravity, controls, initial state.
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <string>

#include "sim/gradient/adjoint.h"
#include "tests/sim/dynamics/random_tree.h"
#include "tests/sim/dynamics/scenes.h"

namespace knap {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;
using test::RandomTree;

// All that a trajectory without contact depends on.
struct World {
  std::vector<TreeBody> bodies;
  std::vector<Actuator> actuators;
  Vector3d gravity;
  VectorXd q0;
  VectorXd v0;
  ControlSequence controls;
};

// Of each body, halfway and at the end: a linear function of position, velocity, orientation and angular velocity, and
// the square of the position.
struct Loss {
  std::vector<Vector3d> a, b, c, d;
  SimulationOptions options;

  static double Weigh(const Trajectory& t, int k) { return k == t.size() - 1 ? 1.0 : 0.4; }

  double Evaluate(const World& world) const {
    const Tree tree = RandomTree::Rebuild(world.bodies, world.actuators, world.gravity);
    Dynamics dynamics(tree);
    ContactModel none({});
    const Trajectory t = Simulator(&dynamics, &none).Run(world.q0, world.v0, options, world.controls);
    RC_PRE(t.certificate.converged && t.certificate.subdivided_steps == 0);
    double sum = 0.0;
    for (const int k : {t.size() / 2, t.size() - 1}) {
      dynamics.CalcKinematics(t.q(k), t.v(k), t.vdot(k), t.time(k));
      for (int i = 0; i < tree.size(); ++i) {
        const BodyKinematics& kin = dynamics.kinematics()[i];
        const Matrix3d& R = kin.X_WB.R;
        sum += Weigh(t, k) * (a[i].dot(kin.X_WB.p) + 0.5 * kin.X_WB.p.squaredNorm() + b[i].dot(R * kin.V.tail<3>()) +
                              c[i].dot(R.col(0)) + d[i].dot(R * kin.V.head<3>()));
      }
    }
    return sum;
  }

  TrajectoryGradient Sweep(const World& world) const {
    const Tree tree = RandomTree::Rebuild(world.bodies, world.actuators, world.gravity);
    Dynamics dynamics(tree);
    ContactModel none({});
    const Trajectory t = Simulator(&dynamics, &none).Run(world.q0, world.v0, options, world.controls);
    RC_PRE(t.certificate.converged && t.certificate.subdivided_steps == 0);
    std::vector<StateCotangent> cotangents;
    for (const int k : {t.size() / 2, t.size() - 1}) {
      dynamics.CalcKinematics(t.q(k), t.v(k), t.vdot(k), t.time(k));
      const double w = Weigh(t, k);
      for (int i = 0; i < tree.size(); ++i) {
        const Pose& X = dynamics.kinematics()[i].X_WB;
        cotangents.push_back({k, i, w * (a[i] + X.p), w * b[i], w * X.R.col(0).cross(c[i]), w * d[i]});
      }
    }
    return SweepAdjoint(t, cotangents, &dynamics, &none);
  }
};

// One way of changing a world, and the slope that the adjoint predicts for it.
struct Direction {
  std::string kind;
  std::function<World(const World&, double)> move;
  double slope = 0.0;
};

// One direction of unit length for each kind of parameter and each body that has it.
std::vector<Direction> MakeDirections(RandomTree* random, const World& world, const TrajectoryGradient& g) {
  std::vector<Direction> out;
  const auto add = [&](const std::string& kind, double slope, std::function<void(World*, double)> change) {
    out.push_back({kind,
                   [change](const World& from, double s) {
                     World moved = from;
                     change(&moved, s);
                     return moved;
                   },
                   slope});
  };
  const auto nv = static_cast<int>(world.v0.size());
  const Tree tree = RandomTree::Rebuild(world.bodies, world.actuators, world.gravity);
  const VectorXd dq = random->Values(nv, 1.0).normalized();
  add("initial pose", g.pose0.dot(dq), [dq, tree](World* w, double s) {
    const VectorXd q = w->q0;
    tree.AddIncrement(q, s * dq, &w->q0);
  });
  const VectorXd dv = random->Values(nv, 1.0).normalized();
  add("initial rates", g.v0.dot(dv), [dv](World* w, double s) { w->v0 += s * dv; });
  const Vector3d dg = random->Vec().normalized();
  add("gravity", g.gravity.dot(dg), [dg](World* w, double s) { w->gravity += s * dg; });
  for (int a = 0; a < tree.num_controls(); ++a) {
    const bool force = world.actuators[a].kind == ActuatorKind::kForce;
    const auto n = static_cast<int>(world.controls.values.cols());
    const VectorXd du = random->Values(n, 1.0).normalized();
    add(force ? "force control" : "position control", g.controls.row(a).dot(du),
        [a, du](World* w, double s) { w->controls.values.row(a) += s * du.transpose(); });
  }
  for (int i = 0; i < tree.size(); ++i) {
    const TreeBody& body = world.bodies[i];
    const BodyParameterCotangent& bar = g.bodies[i];
    const Vector6d dX = random->Values(6, 1.0).normalized();
    add(tree.IsDynamic(i) ? "placement" : "placement of what does not move freely", bar.placement.dot(dX),
        [i, dX](World* w, double s) {
          Pose& X = w->bodies[i].X_PF;
          X.p += s * X.R * dX.tail<3>();
          X.R = X.R * ExpSo3(s * dX.head<3>()).toRotationMatrix();
        });
    if (CountDof(body.joint) == 0) continue;
    const double dm = 0.5 * random->U();
    const Vector3d dh = 0.5 * random->Vec();
    const Matrix3d dA = 0.5 * Matrix3d::NullaryExpr([&] { return random->U(); });
    const Matrix3d dI = 0.5 * (dA + dA.transpose());
    const auto change_M = [i](const Matrix3d& I, const Vector3d& h, double m) {
      Matrix6d dM;
      dM << I, Skew(h), -Skew(h), m * Matrix3d::Identity();
      return [i, dM](World* w, double s) { w->bodies[i].M += s * dM; };
    };
    add("mass", bar.mass * dm, change_M(Matrix3d::Zero(), Vector3d::Zero(), dm));
    add("first moment", bar.first_moment.dot(dh), change_M(Matrix3d::Zero(), dh, 0.0));
    add("rotational inertia", bar.inertia.cwiseProduct(dI).sum(), change_M(dI, Vector3d::Zero(), 0.0));
    add("damping", bar.law.damping, [i](World* w, double s) { w->bodies[i].law.damping += s; });
    if (body.law.stiffness > 0.0) {
      const bool ball = body.joint == JointType::kBall;
      add(ball ? "ball stiffness" : "stiffness", bar.law.stiffness,
          [i](World* w, double s) { w->bodies[i].law.stiffness += s; });
      Vector3d dr = random->Vec();
      for (int k = CountDof(body.joint); k < 3; ++k) dr(k) = 0.0;
      add(ball ? "rest of a ball" : "rest", bar.law.rest.dot(dr),
          [i, dr](World* w, double s) { w->bodies[i].law.rest += s * dr; });
    }
    if (CountDof(body.joint) == 1) {
      const Vector3d da = body.axis.cross(random->Vec());
      add(body.joint == JointType::kRevolute ? "revolute axis" : "prismatic axis", bar.axis.dot(da),
          [i, da](World* w, double s) { w->bodies[i].axis = (w->bodies[i].axis + s * da).normalized(); });
    }
  }
  return out;
}

struct Case {
  World world;
  Loss loss;
};

Case MakeCase(RandomTree* random) {
  Case out;
  out.world = {random->tree.bodies(), random->tree.actuators(), random->tree.gravity, random->q,
               random->Values(random->tree.nv(), 1.0), {}};
  out.world.controls.steps_per_interval = 3;
  out.world.controls.values.resize(random->tree.num_controls(), 3);
  for (int i = 0; i < 3; ++i) out.world.controls.values.col(i) = random->Values(random->tree.num_controls(), 0.9);
  for (int i = 0; i < random->tree.size(); ++i) {
    for (auto* list : {&out.loss.a, &out.loss.b, &out.loss.c, &out.loss.d}) list->push_back(random->Vec());
  }
  out.loss.options.step = 0.02;
  out.loss.options.steps = 11;  // two past the end of the declared intervals
  out.loss.options.order = 1 + random->Pick(2);
  out.loss.options.newton_tolerance = 1e-15;  // on to the rounding floor
  return out;
}

TEST(ParameterGradient, EqualsDifferencesForEveryKindOfParameter) {
  std::map<std::string, int> compared;
  const auto property = [&] {
    RandomTree random(*rc::gen::arbitrary<std::uint64_t>());
    const Case at = MakeCase(&random);
    const TrajectoryGradient g = at.loss.Sweep(at.world);
    RC_ASSERT(g.finite && g.solvable);
    const std::vector<Direction> directions = MakeDirections(&random, at.world, g);
    double largest = 0.0;
    for (const Direction& d : directions) largest = std::max(largest, std::abs(d.slope));
    for (const Direction& d : directions) {
      const auto loss = [&](double s) { return at.loss.Evaluate(d.move(at.world, s)); };
      double error = std::numeric_limits<double>::infinity();
      // Five-point central differences err by h⁴ times the fifth derivative, and by 1e-14/h of rounding.
      for (const double h : {4e-3, 2e-3, 1e-3, 5e-4}) {
        const double slope = (8.0 * (loss(h) - loss(-h)) - (loss(2.0 * h) - loss(-2.0 * h))) / (12.0 * h);
        error = std::min(error, std::abs(slope - d.slope));
        if (error < 1e-9 * largest) break;
      }
      if (error > 1e-7 * largest) RC_FAIL(d.kind + ": error " + std::to_string(error / largest) + " of the largest");
      // What vanishes in both says nothing.
      if (std::abs(d.slope) > 1e-4 * largest) ++compared[d.kind];
    }
  };
  EXPECT_TRUE(rc::check("gradients equal differences", property));
  for (const char* kind :
       {"initial pose", "initial rates", "gravity", "force control", "position control", "placement",
        "placement of what does not move freely", "mass", "first moment", "rotational inertia", "damping", "stiffness",
        "ball stiffness", "rest", "rest of a ball", "revolute axis", "prismatic axis"}) {
    EXPECT_GE(compared[kind], 5) << kind;
  }
}

TEST(ParameterGradient, TaylorRemainderFallsAsTheSquare) {
  for (int seed = 0; seed < 20; ++seed) {
    RandomTree random(static_cast<std::uint64_t>(1000 + seed));
    Case at = MakeCase(&random);
    // A limit is twice differentiable only: at its ends the remainder is of order 2 without a constant rate.
    for (TreeBody& body : at.world.bodies) body.law.limit = JointLimit{};
    const TrajectoryGradient g = at.loss.Sweep(at.world);
    const std::vector<Direction> directions = MakeDirections(&random, at.world, g);
    double slope = 0.0;
    for (const Direction& d : directions) slope += d.slope;
    const auto move = [&](double s) {
      World world = at.world;
      for (const Direction& d : directions) world = d.move(world, s);
      return at.loss.Evaluate(world);
    };
    const double start = move(0.0);
    double previous = 0.0;
    for (const double h : {1e-3, 5e-4, 2.5e-4, 1.25e-4}) {
      const double remainder = std::abs(move(h) - start - h * slope);
      EXPECT_GT(remainder, 1e-9 * h) << seed;
      if (previous > 0.0) {
        EXPECT_NEAR(std::log2(previous / remainder), 2.0, 0.1) << seed << " " << h;
      }
      previous = remainder;
    }
  }
}

}  // namespace
}  // namespace knap
