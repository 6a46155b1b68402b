// The bristle as a differential equation: the same sliding friction for every step, no creep, its derivatives.
#include "sim/contact/bristle.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace knap {
namespace {

constexpr double kBound = 1e-4;

TEST(BristleTest, SlidesAtItsBoundWhateverTheStep) {
  for (const double h : {4e-3, 1e-3, 1e-4, 1e-6}) {
    Bristle z = Bristle::Zero();
    const Bristle s(0.006, 0.008, 0.0, 0.0);  // 10 mm/s
    // The last per cent of the way to the bound takes as long again as some bounds' worth of slip.
    for (double t = 0.0; t < 0.3; t += h) z = CalcBristleStep(z, s, h, kBound).z;
    EXPECT_NEAR(z.norm(), kBound, 2e-2 * kBound) << "step " << h;
  }
}

TEST(BristleTest, BendsAsFarAsItIsMovedBelowItsBound) {
  Bristle z = Bristle::Zero();
  for (int i = 0; i < 1000; ++i) z = CalcBristleStep(z, Bristle(0.8e-4, 0.0, 0.0, 0.0), 1e-3, kBound).z;
  EXPECT_NEAR(z(0), 0.8e-4, 1e-16);
  for (int i = 0; i < 1000; ++i) z = CalcBristleStep(z, Bristle::Zero(), 1e-3, kBound).z;
  EXPECT_NEAR(z(0), 0.8e-4, 1e-16);
}

TEST(BristleTest, StepsConvergeToOneAnother) {
  const auto run = [](int n) {
    Bristle z = Bristle::Zero();
    const double h = 0.02 / n;
    for (int i = 0; i < n; ++i) {
      const double t = (i + 1) * h;
      z = CalcBristleStep(z, Bristle(0.02 * std::cos(200.0 * t), 0.01 * std::sin(300.0 * t), 0.005, 0.01), h, kBound).z;
    }
    return z;
  };
  const Bristle exact = run(64000);
  const double coarse = (run(1000) - exact).norm();
  const double fine = (run(4000) - exact).norm();
  EXPECT_LT(fine, 0.35 * coarse);  // first order
  EXPECT_LT(fine, 0.02 * kBound);
}

TEST(BristleTest, Cotangents) {
  std::mt19937_64 generator(2);
  std::normal_distribution<double> normal;
  int slid = 0;
  for (int trial = 0; trial < 300; ++trial) {
    Bristle z0, s, bar;
    for (int i = 0; i < 4; ++i) {
      z0(i) = 0.45 * kBound * normal(generator);
      s(i) = 0.02 * normal(generator);
      bar(i) = normal(generator);
    }
    z0 *= std::min(1.0, 0.99 * kBound / z0.norm());
    const double h = 2e-3;
    const BristleStep step = CalcBristleStep(z0, s, h, kBound);
    EXPECT_LE(step.z.norm(), kBound * (1.0 + 1e-12));
    if (step.z.norm() > 0.86 * kBound) ++slid;
    Bristle bar_z0 = Bristle::Zero();
    Bristle bar_s = Bristle::Zero();
    PullBackBristleStep(step, s, bar, &bar_z0, &bar_s);
    for (int i = 0; i < 4; ++i) {
      const double d = 1e-9;
      const Bristle dz = d * Bristle::Unit(i);
      const double by_z0 =
          bar.dot(CalcBristleStep(z0 + dz, s, h, kBound).z - CalcBristleStep(z0 - dz, s, h, kBound).z) / (2.0 * d);
      EXPECT_NEAR(bar_z0(i), by_z0, 1e-5 * (1.0 + bar.norm()));
      const Bristle ds = d / h * Bristle::Unit(i);
      const double by_s =
          bar.dot(CalcBristleStep(z0, s + ds, h, kBound).z - CalcBristleStep(z0, s - ds, h, kBound).z) / (2.0 * d / h);
      EXPECT_NEAR(bar_s(i), by_s, 1e-5 * h * (1.0 + bar.norm()));
    }
  }
  EXPECT_GT(slid, 50);
}

}  // namespace
}  // namespace knap
