#include "sim/transfer/contact_law.h"

#include <cmath>

namespace knap {

double CalcRebound(double damping, double speed) {
  const double x = damping * speed;
  if (x < 1e-6) return 1.0 - 2.0 / 3.0 * x;
  const double energy = x - std::log1p(x);
  double low = 0.0, high = 1.0;
  for (int i = 0; i < 60; ++i) {
    const double y = 0.5 * (low + high);
    (-y - std::log1p(-y) < energy ? low : high) = y;
  }
  return std::fmin(1.0, 0.5 * (low + high) / x);
}

}  // namespace knap
