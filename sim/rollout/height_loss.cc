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

// Of a cotangent of the centre of mass at state k, which the kinematics are of.
void AddCenterCotangent(const std::vector<int>& links, const Dynamics& dynamics, int k, const Vector3d& bar,
                        std::vector<StateCotangent>* out) {
  const double mass = CalcMass(links, dynamics.tree());
  for (const int i : links) {
    const TreeBody& body = dynamics.tree().bodies()[i];
    StateCotangent at;
    at.state = k;
    at.body = i;
    at.p_W = body.M(3, 3) / mass * bar;
    at.r_W = (dynamics.kinematics()[i].X_WB.R * GetCenter(body)).cross(at.p_W);
    out->push_back(at);
  }
}

int CountSteps(double duration, double step) { return static_cast<int>(std::llround(duration / step)); }

// States at a loss's sample times.
std::vector<int> ListSamples(const HeightLoss& loss, double step, const Trajectory& trajectory) {
  const int stride = CountSteps(loss.sample_period, step);
  const int last = std::min(trajectory.whole_steps(), CountSteps(loss.until, step));
  std::vector<int> states;
  for (int n = CountSteps(loss.from, step) + stride; n <= last; n += stride) {
    states.push_back(trajectory.state_of_step(n));
  }
  return states;
}

// Of a sum over so many samples.
double CalcScale(const HeightLoss& loss, std::size_t samples) {
  const double scale = loss.weight / (loss.length_unit * loss.length_unit);
  return loss.normalize == Normalization::kMean ? scale / static_cast<double>(samples) : scale;
}

}  // namespace

std::vector<double> TraceHeight(const HeightLoss& loss, double step, const SceneModel& model,
                                const Trajectory& trajectory, Dynamics* dynamics) {
  const Vector3d up = -model.tree.gravity.normalized();
  const std::vector<int>& links = model.links.at(loss.rope);
  std::vector<double> heights;
  for (const int k : ListSamples(loss, step, trajectory)) {
    SetState(trajectory, k, dynamics);
    heights.push_back(up.dot(CalcCenterOfMass(links, *dynamics)));
  }
  return heights;
}

double EvaluateHeightMatch(const HeightLoss& loss, double step, const SceneModel& model, const Trajectory& trajectory,
                           const std::vector<double>& reference, Dynamics* dynamics, std::vector<StateCotangent>* out) {
  const std::vector<int> samples = ListSamples(loss, step, trajectory);
  KNAP_CHECK(samples.size() == reference.size(), "{} heights against {}", samples.size(), reference.size());
  if (samples.empty()) return 0.0;
  const Vector3d up = -model.tree.gravity.normalized();
  const std::vector<int>& links = model.links.at(loss.rope);
  const double scale = CalcScale(loss, samples.size());
  double sum = 0.0;
  for (std::size_t n = 0; n < samples.size(); ++n) {
    SetState(trajectory, samples[n], dynamics);
    const double d = up.dot(CalcCenterOfMass(links, *dynamics)) - reference[n];
    sum += d * d;
    if (out != nullptr) AddCenterCotangent(links, *dynamics, samples[n], 2.0 * scale * d * up, out);
  }
  return scale * sum;
}

double EvaluateHeightHold(const HeightHoldLoss& loss, double step, const SceneModel& model,
                          const Trajectory& trajectory, Dynamics* dynamics, std::vector<StateCotangent>* out) {
  const std::vector<int> samples = ListSamples(loss.height, step, trajectory);
  if (samples.empty()) return 0.0;
  const Vector3d up = -model.tree.gravity.normalized();
  const std::vector<int>& links = model.links.at(loss.height.rope);
  const double scale = CalcScale(loss.height, samples.size());
  const int body = loss.carried_by == kWorldName ? -1 : model.body_index.at(loss.carried_by);
  const auto get_pose = [&] { return body < 0 ? Pose{} : dynamics->kinematics()[body].X_WB; };
  const auto add_body = [&](int k, const Vector3d& p_W, const Vector3d& r_W) {
    if (body >= 0) out->push_back({k, body, p_W, Vector3d::Zero(), r_W, Vector3d::Zero()});
  };

  const int from = trajectory.state_of_step(CountSteps(loss.height.from, step));
  SetState(trajectory, from, dynamics);
  const Pose X_from = get_pose();
  const Vector3d p_from = CalcCenterOfMass(links, *dynamics);
  const Vector3d carried = X_from.ApplyInverse(p_from);  // in B
  Vector3d bar_carried = Vector3d::Zero();
  double sum = 0.0;
  for (const int k : samples) {
    SetState(trajectory, k, dynamics);
    const Pose X = get_pose();
    const double d = up.dot(CalcCenterOfMass(links, *dynamics) - X * carried);
    sum += d * d;
    if (out == nullptr) continue;
    const Vector3d bar = 2.0 * scale * d * up;
    AddCenterCotangent(links, *dynamics, k, bar, out);
    add_body(k, -bar, bar.cross(X.R * carried));
    bar_carried -= X.R.transpose() * bar;
  }
  if (out == nullptr) return scale * sum;
  SetState(trajectory, from, dynamics);
  const Vector3d bar_from = X_from.R * bar_carried;
  AddCenterCotangent(links, *dynamics, from, bar_from, out);
  add_body(from, -bar_from, bar_from.cross(p_from - X_from.p));
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
