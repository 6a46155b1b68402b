#include "sim/rollout/loss_terms.h"

#include <cmath>

#include "sim/math/check.h"

namespace knap {

using Eigen::Vector3d;

namespace {

int Index(Axis axis) { return static_cast<int>(axis); }

// Cubic Hermite basis on [0, 1]: values h00, h01 of the ends' positions, h10, h11 of their derivatives in s.
struct Hermite {
  double h00, h10, h01, h11;
};
Hermite CalcHermite(double s) {
  return {(1 + 2 * s) * (1 - s) * (1 - s), s * (1 - s) * (1 - s), s * s * (3 - 2 * s), s * s * (s - 1)};
}
Hermite CalcHermiteSlope(double s) {
  return {6 * s * s - 6 * s, 3 * s * s - 4 * s + 1, 6 * s - 6 * s * s, 3 * s * s - 2 * s};
}

double Apply(const Hermite& w, const BodyPath& path, int k, int axis) {
  const double h = path.time[k + 1] - path.time[k];
  return w.h00 * path.p_W[k](axis) + w.h10 * h * path.v_W[k](axis) + w.h01 * path.p_W[k + 1](axis) +
         w.h11 * h * path.v_W[k + 1](axis);
}

}  // namespace

BodyPath TraceBody(const Trajectory& trajectory, int body, Dynamics* dynamics) {
  BodyPath path;
  path.body = body;
  const int count = trajectory.size();
  path.time.reserve(count);
  path.p_W.reserve(count);
  path.v_W.reserve(count);
  Eigen::VectorXd q;
  Eigen::VectorXd v;
  Eigen::VectorXd vdot;
  for (int k = 0; k < count; ++k) {
    q = trajectory.q(k);
    v = trajectory.v(k);
    vdot = trajectory.vdot(k);
    dynamics->CalcKinematics(q, v, vdot, trajectory.time(k));
    const BodyKinematics& kin = dynamics->kinematics()[body];
    path.time.push_back(trajectory.time(k));
    path.p_W.push_back(kin.X_WB.p);
    path.v_W.push_back(kin.X_WB.R * kin.V.tail<3>());
  }
  for (int n = 0; n <= trajectory.whole_steps(); ++n) path.state_of_step.push_back(trajectory.state_of_step(n));
  return path;
}

std::optional<Crossing> FindCrossing(const BodyPath& path, const Opening& opening) {
  const int y = Index(opening.axis);
  const bool from_below = path.p_W[0](y) < opening.at;
  for (int k = 0; k + 1 < static_cast<int>(path.p_W.size()); ++k) {
    if ((path.p_W[k + 1](y) < opening.at) == from_below) continue;
    // Bisection to rounding: the end values have different sides, so a root exists and is found the same way always.
    double low = 0.0;
    double high = 1.0;
    for (int i = 0; i < 60; ++i) {
      const double s = 0.5 * (low + high);
      ((Apply(CalcHermite(s), path, k, y) < opening.at) == from_below ? low : high) = s;
    }
    Crossing crossing;
    crossing.state = k;
    crossing.fraction = 0.5 * (low + high);
    crossing.time = path.time[k] + crossing.fraction * (path.time[k + 1] - path.time[k]);
    const int x = Index(opening.opening_axis);
    crossing.x = Apply(CalcHermite(crossing.fraction), path, k, x);
    const Hermite slope = CalcHermiteSlope(crossing.fraction);
    crossing.dx_ds = Apply(slope, path, k, x);
    crossing.dy_ds = Apply(slope, path, k, y);
    return crossing;
  }
  return std::nullopt;
}

double EvaluateCrossingLoss(const CrossingLoss& loss, const BodyPath& path, std::vector<StateCotangent>* out) {
  const Opening& opening = loss.opening;
  const int x = Index(opening.opening_axis);
  const int y = Index(opening.axis);
  const double unit2 = loss.length_unit * loss.length_unit;
  const std::optional<Crossing> crossing = FindCrossing(path, opening);
  const int last = static_cast<int>(path.p_W.size()) - 1;
  const double at_x = (crossing ? crossing->x : path.p_W[last](x)) - opening.opening_center;
  const double outside = std::max(0.0, std::abs(at_x) - opening.opening_half_width);
  double value = loss.weight * outside * outside / unit2;
  const double bar_x = loss.weight * 2.0 * outside * (at_x > 0.0 ? 1.0 : -1.0) / unit2;
  if (crossing) {
    if (out != nullptr && bar_x != 0.0) {
      const int k = crossing->state;
      const double h = path.time[k + 1] - path.time[k];
      const Hermite w = CalcHermite(crossing->fraction);
      const double bar_y = -bar_x * crossing->dx_ds / crossing->dy_ds;
      StateCotangent begin{k, path.body, Vector3d::Zero(), Vector3d::Zero()};
      StateCotangent end{k + 1, path.body, Vector3d::Zero(), Vector3d::Zero()};
      double bar_h = 0.0;
      for (const auto& [axis, bar] : {std::pair{x, bar_x}, std::pair{y, bar_y}}) {
        begin.p_W(axis) += bar * w.h00;
        begin.v_W(axis) += bar * w.h10 * h;
        end.p_W(axis) += bar * w.h01;
        end.v_W(axis) += bar * w.h11 * h;
        bar_h += bar * (w.h10 * path.v_W[k](axis) + w.h11 * path.v_W[k + 1](axis));
      }
      begin.time = -bar_h;
      end.time = bar_h;
      out->push_back(begin);
      out->push_back(end);
    }
    return value;
  }
  // Never arrived, by d: the lateral miss fades with d and what is missing levels off, both at the scale S:
  //   S² (miss + shortfall_weight d²) / (S² + d²),  continuous with an arrival at d = 0.
  const double d = opening.at - path.p_W[last](y);
  const double S2 = loss.shortfall_scale * loss.shortfall_scale;
  const double w = loss.shortfall_weight / unit2;
  const double fade = S2 / (S2 + d * d);
  if (out != nullptr) {
    StateCotangent end{last, path.body, Vector3d::Zero(), Vector3d::Zero()};
    end.p_W(x) = fade * bar_x;
    end.p_W(y) = -2.0 * d * (w * S2 - value) * fade / (S2 + d * d);
    out->push_back(end);
  }
  return fade * (value + w * d * d);
}

double EvaluatePositionMatch(const PositionMatchLoss& loss, double step, const BodyPath& path,
                             const BodyPath& reference, std::vector<StateCotangent>* out) {
  KNAP_CHECK(path.state_of_step.size() == reference.state_of_step.size(), "paths of {} and {} steps",
             path.state_of_step.size(), reference.state_of_step.size());
  const int stride = static_cast<int>(std::llround(loss.sample_period / step));
  const int steps = static_cast<int>(path.state_of_step.size()) - 1;
  const int samples = steps / stride;
  if (samples == 0) return 0.0;
  double scale = loss.weight / (loss.length_unit * loss.length_unit);
  if (loss.normalize == Normalization::kMean) scale /= samples;
  double sum = 0.0;
  for (int n = stride; n <= steps; n += stride) {
    StateCotangent cotangent{path.state_of_step[n], path.body, Vector3d::Zero(), Vector3d::Zero()};
    const Vector3d difference = path.p_W[path.state_of_step[n]] - reference.p_W[reference.state_of_step[n]];
    for (const Axis axis : loss.axes) {
      const double d = difference(Index(axis));
      sum += d * d;
      cotangent.p_W(Index(axis)) = 2.0 * scale * d;
    }
    if (out != nullptr) out->push_back(cotangent);
  }
  return scale * sum;
}

bool CrossesInside(const Opening& opening, const BodyPath& path) {
  const std::optional<Crossing> crossing = FindCrossing(path, opening);
  return crossing && std::abs(crossing->x - opening.opening_center) < opening.opening_half_width;
}

}  // namespace knap
