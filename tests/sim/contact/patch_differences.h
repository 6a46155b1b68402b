// Central differences of patches under a perturbation of the touching body's place, seen in the field's frame.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <utility>

#include "sim/contact/patch_integrals.h"
#include "sim/math/pose.h"
#include "sim/math/so3.h"

namespace knap::test {

inline PatchIntegrals::Vector Pack(const PatchIntegrals& p) {
  PatchIntegrals::Vector out;
  out << p.F, p.M, p.W, p.m1, p.m2(0, 0), p.m2(0, 1), p.m2(0, 2), p.m2(1, 1), p.m2(1, 2), p.m2(2, 2);
  return out;
}

// The pose after a small perturbation (rotation, translation) of B in S.
inline Pose Perturb(const Pose& X_SB, int k, double h) {
  Pose out = X_SB;
  if (k < 3) {
    const Eigen::Matrix3d R = ExpSo3(h * Eigen::Vector3d::Unit(k)).toRotationMatrix();
    out = {R * X_SB.R, R * X_SB.p};
  } else {
    out.p += h * Eigen::Vector3d::Unit(k - 3);
  }
  return out;
}

// Each column against differences of fourth order, each number against the largest of its kind: F, M, W, m1, m2, and
// against what the kind itself would change by over a centimetre or a radian where that is all that moves it.
inline void ExpectJacobian(const PatchJacobian& jacobian, const Pose& X_SB, double h, double tolerance,
                           const std::function<PatchIntegrals(const Pose&)>& calc) {
  PatchJacobian differences;
  const PatchIntegrals::Vector value = Pack(calc(X_SB));
  for (int k = 0; k < 6; ++k) {
    const auto at = [&](double s) { return Pack(calc(Perturb(X_SB, k, s * h))); };
    differences.col(k) = (8.0 * (at(1.0) - at(-1.0)) - (at(2.0) - at(-2.0))) / (12.0 * h);
  }
  for (const auto& [first, count] : {std::pair{0, 3}, {3, 3}, {6, 1}, {7, 3}, {10, 6}}) {
    for (const auto& [column, columns] : {std::pair{0, 3}, {3, 3}}) {
      const auto a = jacobian.block(first, column, count, columns);
      const auto b = differences.block(first, column, count, columns);
      const double least = value.segment(first, count).cwiseAbs().maxCoeff() / (column == 0 ? 1.0 : 0.01);
      const double scale = std::max({least, a.cwiseAbs().maxCoeff(), b.cwiseAbs().maxCoeff()});
      EXPECT_LE((a - b).cwiseAbs().maxCoeff(), tolerance * scale)
          << "rows from " << first << ", columns from " << column << "\n"
          << a << "\n\n"
          << b;
    }
  }
}

}  // namespace knap::test
