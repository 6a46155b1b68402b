// The two implicit formulas, with displacements instead of positions so that they hold on rotations too.
//
//   xi_{k+1} = alpha xi_k + beta h v_{k+1},          q_{k+1} = q_k ⊕ xi_{k+1}
//   vdot_{k+1} = (gamma0 v_{k+1} + gamma1 v_k + gamma2 v_{k-1}) / h
//
//   BDF1: alpha 0,   beta 1,   gamma (1, −1, 0)          order 1
//   BDF2: alpha 1/3, beta 2/3, gamma (3/2, −2, 1/2)      order 2 [Hairer & Wanner 1996, §V.1]
//
// BDF2 needs two equal steps behind it; a first step by BDF1 costs one local error of order h² and keeps the order.
#pragma once

namespace knap {

struct BdfCoefficients {
  double h = 0.0;
  double alpha = 0.0;
  double c_v = 0.0;  // dv/dxi = 1/(beta h) [1/s]
  double g0 = 0.0;   // gamma0/h and so on [1/s]
  double g1 = 0.0;
  double g2 = 0.0;

  static BdfCoefficients Bdf1(double h) { return {h, 0.0, 1.0 / h, 1.0 / h, -1.0 / h, 0.0}; }
  static BdfCoefficients Bdf2(double h) { return {h, 1.0 / 3.0, 1.5 / h, 1.5 / h, -2.0 / h, 0.5 / h}; }
};

}  // namespace knap
