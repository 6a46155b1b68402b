#include "sim/gradient/loss_error.h"

#include <algorithm>
#include <utility>

#include "sim/math/so3.h"

namespace knap {

using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

// Of the step over which bristles show their rate: so short that they stay where they are [s].
constexpr double kMoment = 1e-7;

// Increments and rates of one ball joint, or of all others, which add up as vectors do.
struct Increment {
  VectorXd total;      // from the step's start to its end
  VectorXd end_slope;  // d(increment)/dt there, for a rate v at the end
};

// log(Exp(a) Exp(b)) and the inverse of the right Jacobian, to second order in the increments: the curve is no closer.
Increment Compose(const Tree& tree, const VectorXd& a, const VectorXd& b, const VectorXd& v) {
  Increment out{a + b, v};
  for (const TreeBody& body : tree.bodies()) {
    if (body.joint != JointType::kBall) continue;
    const Vector3d a_k = a.segment<3>(body.v_start);
    out.total.segment<3>(body.v_start) += 0.5 * a_k.cross(b.segment<3>(body.v_start));
    const Vector3d total = out.total.segment<3>(body.v_start);
    out.end_slope.segment<3>(body.v_start) += 0.5 * total.cross(v.segment<3>(body.v_start));
  }
  return out;
}

// The rate in the moving frame where an increment xi grows by `slope`.
VectorXd CalcRate(const Tree& tree, const VectorXd& xi, const VectorXd& slope) {
  VectorXd v = slope;
  for (const TreeBody& body : tree.bodies()) {
    if (body.joint != JointType::kBall) continue;
    v.segment<3>(body.v_start) =
        RightJacobianSo3(xi.segment<3>(body.v_start)) * Vector3d(slope.segment<3>(body.v_start));
  }
  return v;
}

}  // namespace

LossErrorSum::LossErrorSum(const Trajectory& trajectory, Dynamics* dynamics, ContactModel* contacts)
    : trajectory_(trajectory), dynamics_(dynamics), contacts_(contacts) {}

void LossErrorSum::Look(int k, const StateBars& bars) {
  if (trajectory_.formula(k).is_stage) return;
  now_.state = k;
  now_.bar_pose = bars.pose;
  trajectory_.GetBristles(k, &now_.bristles);
  now_.bar_bristles = bars.bristles.bent;
  now_.bar_bristles.resize(now_.bristles.bent.z.size(), Bristle::Zero());
}

void LossErrorSum::AddSolve(int k, const VectorXd& lambda) {
  const StepFormula& f = trajectory_.formula(k);
  if (f.is_stage) return;
  const bool ends_chosen = trajectory_.formula(k - 1).is_stage;
  const bool starts_chosen = k + 1 < trajectory_.size() && trajectory_.formula(k + 1).is_stage;
  double time = ends_chosen ? StepFormula::kDiagonal * f.step : f.step;
  if (starts_chosen) time += StepFormula::kWeight * trajectory_.formula(k + 1).step;
  now_.mu = lambda / time;
  if (starts_chosen) sum_ += CalcStep(now_, after_);
  std::swap(now_, after_);
}

void LossErrorSum::CalcBristles(const Node& start, const Node& end, double h) {
  middle_.Clear();
  middle_rate_.clear();
  bar_middle_.clear();
  const Bristles& a = start.bristles.bent;
  const Bristles& b = end.bristles.bent;
  int i = 0;
  int j = 0;
  while (i < a.size() || j < b.size()) {
    const bool in_a = i < a.size() && (j == b.size() || a.id[i] <= b.id[j]);
    const bool in_b = j < b.size() && (i == a.size() || b.id[j] <= a.id[i]);
    const Bristle zero = Bristle::Zero();
    const Bristle& z_a = in_a ? a.z[i] : zero;
    const Bristle& z_b = in_b ? b.z[j] : zero;
    const Bristle& rate_a = in_a ? start.bristles.rate[i] : zero;
    const Bristle& rate_b = in_b ? end.bristles.rate[j] : zero;
    middle_.id.push_back(in_a ? a.id[i] : b.id[j]);
    middle_.z.push_back(0.5 * (z_a + z_b) + h / 8.0 * (rate_a - rate_b));
    middle_rate_.push_back(1.5 / h * (z_b - z_a) - 0.25 * (rate_a + rate_b));
    bar_middle_.push_back(0.5 * ((in_a ? start.bar_bristles[i] : zero) + (in_b ? end.bar_bristles[j] : zero)));
    i += in_a ? 1 : 0;
    j += in_b ? 1 : 0;
  }
}

double LossErrorSum::CalcStep(const Node& start, const Node& end) {
  const Tree& tree = dynamics_->tree();
  const int s = start.state;
  const int e = end.state;
  const double h = trajectory_.formula(e).step;
  const VectorXd v_s = trajectory_.v(s);
  const VectorXd v_e = trajectory_.v(e);
  const VectorXd a_s = trajectory_.vdot(s);
  const VectorXd a_e = trajectory_.vdot(e);
  const Increment step = Compose(tree, trajectory_.xi(s + 1), trajectory_.xi(e), v_e);
  const VectorXd xi = 0.5 * step.total + h / 8.0 * (v_s - step.end_slope);
  const VectorXd slope = 1.5 / h * step.total - 0.25 * (v_s + step.end_slope);
  const VectorXd v = 0.5 * (v_s + v_e) + h / 8.0 * (a_s - a_e);
  const VectorXd vdot = 1.5 / h * (v_e - v_s) - 0.25 * (a_s + a_e);
  VectorXd q = trajectory_.q(s);
  tree.AddIncrement(q, xi, &q);
  dynamics_->CalcKinematics(q, v, vdot, trajectory_.time(s) + 0.5 * h);
  CalcBristles(start, end, h);
  contacts_->BeginStep(kMoment, middle_);
  contacts_->AddWrenches(dynamics_);
  VectorXd r(tree.nv());
  VectorXd magnitude(tree.nv());
  dynamics_->CalcResidual(0.0, &r, &magnitude);
  double worth = 0.5 * (start.bar_pose + end.bar_pose).dot(v - CalcRate(tree, xi, slope));
  worth -= 0.5 * (start.mu + end.mu).dot(r);
  const Bristles& moved = contacts_->bristles();
  int j = 0;
  for (int i = 0; i < middle_.size(); ++i) {
    while (j < moved.size() && moved.id[j] < middle_.id[i]) ++j;
    if (j == moved.size() || moved.id[j] != middle_.id[i]) continue;
    worth += bar_middle_[i].dot((moved.z[j] - middle_.z[i]) / kMoment - middle_rate_[i]);
  }
  return 2.0 * h / 3.0 * worth;
}

}  // namespace knap
