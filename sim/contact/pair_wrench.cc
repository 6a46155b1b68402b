#include "sim/contact/pair_wrench.h"

#include "sim/math/spatial.h"

namespace knap {

RelativeMotion RelativeMotion::Make(const Pose& X_WB, const Vector6d& V_B, const Pose& X_WS, const Vector6d& V_S) {
  RelativeMotion out;
  out.X_SB.R = X_WS.R.transpose() * X_WB.R;
  out.X_SB.p = X_WS.ApplyInverse(X_WB.p);
  out.V_B_S.head<3>() = out.X_SB.R * V_B.head<3>();
  out.V_B_S.tail<3>() = out.X_SB.R * V_B.tail<3>() + out.X_SB.p.cross(out.V_B_S.head<3>());
  out.nu = out.V_B_S - V_S;
  return out;
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
