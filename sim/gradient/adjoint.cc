#include "sim/gradient/adjoint.h"

#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "sim/gradient/following_nodes.h"
#include "sim/gradient/loss_error.h"
#include "sim/math/check.h"

namespace knap {

using Eigen::VectorXd;

namespace {

// What the loss sees of the parameters, less what the steps' equations do.
void SubtractSteps(const ParameterCotangents& loss, const ParameterCotangents& steps, TrajectoryGradient* out) {
  out->gravity = loss.gravity - steps.gravity;
  out->finite = out->finite && out->gravity.allFinite() && out->controls.allFinite();
  out->bodies = loss.bodies;
  for (std::size_t i = 0; i < out->bodies.size(); ++i) {
    BodyParameterCotangent& b = out->bodies[i];
    const BodyParameterCotangent& s = steps.bodies[i];
    b.placement -= s.placement;
    b.axis -= s.axis;
    b.mass -= s.mass;
    b.first_moment -= s.first_moment;
    b.inertia -= s.inertia;
    b.law.damping -= s.law.damping;
    b.law.stiffness -= s.law.stiffness;
    b.law.rest -= s.law.rest;
    out->finite = out->finite && b.placement.allFinite() && b.inertia.allFinite();
  }
}

}  // namespace

TrajectoryGradient SweepAdjoint(const Trajectory& trajectory, const std::vector<StateCotangent>& cotangents,
                                Dynamics* dynamics, ContactModel* contacts, Feedback* feedback, TimeNodes nodes) {
  KNAP_CHECK(trajectory.certificate.converged, "adjoint of a trajectory that did not converge");
  const Tree& tree = dynamics->tree();
  const int nv = tree.nv();
  TrajectoryGradient out;
  SolvePullBack pull(trajectory, dynamics, contacts);
  StateBars bars(nv);
  std::vector<BodyCotangent> bodies(tree.size());
  const bool chosen_steps = trajectory.size() > 2 && trajectory.formula(2).is_stage;
  std::optional<FollowingNodes> following;
  if (chosen_steps && nodes == TimeNodes::kFollowing) {
    following.emplace(trajectory, cotangents, dynamics, contacts, &pull);
  }
  std::optional<LossErrorSum> error;
  if (chosen_steps) error.emplace(trajectory, dynamics, contacts);
  const ControlSequence& controls = trajectory.controls;
  // The interval that begins next, on the way back: the last one that acted, at first.
  int interval = feedback == nullptr || trajectory.whole_steps() == 0
                     ? -1
                     : (trajectory.whole_steps() - 1) / controls.steps_per_interval;
  std::vector<StateCotangent> by_feedback;
  const auto add = [&](const StateCotangent& at) {
    if (at.body >= 0) AddStateCotangent(at, dynamics->kinematics()[at.body], &bodies[at.body]);
    if (at.contact >= 0) pull.AddForce(at.contact, at.f_W);
    if (at.coordinate < 0) return;
    bars.pose(at.coordinate) += at.pose;
    bars.v(at.coordinate) += at.rate;
  };
  auto next = cotangents.rbegin();
  constexpr double kEps = std::numeric_limits<double>::epsilon();
  double rounding_squared = 0.0;

  for (int k = trajectory.size() - 1; k >= 0; --k) {
    pull.LoadState(k);
    double by_time = 0.0;
    by_feedback.clear();
    if (interval >= 0 && trajectory.state_of_step(interval * controls.steps_per_interval) == k) {
      feedback->PullBack({interval, k, trajectory.time(k), pull.q(), pull.v(), dynamics->kinematics()},
                         pull.controls().col(interval), &by_feedback);
      --interval;
    }
    const bool is_watched = next != cotangents.rend() && next->state == k;
    if (is_watched || !by_feedback.empty()) {
      for (BodyCotangent& b : bodies) b = BodyCotangent{};
      for (; next != cotangents.rend() && next->state == k; ++next) {
        add(*next);
        by_time += next->time.value_or(0.0);
      }
      for (const StateCotangent& at : by_feedback) add(at);
      by_time += pull.AddBodies(&bodies, &bars);
    }
    rounding_squared += (kEps * kEps) * bars.pose.squaredNorm();
    if (k == 0) {
      pull.PullBackStart(&bars);
      break;
    }
    if (!pull.LoadSolve()) {
      out.solvable = false;
      break;
    }
    if (following) following->Look(k);
    if (error) error->Look(k, bars);
    const SolvePullBack::Result result = pull.PullBack(&bars);
    rounding_squared += pull.CalcRoundingSquared();
    const VectorXd lambda = pull.lambda();
    const VectorXd by_pose = pull.by_pose();
    if (following && !following->AddSolve(k, result, by_time, &bars)) {
      out.solvable = false;
      break;
    }
    if (error) error->AddSolve(k, lambda, by_pose);
  }
  if (following && out.solvable) {
    contacts->BeginStep(0.0, {});
    contacts->AddWrenches(dynamics);
    following->Look(0);
    following->Finish(&bars);
    out.touchdowns = following->touchdowns();
  }
  out.controls = std::move(pull.controls());
  out.vertices = std::move(pull.by_contact().vertices);
  out.grips = std::move(pull.by_contact().grips);
  out.loss_rounding = std::sqrt(rounding_squared);
  out.loss_error = error ? error->sum() : std::numeric_limits<double>::quiet_NaN();
  out.pose0 = bars.pose;
  out.v0 = bars.v;
  out.finite = out.pose0.allFinite() && out.v0.allFinite();
  SubtractSteps(pull.by_loss(), pull.by_solves(), &out);
  for (const std::array<Eigen::Matrix3Xd, 2>& vertices : out.vertices) {
    out.finite = out.finite && vertices[0].allFinite() && vertices[1].allFinite();
  }
  return out;
}

}  // namespace knap
