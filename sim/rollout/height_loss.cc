#include "sim/rollout/height_loss.h"

#include <algorithm>
#include <cmath>

#include "sim/math/check.h"

namespace knap {

using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

void SetState(const Trajectory& trajectory, int k, Dynamics* dynamics) {
  const VectorXd q = trajectory.q(k);
  const VectorXd v = trajectory.v(k);
  const VectorXd vdot = trajectory.vdot(k);
  dynamics->CalcKinematics(q, v, vdot, trajectory.time(k));
}

// Of a body's centre of mass, from its origin, in B.
Vector3d GetCenter(const TreeBody& body) { return Vector3d(body.M(2, 4), body.M(0, 5), body.M(1, 3)) / body.M(3, 3); }

double CalcMass(const std::vector<int>& links, const Tree& tree) {
  double mass = 0.0;
  for (const int i : links) mass += tree.bodies()[i].M(3, 3);
  return mass;
}

// In W, at the current kinematics.
Vector3d CalcCenterOfMass(const std::vector<int>& links, const Dynamics& dynamics) {
  Vector3d sum = Vector3d::Zero();
  for (const int i : links) {
    const TreeBody& body = dynamics.tree().bodies()[i];
    sum += body.M(3, 3) * (dynamics.kinematics()[i].X_WB * GetCenter(body));
  }
  return sum / CalcMass(links, dynamics.tree());
}

int CountSteps(double duration, double step) { return static_cast<int>(std::llround(duration / step)); }

}  // namespace

std::vector<double> TraceHeight(const HeightLoss& loss, double step, const SceneModel& model,
                                const Trajectory& trajectory, Dynamics* dynamics) {
  const Vector3d up = -model.tree.gravity.normalized();
  const std::vector<int>& links = model.links.at(loss.rope);
  std::vector<double> heights;
  const int last = std::min(trajectory.whole_steps(), CountSteps(loss.until, step));
  for (int n = 0; n <= last; n += CountSteps(loss.sample_period, step)) {
    SetState(trajectory, trajectory.state_of_step(n), dynamics);
    heights.push_back(up.dot(CalcCenterOfMass(links, *dynamics)));
  }
  return heights;
}

double EvaluateHeight(const HeightLoss& loss, double step, const SceneModel& model, const Trajectory& trajectory,
                      const std::vector<double>& heights, const std::vector<double>& reference, Dynamics* dynamics,
                      std::vector<StateCotangent>* out) {
  KNAP_CHECK(reference.size() == 1 || reference.size() == heights.size(), "{} heights against {}", heights.size(),
             reference.size());
  if (heights.size() < 2) return 0.0;
  const Vector3d up = -model.tree.gravity.normalized();
  const std::vector<int>& links = model.links.at(loss.rope);
  const double mass = CalcMass(links, model.tree);
  double scale = loss.weight / (loss.length_unit * loss.length_unit);
  if (loss.normalize == Normalization::kMean) scale /= static_cast<double>(heights.size() - 1);
  double sum = 0.0;
  for (std::size_t n = 1; n < heights.size(); ++n) {
    const double d = heights[n] - (reference.size() == 1 ? reference[0] : reference[n]);
    sum += d * d;
    if (out == nullptr) continue;
    const int k = trajectory.state_of_step(static_cast<int>(n) * CountSteps(loss.sample_period, step));
    SetState(trajectory, k, dynamics);
    for (const int i : links) {
      const TreeBody& body = model.tree.bodies()[i];
      StateCotangent at;
      at.state = k;
      at.body = i;
      at.p_W = 2.0 * scale * d * body.M(3, 3) / mass * up;
      at.r_W = (dynamics->kinematics()[i].X_WB.R * GetCenter(body)).cross(at.p_W);
      out->push_back(at);
    }
  }
  return scale * sum;
}

bool HoldsRopeAtEnd(const HoldsRope& test, const Scene& scene, const SceneModel& model, const Trajectory& trajectory,
                    Dynamics* dynamics) {
  const int end = trajectory.size() - 1;
  SetState(trajectory, end, dynamics);
  const Vector3d body = dynamics->kinematics()[model.body_index.at(test.body)].X_WB.p;
  if (!((CalcCenterOfMass(model.links.at(test.rope), *dynamics) - body).norm() <= test.distance)) return false;
  for (std::size_t pair = 0; pair < model.contacts.size(); ++pair) {
    const auto& [a, b] = scene.contacts[model.contact_of_pair[pair]].bodies;
    if (!((a == test.rope && b == test.body) || (a == test.body && b == test.rope))) continue;
    if (trajectory.last_touched()[pair] >= trajectory.time(end) - test.touched_within) return true;
  }
  return false;
}

}  // namespace knap
