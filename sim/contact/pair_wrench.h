// The wrench between two bodies, summed over points of contact, and its derivatives in both bodies' perturbations.
//
// F is the wrench on B (the points' body) about So in S, as a function of the relative motion alone: of the
// perturbation e of B's place (a spatial displacement in S) at fixed nu, and of nu, the twist of B relative to S. With
// Y the matrix of X_BS, which takes twists of B to S,
//
//   e = Y eta_B − eta_S,   dnu = Y dV_B − dV_S − crm(Y V_B) e,   dF = De e + Dnu dnu
//   F_B = Yᵀ F,  dF_B = Yᵀ (dF − CrossBar(F) e),                 F_S = −F,  dF_S = −dF
#pragma once

#include "sim/contact/point_side.h"
#include "sim/multibody/dynamics.h"

namespace knap {

// kSolve: all that the equations of motion need; kAll: also how wrenches hang on bodies that have no equations, so that
// cotangents reach their placement.
enum class ContactDerivatives { kSolve, kAll };

class PairWrench {
 public:
  PairWrench() = default;
  explicit PairWrench(const RelativeMotion& motion) : motion_(motion) {}

  // f on B at the place a in S, and a moment m on B.
  void AddForce(const Eigen::Vector3d& a, const Eigen::Vector3d& f, const Eigen::Vector3d& m) {
    F_.head<3>() += a.cross(f) + m;
    F_.tail<3>() += f;
    const double size = f.norm();
    moment_scale_S_ += size * a.norm();
    moment_scale_B_ += size * (a - motion_.X_SB.p).norm();
  }

  // With c the point's place, da_dc its contact's, df_dc at fixed nu and df_du:
  // e moves c by d + theta × c; nu moves u by v0 + w × a.
  void AddJacobian(const Eigen::Vector3d& c, const Eigen::Vector3d& a, const Eigen::Vector3d& f,
                   const Eigen::Matrix3d& da_dc, const Eigen::Matrix3d& df_dc, const Eigen::Matrix3d& df_du);
  // Of the moment alone: dm_dc at fixed nu, dm_du, and dm_dw.
  void AddMomentJacobian(const Eigen::Vector3d& c, const Eigen::Vector3d& a, const Eigen::Matrix3d& dm_dc,
                         const Eigen::Matrix3d& dm_du, const Eigen::Matrix3d& dm_dw);

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
