// The implicit formulas that lead from one state to the next, with displacements instead of positions so that they hold
// on rotations too. One form covers them all:
//
//   q_k    = q_{k−1} ⊕ xi_k,   xi_k = alpha xi_{k−1} + e v_{k−1} + v_k / c_v
//   vdot_k = g0 v_k + g1 v_{k−1} + g2 v_{k−2} + g_a vdot_{k−1}
//   z_k    = z(base, h_contact, motion),   base = z_{k−1} + zeta (z_{k−1} − z_{k−2}) + e zdot_{k−1}
//   zdot_k = (z_k − base) / h_contact
//
// z are the bristles of contacts, which the contacts advance themselves (bristle_history.h). With h the step:
//
//   BDF1          alpha 0,    c_v 1/h,       gamma (1, −1, 0)/h                                              order 1
//   BDF2          alpha 1/3,  c_v 3/(2h),    gamma (3/2, −2, 1/2)/h; needs an equal step behind it           order 2
//   TR-BDF2       two solves with the same c_v = 1/(d h), gamma = 2 − √2, d = gamma/2 [Bank et al. 1985]:    order 2
//     to t + gamma h   trapezoidal:  e = d h,  vdot_k = (v_k − v_{k−1})/(d h) − vdot_{k−1}
//     to t + h         BDF2 with the ratio 1/√2 of its steps
//
// Bristles take BDF1 beside BDF2 of equal steps, and TR-BDF2 beside TR-BDF2. Rotations are of order 2 in all of them:
// the increments of a step do not commute, which shows in its third order.
#pragma once

#include <numbers>

namespace knap {

struct StepFormula {
  double h = 0.0;     // from the previous state [s]
  double step = 0.0;  // of the step that this solve is a part of, h but for TR-BDF2: all below are its powers [s]
  double alpha = 0.0;
  double e = 0.0;    // [s]
  double c_v = 0.0;  // dv/dxi [1/s]
  double g0 = 0.0;   // [1/s]
  double g1 = 0.0;
  double g2 = 0.0;
  double g_a = 0.0;
  double zeta = 0.0;
  double h_contact = 0.0;  // [s]
  bool is_stage = false;   // leads to a state within a step, which is no node of the time grid

  static constexpr double kGamma = 2.0 - std::numbers::sqrt2;
  static constexpr double kDiagonal = 0.5 * kGamma;              // d
  static constexpr double kWeight = 0.25 * std::numbers::sqrt2;  // w of the first two slopes; that of the third is d

  static StepFormula Bdf1(double h) {
    StepFormula f;
    f.h = f.step = f.h_contact = h;
    f.c_v = f.g0 = 1.0 / h;
    f.g1 = -1.0 / h;
    return f;
  }
  static StepFormula Bdf2(double h) {
    StepFormula f;
    f.h = f.step = f.h_contact = h;
    f.alpha = 1.0 / 3.0;
    f.c_v = f.g0 = 1.5 / h;
    f.g1 = -2.0 / h;
    f.g2 = 0.5 / h;
    return f;
  }
  static StepFormula TrapezoidalStage(double step) {
    StepFormula f;
    f.h = kGamma * step;
    f.step = step;
    f.e = f.h_contact = kDiagonal * step;
    f.c_v = f.g0 = 1.0 / f.e;
    f.g1 = -f.g0;
    f.g_a = -1.0;
    f.is_stage = true;
    return f;
  }
  static StepFormula BdfStage(double step) {
    StepFormula f;
    f.h = (1.0 - kGamma) * step;
    f.step = step;
    f.h_contact = kDiagonal * step;
    f.alpha = f.zeta = kWeight / kDiagonal - 1.0;
    f.c_v = f.g0 = 1.0 / f.h_contact;
    f.g1 = -(kWeight / kDiagonal) * f.g0;
    f.g2 = f.alpha * f.g0;
    return f;
  }
};

}  // namespace knap
