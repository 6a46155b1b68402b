#include "coordinator/random/exact_functions.h"

#include <cmath>

namespace knap {
namespace {

constexpr double kLog2 = 0.69314718055994530942;
constexpr double kHalfPi = 1.57079632679489661923;

}  // namespace

// With x = m 2^e, m in [1/sqrt(2), sqrt(2)) and s = (m - 1)/(m + 1), log x = e log 2 + 2 (s + s^3/3 + s^5/5 + …), where
// |s| < 0.172 makes the term s^25 vanish in double.
double CalcLogarithm(double x) {
  constexpr double kSqrtHalf = 0.70710678118654752440;
  int e = 0;
  double m = std::frexp(x, &e);  // exact
  if (m < kSqrtHalf) {
    m *= 2.0;
    --e;
  }
  const double s = (m - 1.0) / (m + 1.0);
  double series = 0.0;
  for (int k = 23; k >= 1; k -= 2) series = series * (s * s) + 1.0 / k;
  return e * kLog2 + 2.0 * s * series;
}

// x = k log 2 + r with |r| <= log(2)/2, where the term r^18/18! vanishes in double.
double CalcExponential(double x) {
  const double k = std::floor(x / kLog2 + 0.5);
  const double r = x - k * kLog2;
  double series = 1.0;
  for (int n = 18; n >= 1; --n) series = 1.0 + series * r / n;
  return std::ldexp(series, static_cast<int>(k));  // exact
}

// Of t = min/max of both sizes, in [0, 1], by halving the angle thrice, t -> t/(1 + sqrt(1 + t²)): what is left is
// below 0.1, where the term t^17/17 vanishes in double.
double CalcArcTangent(double y, double x) {
  const double a = std::abs(x), b = std::abs(y);
  if (a == 0.0 && b == 0.0) return 0.0;
  double t = a > b ? b / a : a / b;
  for (int i = 0; i < 3; ++i) t /= 1.0 + std::sqrt(1.0 + t * t);
  double series = 0.0;
  for (int k = 17; k >= 1; k -= 2) series = 1.0 / k - series * (t * t);
  double angle = 8.0 * t * series;
  if (b >= a) angle = kHalfPi - angle;
  if (x < 0.0) angle = 2.0 * kHalfPi - angle;
  return y < 0.0 ? -angle : angle;
}

// angle = k pi/2 + r with |r| <= pi/4, where the terms of order 19 vanish in double.
void CalcSineCosine(double angle, double* sine, double* cosine) {
  const double k = std::floor(angle / kHalfPi + 0.5);
  const double r = angle - k * kHalfPi;
  double s = 1.0, c = 1.0;
  for (int n = 18; n >= 2; n -= 2) {
    s = 1.0 - s * (r * r) / (n * (n + 1));
    c = 1.0 - c * (r * r) / (n * (n - 1));
  }
  s *= r;
  const int quadrant = static_cast<int>(k - 4.0 * std::floor(k / 4.0));
  *sine = quadrant == 0 ? s : quadrant == 1 ? c : quadrant == 2 ? -s : -c;
  *cosine = quadrant == 0 ? c : quadrant == 1 ? -s : quadrant == 2 ? -c : s;
}

}  // namespace knap
