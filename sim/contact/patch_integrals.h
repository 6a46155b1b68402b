// What a patch of contact is to the laws of dissipation, and how it moves with the bodies.
//
// A patch is one body's surface (or axis) in one cell of another body's depth field e [m]. All in the field's frame S,
// x the place, dμ the measure that is summed over, f the elastic force on the touching body B for each dμ:
//
//   F = ∫ f dμ [N]   M = ∫ x × f dμ [N m], about So   W = ∫ e dμ   m1 = ∫ e x dμ   m2 = ∫ e x xᵀ dμ
//
// so that m1/W is the patch's centre and m2/W − (m1/W)(m1/W)ᵀ the spread around it. The unit of W is the measure's
// business: only ratios of the last three count.
#pragma once

#include <Eigen/Core>
#include <array>

#include "sim/math/so3.h"

namespace knap {

struct PatchIntegrals {
  static constexpr int kCount = 16;
  using Vector = Eigen::Matrix<double, kCount, 1>;
  // Of the six numbers of a symmetric matrix, which rows and columns they are.
  static constexpr std::array<std::array<int, 2>, 6> kPairs = {{{0, 0}, {0, 1}, {0, 2}, {1, 1}, {1, 2}, {2, 2}}};

  Eigen::Vector3d F = Eigen::Vector3d::Zero();
  Eigen::Vector3d M = Eigen::Vector3d::Zero();
  double W = 0.0;
  Eigen::Vector3d m1 = Eigen::Vector3d::Zero();
  Eigen::Matrix3d m2 = Eigen::Matrix3d::Zero();
  double depth = 0.0;  // the largest e [m]; not differentiated

  bool active() const { return W > 0.0; }
};

// Derivatives of (F, M, W, m1, m2's six numbers) in a perturbation (rotation, translation) of B's place, seen in S.
using PatchJacobian = Eigen::Matrix<double, PatchIntegrals::kCount, 6>;

// Cotangents of them; m2's is symmetric, pairs as Σ m2(i, j) dm2(i, j).
struct PatchCotangent {
  Eigen::Vector3d F = Eigen::Vector3d::Zero();
  Eigen::Vector3d M = Eigen::Vector3d::Zero();
  double W = 0.0;
  Eigen::Vector3d m1 = Eigen::Vector3d::Zero();
  Eigen::Matrix3d m2 = Eigen::Matrix3d::Zero();

  PatchIntegrals::Vector Pack() const {
    PatchIntegrals::Vector out;
    out << F, M, W, m1, m2(0, 0), 2.0 * m2(0, 1), 2.0 * m2(0, 2), m2(1, 1), 2.0 * m2(1, 2), m2(2, 2);
    return out;
  }
  PatchCotangent& operator+=(const PatchCotangent& other) {
    F += other.F;
    M += other.M;
    W += other.W;
    m1 += other.m1;
    m2 += other.m2;
    return *this;
  }
};

inline Eigen::Matrix3d UnpackSymmetric(const Eigen::Matrix<double, 6, 1>& m) {
  return (Eigen::Matrix3d() << m(0), m(1), m(2), m(1), m(3), m(4), m(2), m(4), m(5)).finished();
}

// Adds to the rows of m2, for the k-th perturbation, a symmetric matrix.
inline void AddSymmetric(const Eigen::Matrix3d& m, int k, PatchJacobian* out) {
  for (int i = 0; i < 6; ++i) (*out)(10 + i, k) += m(PatchIntegrals::kPairs[i][0], PatchIntegrals::kPairs[i][1]);
}

}  // namespace knap
