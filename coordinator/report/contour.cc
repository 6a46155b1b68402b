#include "coordinator/report/contour.h"

#include <array>
#include <cmath>

namespace knap {

using Eigen::Vector2d;

std::vector<Segment> CalcContour(const Eigen::MatrixXd& values, double level) {
  std::vector<Segment> segments;
  for (Eigen::Index i = 0; i + 1 < values.rows(); ++i) {
    for (Eigen::Index j = 0; j + 1 < values.cols(); ++j) {
      // Around the square: edge k joins corner k and corner k + 1.
      const std::array<double, 4> f = {values(i, j), values(i, j + 1), values(i + 1, j + 1), values(i + 1, j)};
      const Vector2d origin(static_cast<double>(j), static_cast<double>(i));
      const std::array<Vector2d, 4> corner = {origin, origin + Vector2d(1, 0), origin + Vector2d(1, 1),
                                              origin + Vector2d(0, 1)};
      if (!std::isfinite(f[0] + f[1] + f[2] + f[3])) continue;
      std::vector<Vector2d> crossings;
      for (std::size_t k = 0; k < 4; ++k) {
        const std::size_t next = (k + 1) % 4;
        if ((f[k] > level) == (f[next] > level)) continue;
        crossings.push_back(corner[k] + (level - f[k]) / (f[next] - f[k]) * (corner[next] - corner[k]));
      }
      if (crossings.size() == 2) segments.push_back({crossings[0], crossings[1]});
      if (crossings.size() == 4) {
        // The lines cut off the corners on the other side of the level than the middle: crossing k lies on edge k.
        const bool middle_above = 0.25 * (f[0] + f[1] + f[2] + f[3]) > level;
        const std::size_t first = (f[0] > level) == middle_above ? 0 : 3;  // 0: corners 1 and 3 are cut off
        segments.push_back({crossings[first], crossings[(first + 1) % 4]});
        segments.push_back({crossings[(first + 2) % 4], crossings[(first + 3) % 4]});
      }
    }
  }
  return segments;
}

std::vector<double> ListRoundNumbers(double lower, double upper, int count) {
  const double rough = (upper - lower) / count;
  const double power = std::pow(10.0, std::floor(std::log10(rough)));
  const double ratio = rough / power;
  const double step = power * (ratio <= 1.5 ? 1.0 : ratio <= 3.5 ? 2.0 : ratio <= 7.5 ? 5.0 : 10.0);
  const double slack = 1e-9 * (upper - lower);
  std::vector<double> numbers;
  for (double k = std::ceil((lower - slack) / step); k * step <= upper + slack; ++k)
    numbers.push_back(k * step + 0.0);  // + 0: no −0
  return numbers;
}

}  // namespace knap
