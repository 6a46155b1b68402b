#include "tests/sim/dynamics/random_world.h"

#include <rapidcheck.h>

#include <cmath>
#include <optional>
#include <utility>

#include "sim/math/so3.h"
#include "tests/sim/dynamics/slope_comparison.h"

namespace knap::test {

using Eigen::Matrix3d;
using Eigen::Matrix3Xd;
using Eigen::Vector3d;
using Eigen::VectorXd;

ContactModel World::MakeContacts() const {
  std::vector<ContactPair> pairs = contacts;
  for (const ContactMeshOf& of : meshes) {
    pairs[of.contact].shapes[of.side] = MeshGeometry{std::make_shared<ContactMesh>(of.mesh)};
  }
  return ContactModel(std::move(pairs), grips);
}

namespace {

double Weigh(const Trajectory& t, int k) { return k == t.size() - 1 ? 1.0 : 0.4; }

std::optional<ClosedLoop> MakePolicy(const World& world) {
  return world.make_policy ? std::optional(world.make_policy(world.weights)) : std::nullopt;
}

Trajectory Run(const World& world, const SimulationOptions& options, Dynamics* dynamics, ContactModel* contacts,
               std::optional<ClosedLoop>* policy) {
  Feedback* feedback = policy->has_value() ? &**policy : nullptr;
  Trajectory t = Simulator(dynamics, contacts).Run(world.q0, world.v0, options, world.controls, feedback);
  RC_PRE(t.certificate.converged && t.certificate.subdivided_steps == 0);
  return t;
}

}  // namespace

double WorldLoss::Evaluate(const World& world) const {
  const Tree tree = world.MakeTree();
  Dynamics dynamics(tree);
  ContactModel contacts = world.MakeContacts();
  std::optional<ClosedLoop> policy = MakePolicy(world);
  const Trajectory t = Run(world, options, &dynamics, &contacts, &policy);
  double sum = policy ? 0.5 * policy->commands().squaredNorm() : 0.0;
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

TrajectoryGradient WorldLoss::Sweep(const World& world, VectorXd* bar_weights) const {
  const Tree tree = world.MakeTree();
  Dynamics dynamics(tree);
  ContactModel contacts = world.MakeContacts();
  std::optional<ClosedLoop> policy = MakePolicy(world);
  const Trajectory t = Run(world, options, &dynamics, &contacts, &policy);
  std::vector<StateCotangent> cotangents;
  for (const int k : {t.size() / 2, t.size() - 1}) {
    dynamics.CalcKinematics(t.q(k), t.v(k), t.vdot(k), t.time(k));
    const double w = Weigh(t, k);
    for (int i = 0; i < tree.size(); ++i) {
      const Pose& X = dynamics.kinematics()[i].X_WB;
      cotangents.push_back({k, i, w * (a[i] + X.p), w * b[i], w * X.R.col(0).cross(c[i]), w * d[i]});
    }
  }
  if (!policy) return SweepAdjoint(t, cotangents, &dynamics, &contacts, nullptr, TimeNodes::kFrozen);
  policy->BeginSweep(policy->commands());
  TrajectoryGradient gradient = SweepAdjoint(t, cotangents, &dynamics, &contacts, &*policy, TimeNodes::kFrozen);
  *bar_weights = policy->bar_weights();
  return gradient;
}

std::vector<WorldDirection> MakeDirections(RandomTree* random, const World& world, const TrajectoryGradient& g) {
  std::vector<WorldDirection> out;
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
  const Tree tree = world.MakeTree();
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
  for (std::size_t i = 0; i < world.grips.size(); ++i) {
    const Vector3d by_holder = random->Vec().normalized();
    add("point that holds", g.grips[i].p_SA.dot(by_holder),
        [i, by_holder](World* w, double s) { w->grips[i].p_SA += s * by_holder; });
    const Vector3d by_held = random->Vec().normalized();
    add("point that is held", g.grips[i].p_BP.dot(by_held),
        [i, by_held](World* w, double s) { w->grips[i].p_BP += s * by_held; });
  }
  for (std::size_t m = 0; m < world.meshes.size(); ++m) {
    const Matrix3Xd& bar = g.vertices[world.meshes[m].contact][world.meshes[m].side];
    const Matrix3Xd dm = Matrix3Xd::NullaryExpr(3, bar.cols(), [&] { return random->U(); }).normalized();
    add("mesh vertices", bar.cwiseProduct(dm).sum(), [m, dm](World* w, double s) {
      for (Eigen::Index i = 0; i < dm.cols(); ++i)
        w->meshes[m].mesh.vertices[static_cast<std::size_t>(i)] += s * dm.col(i);
    });
  }
  return out;
}

WorldCase MakeWorldCase(RandomTree* random) {
  WorldCase out;
  out.world = {random->tree.bodies(),
               random->tree.actuators(),
               random->tree.gravity,
               random->q,
               random->Values(random->tree.nv(), 1.0),
               {},
               {},
               {},
               {},
               {},
               {}};
  out.world.controls.steps_per_interval = 3;
  out.world.controls.values.resize(random->tree.num_controls(), 3);
  for (int i = 0; i < 3; ++i) out.world.controls.values.col(i) = random->Values(random->tree.num_controls(), 0.9);
  for (int i = 0; i < random->tree.size(); ++i) {
    for (auto* list : {&out.loss.a, &out.loss.b, &out.loss.c, &out.loss.d}) list->push_back(random->Vec());
  }
  out.loss.options.step = 0.02;
  out.loss.options.steps = 11;  // two past the end of the declared intervals
  const int scheme = random->Pick(3);
  out.loss.options.order = 1 + scheme % 2;
  if (scheme == 2) {
    // TR-BDF2 on a given grid: most whole steps in one, every third in two unequal ones.
    out.loss.options.tolerance = 1.0;
    auto nodes = std::make_shared<TimeNodeList>();
    nodes->ends.resize(out.loss.options.steps);
    for (int n = 0; n < out.loss.options.steps; ++n) {
      const auto at = [&](double share) { nodes->ends[n].push_back({.time = (n + share) * out.loss.options.step}); };
      const bool jumps = n == 0 || (n % 3 == 0 && n <= 6);  // the intervals of three steps end with the third
      if (jumps) at(kRestartShare);
      if (n % 3 == 1) at(0.4);
      at(1.0);
    }
    out.loss.options.nodes = nodes;
  }
  out.loss.options.newton_tolerance = 1e-15;  // on to the rounding floor
  return out;
}

void CompareSlopes(const WorldCase& at, const std::vector<WorldDirection>& directions, double tolerance,
                   std::map<std::string, int>* compared) {
  SlopeComparison slopes;
  for (const WorldDirection& d : directions) {
    slopes.Add(d.kind, d.slope, [&at, move = d.move](double s) { return at.loss.Evaluate(move(at.world, s)); });
  }
  const std::string complaint = slopes.Compare(tolerance, compared);
  if (!complaint.empty()) RC_FAIL(complaint);
}

void CompareEveryKind(RandomTree* random, const WorldCase& at, double tolerance, std::map<std::string, int>* compared) {
  const TrajectoryGradient g = at.loss.Sweep(at.world);
  RC_ASSERT(g.finite && g.solvable);
  CompareSlopes(at, MakeDirections(random, at.world, g), tolerance, compared);
}

std::string CheckTaylorRemainderOfEveryKind(RandomTree* random, const WorldCase& at) {
  const TrajectoryGradient g = at.loss.Sweep(at.world);
  const std::vector<WorldDirection> directions = MakeDirections(random, at.world, g);
  double slope = 0.0;
  for (const WorldDirection& d : directions) slope += d.slope;
  return CheckTaylorRemainder(slope, [&](double s) {
    World world = at.world;
    for (const WorldDirection& d : directions) world = d.move(world, s);
    return at.loss.Evaluate(world);
  });
}

}  // namespace knap::test
