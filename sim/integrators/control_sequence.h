// Controls that are constant over intervals of a whole number of steps.
#pragma once

#include <Eigen/Dense>
#include <algorithm>

namespace knap {

struct ControlSequence {
  int steps_per_interval = 1;
  Eigen::MatrixXd values;  // a row an actuator, a column an interval; the last one holds on. Empty: all zero

  // The column that acts during whole step n, counted from 0. Needs values.
  Eigen::Index IntervalOfStep(int n) const { return std::min<Eigen::Index>(n / steps_per_interval, values.cols() - 1); }
};

}  // namespace knap
