#include "sim/contact/bristle.h"

#include <algorithm>
#include <cmath>

namespace knap {

namespace {

constexpr double kElasticShare = 0.85;

struct Sliding {
  double value;
  double slope;
};

// beta of the header and its slope; beyond the bound as steep as at its steepest, so that what an integrator's
// extrapolation bends too far comes back.
Sliding CalcSliding(double share) {
  const double t = (share - kElasticShare) / (1.0 - kElasticShare);
  if (t <= 0.0) return {0.0, 0.0};
  if (t >= 1.0) return {1.0, 0.0};
  return {t * t * t * (10.0 + t * (-15.0 + 6.0 * t)), 30.0 * t * t * (1.0 - t) * (1.0 - t) / (1.0 - kElasticShare)};
}

}  // namespace

BristleStep CalcBristleStep(const Bristle& z0, const Bristle& s, double h, double bound) {
  BristleStep step;
  step.h = h;
  step.y = z0 + h * s;
  const double length = step.y.norm();
  step.z = step.y;
  if (!(length > kElasticShare * bound)) return step;
  step.slip = s.dot(step.y) / length;
  const double slid = h * std::max(0.0, step.slip);
  // Newton within a bracket, halved where Newton's step does not halve the last one: l − length + slid·beta rises from
  // below 0 to above.
  double low = 0.0;
  double high = length;
  double l = std::min(length, bound);
  double last_move = length;
  Sliding beta{};
  for (int i = 0; i < 200; ++i) {
    beta = CalcSliding(l / bound);
    const double residual = l + slid * beta.value - length;
    (residual > 0.0 ? high : low) = l;
    double next = l - residual / (1.0 + slid * beta.slope / bound);
    if (!(next > low && next < high && std::abs(next - l) < 0.5 * last_move)) next = 0.5 * (low + high);
    last_move = std::abs(next - l);
    if (next == l || last_move <= 1e-16 * bound) break;
    l = next;
  }
  beta = CalcSliding(l / bound);
  step.factor = l / length;
  step.z = step.factor * step.y;
  step.dl_dy = 1.0 / (1.0 + slid * beta.slope / bound);
  step.dl_dslip = step.slip > 0.0 ? -beta.value * step.dl_dy : 0.0;
  return step;
}

void PullBackBristleStep(const BristleStep& step, const Bristle& s, const Bristle& bar_z, Bristle* bar_z0,
                         Bristle* bar_s) {
  const double length = step.y.norm();
  if (step.factor == 1.0 || !(length > 0.0)) {
    *bar_z0 += bar_z;
    *bar_s += step.h * bar_z;
    return;
  }
  const Bristle along = step.y / length;
  const double bar_l = along.dot(bar_z);
  // The slip along ŷ moves with s, and with ŷ itself.
  const double bar_slip = bar_l * step.dl_dslip * step.h;
  const Bristle bar_along = step.factor * length * bar_z + bar_slip * s;
  const Bristle bar_y = bar_l * step.dl_dy * along + (bar_along - along.dot(bar_along) * along) / length;
  *bar_z0 += bar_y;
  *bar_s += step.h * bar_y + bar_slip * along;
}

}  // namespace knap
