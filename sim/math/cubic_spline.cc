#include "sim/math/cubic_spline.h"

#include <algorithm>
#include <cstddef>
#include <stdexcept>
#include <utility>

namespace knap {

CubicSpline::CubicSpline(std::vector<double> times, std::vector<double> values)
    : times_(std::move(times)), values_(std::move(values)), slopes_(times_.size(), 0.0) {
  const std::size_t n = times_.size();
  if (n < 2 || values_.size() != n) throw std::invalid_argument("a spline needs at least two points");
  const auto h = [this](std::size_t i) { return times_[i + 1] - times_[i]; };
  for (std::size_t i = 0; i + 1 < n; ++i) {
    if (!(h(i) > 0.0)) throw std::invalid_argument("the times of a spline's points must ascend");
  }
  // Thomas' elimination: the matrix is dominated by its diagonal.
  std::vector<double> above(n, 0.0);
  for (std::size_t i = 1; i + 1 < n; ++i) {
    const double before = 1.0 / h(i - 1);
    const double after = 1.0 / h(i);
    const double right =
        3.0 * (before * before * (values_[i] - values_[i - 1]) + after * after * (values_[i + 1] - values_[i]));
    const double pivot = 2.0 * (before + after) - before * above[i - 1];
    above[i] = after / pivot;
    slopes_[i] = (right - before * slopes_[i - 1]) / pivot;
  }
  for (std::size_t i = n - 1; i-- > 1;) slopes_[i] -= above[i] * slopes_[i + 1];
}

CubicSpline::Value CubicSpline::Calc(double time) const {
  if (time <= times_.front()) return {values_.front()};
  if (time >= times_.back()) return {values_.back()};
  const auto next = std::upper_bound(times_.begin(), times_.end(), time);
  const auto i = static_cast<std::size_t>(next - times_.begin()) - 1;
  const double h = times_[i + 1] - times_[i];
  const double s = time - times_[i];
  const double mean = (values_[i + 1] - values_[i]) / h;
  // x = x_i + m_i s + c s² + d s³
  const double c = (3.0 * mean - 2.0 * slopes_[i] - slopes_[i + 1]) / h;
  const double d = (slopes_[i] + slopes_[i + 1] - 2.0 * mean) / (h * h);
  return {values_[i] + s * (slopes_[i] + s * (c + s * d)), slopes_[i] + s * (2.0 * c + 3.0 * s * d),
          2.0 * c + 6.0 * s * d, 6.0 * d};
}

}  // namespace knap
