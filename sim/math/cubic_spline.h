// A cubic spline through points, level at both ends and constant beyond them: C² within, C¹ at the ends.
//
//   s(t) on [t_i, t_{i+1}] is the cubic with the values x_i, x_{i+1} and the slopes m_i, m_{i+1};  m_0 = m_n = 0,
//   m_{i−1}/h_{i−1} + 2 m_i (1/h_{i−1} + 1/h_i) + m_{i+1}/h_i = 3 ((x_i − x_{i−1})/h_{i−1}² + (x_{i+1} − x_i)/h_i²)
//
// with h_i = t_{i+1} − t_i: s'' has no jumps at the points between.
#pragma once

#include <vector>

namespace knap {

class CubicSpline {
 public:
  // At least two points; times ascend. Throws std::invalid_argument otherwise.
  CubicSpline(std::vector<double> times, std::vector<double> values);

  struct Value {
    double x = 0.0;
    double rate = 0.0;          // [1/s]
    double acceleration = 0.0;  // [1/s²]
    double jerk = 0.0;          // [1/s³], constant between two points
  };
  Value Calc(double time) const;

 private:
  std::vector<double> times_, values_, slopes_;
};

}  // namespace knap
