#include "sim/contact/grip.h"

#include <cmath>

#include "sim/math/spatial.h"

namespace knap {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

// One grip as the dynamics' kinematics have it.
struct Held {
  RelativeMotion motion;
  Vector3d c;  // P in S
  Vector3d u;
  GripForce force;

  Held(const GripSpring& grip, const Dynamics& dynamics) {
    const BodyKinematics& B = dynamics.kinematics()[grip.held];
    const BodyKinematics& S = dynamics.kinematics()[grip.holder];
    motion = RelativeMotion::Make(B.X_WB, B.V, S.X_WB, S.V);
    c = motion.X_SB * grip.p_BP;
    u = motion.nu.tail<3>() + motion.nu.head<3>().cross(c);
    force = CalcGripForce(grip, c - grip.p_SA, u);
  }

  PairWrench MakeWrench() const {
    Vector6d F;
    F << c.cross(force.f), force.f;
    PairWrench wrench(motion);
    wrench.Add(F, c, force.f.norm());
    return wrench;
  }
};

}  // namespace

GripForce CalcGripForce(const GripSpring& grip, const Vector3d& d, const Vector3d& u) {
  const Vector3d pull = grip.stiffness * d;
  const double share2 = pull.squaredNorm() / (grip.limit * grip.limit);
  const double s = std::sqrt(1.0 + share2);
  GripForce out;
  out.f = -pull / s - grip.damping * u;
  const Vector3d direction = pull / (grip.limit * s);
  out.df_dc = -grip.stiffness / s * (Matrix3d::Identity() - direction * direction.transpose());
  out.df_du = -grip.damping;
  return out;
}

void AddGripWrenches(const std::vector<GripSpring>& grips, Dynamics* dynamics) {
  for (const GripSpring& grip : grips) {
    if (!grip.ActsAt(dynamics->time())) continue;
    const Held held(grip, *dynamics);
    held.MakeWrench().AddTo(grip.held, grip.holder, dynamics);
  }
}

void AddGripDerivatives(const std::vector<GripSpring>& grips, ContactDerivatives derivatives, Dynamics* dynamics) {
  for (const GripSpring& grip : grips) {
    if (!grip.ActsAt(dynamics->time())) continue;
    const Held held(grip, *dynamics);
    const Vector3d w = held.motion.nu.head<3>();
    // e moves c by d + theta × c, nu moves u by v0 + w × c; the moment is c × f.
    Eigen::Matrix<double, 3, 6> dc_de;
    dc_de << -Skew(held.c), Matrix3d::Identity();
    const Eigen::Matrix<double, 3, 6> df_de = (held.force.df_dc + held.force.df_du * Skew(w)) * dc_de;
    const Eigen::Matrix<double, 3, 6> df_dnu = held.force.df_du * dc_de;
    Matrix6d De;
    De << Skew(held.c) * df_de - Skew(held.force.f) * dc_de, df_de;
    Matrix6d Dnu;
    Dnu << Skew(held.c) * df_dnu, df_dnu;
    PairWrench wrench = held.MakeWrench();
    wrench.AddDerivatives(De, Dnu);
    wrench.AddDerivativesTo(grip.held, grip.holder, derivatives, dynamics);
  }
}

void PullBackGrips(const std::vector<GripSpring>& grips, const std::vector<Vector6d>& bar_wrench,
                   const Dynamics& dynamics, std::vector<GripCotangent>* out) {
  for (std::size_t i = 0; i < grips.size(); ++i) {
    const GripSpring& grip = grips[i];
    if (!grip.ActsAt(dynamics.time())) continue;
    const Held held(grip, dynamics);
    // The wrench on B about So is (c × f, f), that on S its negative.
    const Vector6d bar_F = ShiftTwist(held.motion.X_BS(), bar_wrench[grip.held]) - bar_wrench[grip.holder];
    const Vector3d bar_f = bar_F.tail<3>() + bar_F.head<3>().cross(held.c);
    const Vector3d by_place = held.force.df_dc.transpose() * bar_f;
    const Vector3d bar_u = held.force.df_du * bar_f;
    const Vector3d bar_c = by_place + bar_u.cross(held.motion.nu.head<3>()) + held.force.f.cross(bar_F.head<3>());
    (*out)[i].p_SA -= by_place;
    (*out)[i].p_BP += held.motion.X_SB.R.transpose() * bar_c;
  }
}

}  // namespace knap
