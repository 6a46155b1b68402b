// Grips: springs with damping between a point of one body and a point of another, that hold for a while.
//
// A on the body S that holds, P on the body B that is held, all in S; c the place of P, d = c − A, u the velocity of P
// as S sees it (S's own turning included, so that what stays put in S is not damped):
//
//   f = −k d / sqrt(1 + (k |d|/F)²) − damping u       on B at c;   −f on S at the same place
//
// F is the most that the spring pulls with: a stiff spring nearby, the tension F, whatever the distance, from afar.
// F = ∞: a linear spring. The grip acts at states with from < t ≤ until, those that steps within that time lead to.
#pragma once

#include <Eigen/Dense>
#include <limits>
#include <vector>

#include "sim/contact/pair_wrench.h"
#include "sim/multibody/dynamics.h"

namespace knap {

struct GripSpring {
  int holder = 0;                                          // S
  int held = 0;                                            // B, another body
  Eigen::Vector3d p_SA = Eigen::Vector3d::Zero();          // in S [m]
  Eigen::Vector3d p_BP = Eigen::Vector3d::Zero();          // in B [m]
  double stiffness = 0.0;                                  // k [N/m]
  double damping = 0.0;                                    // [N·s/m]
  double limit = std::numeric_limits<double>::infinity();  // F [N], > 0
  double from = 0.0;                                       // [s]
  double until = std::numeric_limits<double>::infinity();  // [s]

  bool ActsAt(double time) const { return time > from + kTimeRounding && time <= until + kTimeRounding; }
  // Of times that are multiples of a step [s], far less than the least substep.
  static constexpr double kTimeRounding = 1e-9;
};

struct GripForce {
  Eigen::Vector3d f;      // on B, in S [N]
  Eigen::Matrix3d df_dc;  // at given u; that in A is its negative
  double df_du = 0.0;     // times the identity
};
GripForce CalcGripForce(const GripSpring& grip, const Eigen::Vector3d& d, const Eigen::Vector3d& u);

// Cotangents of a grip's points, each in its own body [per m].
struct GripCotangent {
  Eigen::Vector3d p_SA = Eigen::Vector3d::Zero();
  Eigen::Vector3d p_BP = Eigen::Vector3d::Zero();
};

// All at the kinematics that the dynamics hold. The first two add to its wrenches and to their derivatives; the third,
// under Σ_i bar_wrench[i] · F_i, to *out, one a grip (the bodies' part is in the dynamics' own pull-back).
void AddGripWrenches(const std::vector<GripSpring>& grips, Dynamics* dynamics);
void AddGripDerivatives(const std::vector<GripSpring>& grips, ContactDerivatives derivatives, Dynamics* dynamics);
void PullBackGrips(const std::vector<GripSpring>& grips, const std::vector<Vector6d>& bar_wrench,
                   const Dynamics& dynamics, std::vector<GripCotangent>* out);

}  // namespace knap
