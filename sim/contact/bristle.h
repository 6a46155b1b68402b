// Friction's own state: a bristle, which bends with the slip and slides at its bound.
//
// With z its bend [m], s the slip velocity and z_s the bound,
//
//   dz/dt = s − beta(|z|/z_s) (s·ẑ)₊ ẑ        ẑ = z/|z|                        [elasto-plastic: Dupont et al. 2002]
//
// beta rises from 0 at 0.85 to 1 at 1, twice differentiable. Below 85% of the bound nothing slides, so that what rests
// keeps its bend and does not creep; where slip is steady |z| = z_s, whatever the step. One implicit step of length h
// from z0 has its solution along y = z0 + h s:
//
//   z = l ŷ,   l + h (s·ŷ)₊ beta(l/z_s) = |y|                                  one equation in l, monotone
#pragma once

#include <Eigen/Core>

namespace knap {

using Bristle = Eigen::Vector4d;  // three of a bend in space, one of a twist times its lever [m]

struct BristleStep {
  Bristle z;
  // Kept for the derivatives.
  Bristle y;
  double h = 0.0;
  double factor = 1.0;  // l/|y|
  double dl_dy = 1.0;   // of l in |y| and in the slip along ŷ, h (s·ŷ)₊
  double dl_dslip = 0.0;
  double slip = 0.0;  // s·ŷ
};

// h ≥ 0, bound > 0.
BristleStep CalcBristleStep(const Bristle& z0, const Bristle& s, double h, double bound);

// Cotangents of z0 and s, added.
void PullBackBristleStep(const BristleStep& step, const Bristle& s, const Bristle& bar_z, Bristle* bar_z0,
                         Bristle* bar_s);

}  // namespace knap
