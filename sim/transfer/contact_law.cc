#include "sim/transfer/contact_law.h"

#include <cmath>

#include "sim/math/smooth_ramp.h"

namespace knap {

double CalcRebound(double damping, double speed) {
  const double x = damping * speed;
  if (x < 1e-6) return 1.0;
  const double energy = x - std::log1p(x);
  // The return, in steps of y short beside x, so that the last one is found well by its share.
  constexpr int kSteps = 1000;
  const double h = std::fmin(x, 1.0) / kSteps;
  double passed = 0.0;
  for (int i = 0; i < kSteps; ++i) {
    const double y = (i + 0.5) * h;
    const double slice = h * y / CalcSmoothRamp(1.0 - y, 1.0).value;
    if (passed + slice >= energy) return (i + (energy - passed) / slice) * h / x;
    passed += slice;
  }
  return std::fmin(1.0, 1.0 / x);
}

}  // namespace knap
