// The classical fourth-order Runge–Kutta method with a constant step: s' = slope(s), as a reference by another method.
#pragma once

#include <array>
#include <cstddef>

namespace knap::test {

template <std::size_t N, class Slope>
std::array<double, N> IntegrateRungeKutta(const Slope& slope, std::array<double, N> s, double duration, int steps) {
  using State = std::array<double, N>;
  const auto add = [](const State& from, double by, const State& d) {
    State out = from;
    for (std::size_t i = 0; i < N; ++i) out[i] += by * d[i];
    return out;
  };
  const double h = duration / steps;
  for (int k = 0; k < steps; ++k) {
    const State k1 = slope(s);
    const State k2 = slope(add(s, 0.5 * h, k1));
    const State k3 = slope(add(s, 0.5 * h, k2));
    const State k4 = slope(add(s, h, k3));
    for (std::size_t i = 0; i < N; ++i) s[i] += h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]);
  }
  return s;
}

}  // namespace knap::test
