// A curved valley with its minimum, 0, at (1, 1).
#pragma once

#include <vector>

#include "coordinator/optimizer/bounded_minimizer.h"

namespace knap::test {

inline ObjectiveValue CalcRosenbrock(const std::vector<double>& x) {
  const double a = x[1] - x[0] * x[0], b = 1.0 - x[0];
  return {.value = 100.0 * a * a + b * b, .gradient = {-400.0 * x[0] * a - 2.0 * b, 200.0 * a}};
}

}  // namespace knap::test
