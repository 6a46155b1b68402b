// A C² ramp: 0 for x ≤ 0, x for x ≥ width, and the quintic between them that meets both with two derivatives.
//
//   ramp(x) = width · (6 t³ − 8 t⁴ + 3 t⁵),  t = x / width.   Monotone; its slope peaks at 1.512 at t = 0.6.
#pragma once

namespace knap {

struct SmoothRamp {
  double value = 0.0;
  double slope = 0.0;
};

inline SmoothRamp CalcSmoothRamp(double x, double width) {
  if (x <= 0.0) return {0.0, 0.0};
  if (x >= width) return {x, 1.0};
  const double t = x / width;
  const double t2 = t * t;
  return {width * t2 * t * (6.0 + t * (-8.0 + 3.0 * t)), t2 * (18.0 + t * (-32.0 + 15.0 * t))};
}

}  // namespace knap
