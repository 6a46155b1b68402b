// Derivatives by differences, for tests of gradients.
#pragma once

#include <Eigen/Core>

namespace knap::test {

// Of f in x(i): central differences at steps h and h/2, extrapolated to fourth order.
template <class F>
double CalcDifference(const F& f, const Eigen::VectorXd& x, Eigen::Index i, double h) {
  const auto central = [&](double step) {
    Eigen::VectorXd above = x, below = x;
    above(i) += step;
    below(i) -= step;
    return (f(above) - f(below)) / (above(i) - below(i));
  };
  return (4.0 * central(0.5 * h) - central(h)) / 3.0;
}

}  // namespace knap::test
