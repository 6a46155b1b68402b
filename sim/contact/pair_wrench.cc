#include "sim/contact/pair_wrench.h"

namespace knap {

using Eigen::Matrix3d;
using Eigen::Vector3d;

void PairWrench::AddJacobian(const Vector3d& c, const Vector3d& a, const Vector3d& f, const Matrix3d& da_dc,
                             const Matrix3d& df_dc, const Matrix3d& df_du) {
  const Matrix3d cross_c = Skew(c);
  const Matrix3d cross_a = Skew(a);
  const Matrix3d dM_dc = cross_a * df_dc - Skew(f) * da_dc;
  De_.bottomRightCorner<3, 3>() += df_dc;
  De_.bottomLeftCorner<3, 3>() -= df_dc * cross_c;
  De_.topRightCorner<3, 3>() += dM_dc;
  De_.topLeftCorner<3, 3>() -= dM_dc * cross_c;
  const Matrix3d df_dw = -df_du * cross_a;
  Dnu_.bottomRightCorner<3, 3>() += df_du;
  Dnu_.bottomLeftCorner<3, 3>() += df_dw;
  Dnu_.topRightCorner<3, 3>() += cross_a * df_du;
  Dnu_.topLeftCorner<3, 3>() += cross_a * df_dw;
}

void PairWrench::AddMomentJacobian(const Vector3d& c, const Vector3d& a, const Matrix3d& dm_dc, const Matrix3d& dm_du,
                                   const Matrix3d& dm_dw) {
  De_.topRightCorner<3, 3>() += dm_dc;
  De_.topLeftCorner<3, 3>() -= dm_dc * Skew(c);
  Dnu_.topRightCorner<3, 3>() += dm_du;
  Dnu_.topLeftCorner<3, 3>() += dm_dw - dm_du * Skew(a);
}

void PairWrench::AddTo(int B, int S, Dynamics* dynamics) const {
  if (dynamics->tree().IsDynamic(B)) {
    ExternalWrench& wrench = dynamics->external()[B];
    wrench.F += ShiftWrench(motion_.X_BS(), F_);
    wrench.moment_scale += moment_scale_B_;
  }
  if (dynamics->tree().IsDynamic(S)) {
    ExternalWrench& wrench = dynamics->external()[S];
    wrench.F -= F_;
    wrench.moment_scale += moment_scale_S_;
  }
}

void PairWrench::AddDerivativesTo(int B, int S, ContactDerivatives derivatives, Dynamics* dynamics) const {
  const bool moves_B = dynamics->tree().IsDynamic(B);
  const bool moves_S = dynamics->tree().IsDynamic(S);
  const Pose X_BS = motion_.X_BS();
  const Matrix6d Y = TwistMatrix(X_BS);
  const Matrix6d G = De_ - Dnu_ * CrossMotionMatrix(motion_.V_B_S);
  const Matrix6d H = G - CrossBarMatrix(F_);
  if (moves_B) {
    ExternalWrench& wrench = dynamics->external()[B];
    wrench.dF_deta.noalias() += Y.transpose() * (H * Y);
    wrench.dF_dV.noalias() += Y.transpose() * (Dnu_ * Y);
  }
  if (moves_S) {
    ExternalWrench& wrench = dynamics->external()[S];
    wrench.dF_deta += G;
    wrench.dF_dV += Dnu_;
  }
  const bool all = derivatives == ContactDerivatives::kAll;
  if (moves_B && (moves_S || all)) {
    CrossWrench on_B;
    on_B.body = B;
    on_B.other = S;
    on_B.dF_deta.noalias() = -Y.transpose() * H;
    on_B.dF_dV.noalias() = -Y.transpose() * Dnu_;
    dynamics->cross().push_back(on_B);
  }
  if (moves_S && (moves_B || all)) {
    CrossWrench on_S;
    on_S.body = S;
    on_S.other = B;
    on_S.dF_deta.noalias() = -G * Y;
    on_S.dF_dV.noalias() = -Dnu_ * Y;
    dynamics->cross().push_back(on_S);
  }
}

}  // namespace knap
