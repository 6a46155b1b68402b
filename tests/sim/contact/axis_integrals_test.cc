// Round bodies: closed forms of balls, derivatives against differences, no force along an axis.
#include "sim/contact/axis_integrals.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "sim/math/so3.h"
#include "tests/sim/contact/patch_differences.h"

namespace knap {
namespace {

using Eigen::Vector3d;

TEST(AxisIntegralsTest, BallOnHalfSpaceIsBuoyancy) {
  const double r = 0.007;
  for (const double depth : {1e-6, 1e-4, 1e-3, 0.006, 0.0139}) {
    PatchIntegrals patch;
    CalcAxis({Vector3d(0.01, 0.02, r - depth), Vector3d::UnitZ(), 0.0, r}, PolyhedralField::MakeHalfSpace(), &patch,
             nullptr);
    EXPECT_NEAR(patch.F.z(), std::numbers::pi * depth * depth * (r - depth / 3.0), 1e-12 * patch.F.z());
    EXPECT_NEAR(patch.m1.x() / patch.W, 0.01, 1e-15);
  }
  // Wholly below: its volume, however deep.
  PatchIntegrals patch;
  CalcAxis({Vector3d(0.0, 0.0, -1.0), Vector3d::UnitZ(), 0.0, r}, PolyhedralField::MakeHalfSpace(), &patch, nullptr);
  EXPECT_NEAR(patch.F.z(), 4.0 / 3.0 * std::numbers::pi * r * r * r, 1e-15);
}

TEST(AxisIntegralsTest, MovesAsDifferencesSay) {
  std::mt19937_64 generator(3);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  int compared = 0;
  for (int trial = 0; trial < 200; ++trial) {
    const double half_length = trial % 3 == 0 ? 0.0 : 0.01;
    const double r = 0.004;
    DepthField field = PolyhedralField::MakeHalfSpace();
    double lift = 0.002;
    if (trial % 2 == 0) {
      field = RoundField{0.005, trial % 4 == 0 ? 0.0 : 0.008, Vector3d(0.001, 0.0, 0.002)};
      lift = 0.007;
    }
    Pose X_SB{ExpSo3(Vector3d(2.0 * uniform(generator), 2.0 * uniform(generator), 0.0)).toRotationMatrix(),
              Vector3d(0.002 * uniform(generator), lift + 0.001 * uniform(generator), lift)};
    const auto calc = [&](const Pose& X, PatchJacobian* jacobian) {
      PatchIntegrals patch;
      CalcAxis({X.p, X.R.col(2), half_length, r}, field, &patch, jacobian);
      return patch;
    };
    PatchJacobian jacobian;
    if (!(calc(X_SB, &jacobian).W > 0.0)) continue;
    ++compared;
    test::ExpectJacobian(jacobian, X_SB, 1e-7, 2e-6, [&](const Pose& X) { return calc(X, nullptr); });
  }
  EXPECT_GT(compared, 80);
}

TEST(AxisIntegralsTest, NothingActsAlongABarAcrossAnother) {
  for (const double angle : {0.02, 0.1, 0.35}) {
    const Vector3d along(std::cos(angle), 0.0, std::sin(angle));
    PatchIntegrals on_bar;
    CalcAxis({Vector3d(0.003, 0.0, 0.0099), along, 0.1, 0.005},
             RoundField{0.005, 0.03, Vector3d::Zero(), Vector3d::UnitY()}, &on_bar, nullptr);
    ASSERT_GT(on_bar.F.norm(), 0.0);
    EXPECT_LE(std::abs(on_bar.F.dot(along)), 1e-13 * on_bar.F.norm());
    PatchIntegrals on_rail;
    CalcAxis({Vector3d::Zero(), Vector3d::UnitY(), 0.03, 0.005},
             RoundField{0.005, 0.1, Vector3d(0.003, 0.0, 0.0099), along}, &on_rail, nullptr);
    EXPECT_LE(std::abs(on_rail.F.dot(along)), 1e-13 * on_rail.F.norm());
  }
}

}  // namespace
}  // namespace knap
