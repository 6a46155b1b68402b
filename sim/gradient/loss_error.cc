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

// The cubic Hermite curve x(s) = x_0 + value (x_1 − x_0) + from_start x'_0 + from_end x'_1 over a step of length h, at
// a share s of it, and its slope in time likewise.
struct Hermite {
  double value, from_start, from_end, slope, slope_from_start, slope_from_end;
  Hermite(double s, double h)
      : value(s * s * (3.0 - 2.0 * s)),
        from_start(h * s * (1.0 - s) * (1.0 - s)),
        from_end(h * s * s * (s - 1.0)),
        slope(6.0 * s * (1.0 - s) / h),
        slope_from_start((1.0 - s) * (1.0 - 3.0 * s)),
        slope_from_end(s * (3.0 * s - 2.0)) {}
};

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
  now_.active.resize(contacts_->reports().size());
  for (std::size_t i = 0; i < now_.active.size(); ++i) now_.active[i] = contacts_->reports()[i].active;
}

void LossErrorSum::AddSolve(int k, const VectorXd& lambda, const VectorXd& by_pose) {
  const StepFormula& f = trajectory_.formula(k);
  if (f.is_stage) return;
  const bool ends_chosen = trajectory_.formula(k - 1).is_stage;
  const bool starts_chosen = k + 1 < trajectory_.size() && trajectory_.formula(k + 1).is_stage;
  const double before = ends_chosen ? StepFormula::kDiagonal * f.step : f.step;
  const double after = starts_chosen ? StepFormula::kWeight * trajectory_.formula(k + 1).step : 0.0;
  now_.mu = lambda / (before + after);
  now_.bar_pose -= after / (before + after) * by_pose;
  if (starts_chosen) sum_ += CalcStep(now_, after_);
  std::swap(now_, after_);
}

void LossErrorSum::CalcBristles(double s, const Node& start, const Node& end, double h) {
  middle_.Clear();
  middle_rate_.clear();
  bar_middle_.clear();
  const Hermite at(s, h);
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
    middle_.z.push_back(z_a + at.value * (z_b - z_a) + at.from_start * rate_a + at.from_end * rate_b);
    middle_rate_.push_back(at.slope * (z_b - z_a) + at.slope_from_start * rate_a + at.slope_from_end * rate_b);
    bar_middle_.push_back(0.5 * ((in_a ? start.bar_bristles[i] : zero) + (in_b ? end.bar_bristles[j] : zero)));
    i += in_a ? 1 : 0;
    j += in_b ? 1 : 0;
  }
}

double LossErrorSum::CalcStep(const Node& start, const Node& end) {
  const double h = trajectory_.formula(end.state).step;
  const double middle = CalcAt(0.5, start, end);
  if (start.active == end.active) return 2.0 * h / 3.0 * middle;
  return h / 6.0 * (2.0 * CalcAt(0.25, start, end) + middle + 2.0 * CalcAt(0.75, start, end));
}

double LossErrorSum::CalcAt(double s, const Node& start, const Node& end) {
  const Tree& tree = dynamics_->tree();
  const int k = start.state;
  const int e = end.state;
  const double h = trajectory_.formula(e).step;
  const Hermite at(s, h);
  const VectorXd v_s = trajectory_.v(k);
  const VectorXd v_e = trajectory_.v(e);
  const VectorXd a_s = trajectory_.vdot(k);
  const VectorXd a_e = trajectory_.vdot(e);
  const Increment step = Compose(tree, trajectory_.xi(k + 1), trajectory_.xi(e), v_e);
  const VectorXd xi = at.value * step.total + at.from_start * v_s + at.from_end * step.end_slope;
  const VectorXd slope = at.slope * step.total + at.slope_from_start * v_s + at.slope_from_end * step.end_slope;
  const VectorXd v = v_s + at.value * (v_e - v_s) + at.from_start * a_s + at.from_end * a_e;
  const VectorXd vdot = at.slope * (v_e - v_s) + at.slope_from_start * a_s + at.slope_from_end * a_e;
  VectorXd q = trajectory_.q(k);
  tree.AddIncrement(q, xi, &q);
  dynamics_->CalcKinematics(q, v, vdot, trajectory_.time(k) + s * h);
  CalcBristles(s, start, end, h);
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
  return worth;
}

}  // namespace knap
