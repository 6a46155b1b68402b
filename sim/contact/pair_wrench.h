// The wrench between two bodies and its derivatives in both bodies' perturbations.
//
// F is the wrench on B (of a contact the touching body, of a grip the held one) about So in S, as a function of
// the relative motion alone: of the
// perturbation e of B's place (a spatial displacement in S) at fixed nu, and of nu, the twist of B relative to S. With
// Y the matrix of X_BS, which takes twists of B to S,
//
//   e = Y eta_B − eta_S,   dnu = Y dV_B − dV_S − crm(Y V_B) e,   dF = De e + Dnu dnu
//   F_B = Yᵀ F,  dF_B = Yᵀ (dF − CrossBar(F) e),                 F_S = −F,  dF_S = −dF
#pragma once

#include "sim/math/pose.h"
#include "sim/multibody/dynamics.h"

namespace knap {

// kSolve: all that the equations of motion need; kAll: also how wrenches hang on bodies that have no equations, so that
// cotangents reach their placement.
enum class ContactDerivatives { kSolve, kAll };

// B's pose and twist as seen from S.
struct RelativeMotion {
  Pose X_SB;
  Vector6d V_B_S = Vector6d::Zero();  // twist of B, about So in S
  Vector6d nu = Vector6d::Zero();     // that less the twist of S
  Pose X_BS() const { return {X_SB.R.transpose(), -(X_SB.R.transpose() * X_SB.p)}; }
  static RelativeMotion Make(const Pose& X_WB, const Vector6d& V_B, const Pose& X_WS, const Vector6d& V_S);
};

class PairWrench {
 public:
  PairWrench() = default;
  explicit PairWrench(const RelativeMotion& motion) : motion_(motion) {}

  // A wrench on B about So; `size` bounds the forces that it sums [N], about the place `at` in S.
  void Add(const Vector6d& F, const Eigen::Vector3d& at, double size) {
    F_ += F;
    moment_scale_S_ += size * at.norm();
    moment_scale_B_ += size * (at - motion_.X_SB.p).norm();
  }
  // dF/de at fixed nu, and dF/dnu.
  void AddDerivatives(const Matrix6d& De, const Matrix6d& Dnu) {
    De_ += De;
    Dnu_ += Dnu;
  }

  const Vector6d& F() const { return F_; }

  const RelativeMotion& motion() const { return motion_; }

  // Adds to the wrenches on both bodies, those on bodies without equations left out.
  void AddTo(int B, int S, Dynamics* dynamics) const;
  // Likewise to their derivatives.
  void AddDerivativesTo(int B, int S, ContactDerivatives derivatives, Dynamics* dynamics) const;

 private:
  RelativeMotion motion_;
  Vector6d F_ = Vector6d::Zero();
  Matrix6d De_ = Matrix6d::Zero();
  Matrix6d Dnu_ = Matrix6d::Zero();
  double moment_scale_B_ = 0.0;  // sums of |force| × lever about Bo and So
  double moment_scale_S_ = 0.0;
};

}  // namespace knap
