#include "sim/multibody/dynamics.h"

#include <cmath>

namespace knap {

using Eigen::Vector3d;
using Eigen::VectorXd;

// dV-block of the body's own wrench: crf(V) M + CrossBar(M V) − dF_ext/dV.
Matrix6d Dynamics::CalcVelocityJacobian(int i) const {
  const Matrix6d& M = tree_->bodies()[i].M;
  const Vector6d& V = kinematics_[i].V;
  return CrossBarMatrix(M * V) - CrossMotionMatrix(V).transpose() * M - external_[i].dF_dV;
}

bool Dynamics::Factor(const VectorXd& xi, double c_v, double c_a) {
  for (int i = 0; i < tree_->size(); ++i) {
    if (!dynamic_[i]) continue;
    Matrix6x18& P = articulated_[i].P;
    P.leftCols<6>() = -external_[i].dF_deta;
    P.middleCols<6>(6) = CalcVelocityJacobian(i);
    P.rightCols<6>() = tree_->bodies()[i].M;
  }
  for (int i = tree_->size() - 1; i >= 0; --i) {
    if (!dynamic_[i]) continue;
    bool ok = true;
    switch (CountDof(tree_->bodies()[i].joint)) {
      case 0:
        ok = FactorJoint<0>(i, xi, c_v, c_a);
        break;
      case 1:
        ok = FactorJoint<1>(i, xi, c_v, c_a);
        break;
      default:
        ok = FactorJoint<3>(i, xi, c_v, c_a);
    }
    if (!ok) return false;
  }
  return FactorCoupling();
}

template <int n>
bool Dynamics::FactorJoint(int i, const VectorXd& xi, double c_v, double c_a) {
  const TreeBody& body = tree_->bodies()[i];
  const BodyKinematics& k = kinematics_[i];
  Articulated& a = articulated_[i];
  const bool has_dynamic_parent = body.parent >= 0 && dynamic_[body.parent];
  const auto P_eta = a.P.leftCols<6>();
  const auto P_V = a.P.middleCols<6>(6);
  const auto P_A = a.P.rightCols<6>();
  if (has_dynamic_parent) {
    const Matrix6d X = TwistMatrix(k.X_PB);
    a.PT.leftCols<6>().noalias() = P_eta * X;
    a.PT.middleCols<6>(6).noalias() = (P_V - P_A * CrossMotionMatrix(k.V_joint)) * X;
    a.PT.rightCols<6>().noalias() = P_A * X;
  }
  if constexpr (n > 0) {
    const Eigen::Matrix<double, 6, n> S = S_[i].leftCols<n>();
    Eigen::Matrix<double, 6, n> S_pose = S;  // S Jr
    if (body.joint == JointType::kBall) {
      if constexpr (n == 3) S_pose.template topRows<3>() = RightJacobianSo3(xi.segment<3>(body.v_start));
    }
    const Eigen::Matrix<double, 6, n> U_V = c_v * S + CrossMotionMatrix(k.V_carried) * S_pose;
    a.U.topLeftCorner<6, n>() = S_pose;
    a.U.block<6, n>(6, 0) = U_V;
    a.U.block<6, n>(12, 0) = c_a * S + CrossMotionMatrix(k.A_carried) * S_pose +
                             c_v * (CrossMotionMatrix(k.V) * S) - CrossMotionMatrix(k.V_joint) * U_V;
    const Eigen::Matrix<double, 6, n> PU = a.P * a.U.leftCols<n>();
    a.G.leftCols<n>() = PU + CrossBarMatrix(F_[i]) * S_pose;
    Eigen::Matrix<double, n, n> M = S.transpose() * PU;
    const JointForce& force = joint_forces_[i];
    M -= force.by_pose.template topLeftCorner<n, n>() * (S.transpose() * S_pose);
    M.diagonal() -= c_v * force.by_v.template head<n>();
    a.M_inverse.setZero();  // unused rows stay zero, so that it applies to padded 3-vectors
    if constexpr (n == 1) {
      if (!(std::abs(M(0, 0)) > 0.0) || !std::isfinite(M(0, 0))) return false;
      a.M_inverse(0, 0) = 1.0 / M(0, 0);
    } else {
      const double determinant = M.determinant();
      if (!(std::abs(determinant) > 0.0) || !std::isfinite(determinant)) return false;
      a.M_inverse = M.inverse();
    }
    if (has_dynamic_parent) {
      a.N.topRows<n>().noalias() =
          a.M_inverse.topLeftCorner<n, n>() * (S.transpose() * a.PT);
      a.PT.noalias() -= a.G.leftCols<n>() * a.N.topRows<n>();
    }
  }
  if (has_dynamic_parent) {
    articulated_[body.parent].P.noalias() += TwistMatrix(k.X_PB).transpose() * a.PT;
  }
  return true;
}

// T z_p: the perturbation that the parent's carries into body i.
Dynamics::Vector18d Dynamics::CarryPerturbation(int i, const Vector18d& z_parent) const {
  const BodyKinematics& k = kinematics_[i];
  Vector18d z;
  z.head<6>() = ShiftTwist(k.X_PB, z_parent.head<6>());
  z.segment<6>(6) = ShiftTwist(k.X_PB, z_parent.segment<6>(6));
  z.tail<6>() = ShiftTwist(k.X_PB, z_parent.tail<6>()) - CrossMotion(k.V_joint, z.segment<6>(6));
  return z;
}

// Tᵀ bar_z, added to the parent's.
void Dynamics::PullBackPerturbation(int i, const Vector18d& bar_z, Vector18d* bar_z_parent) const {
  const BodyKinematics& k = kinematics_[i];
  bar_z_parent->head<6>() += ShiftWrench(k.X_PB, bar_z.head<6>());
  bar_z_parent->segment<6>(6) +=
      ShiftWrench(k.X_PB, bar_z.segment<6>(6) + CrossForce(k.V_joint, bar_z.tail<6>()));
  bar_z_parent->tail<6>() += ShiftWrench(k.X_PB, bar_z.tail<6>());
}

void Dynamics::SolveTree(const VectorXd& rhs, VectorXd* x) {
  const int count = tree_->size();
  // Tips to root: with dF = P z + b and S^T dF = rhs, the joint's own part is y = M⁻¹ (rhs − Sᵀ b).
  for (int i = count - 1; i >= 0; --i) {
    if (!dynamic_[i]) continue;
    const TreeBody& body = tree_->bodies()[i];
    const Articulated& a = articulated_[i];
    const int n = CountDof(body.joint);
    Vector3d y = Vector3d::Zero();
    if (n > 0) {
      Vector3d e = Vector3d::Zero();
      for (int k = 0; k < n; ++k) e(k) = rhs(body.v_start + k) - S_[i].col(k).dot(b_[i]);
      y = a.M_inverse * e;
      for (int k = 0; k < n; ++k) (*x)(body.v_start + k) = y(k);
    }
    if (body.parent < 0 || !dynamic_[body.parent]) continue;
    Vector6d passed = b_[i];
    for (int k = 0; k < n; ++k) passed += a.G.col(k) * y(k);
    b_[body.parent] += ShiftWrench(kinematics_[i].X_PB, passed);
  }
  for (int i = 0; i < count; ++i) {
    if (!dynamic_[i]) continue;
    const TreeBody& body = tree_->bodies()[i];
    const Articulated& a = articulated_[i];
    const int n = CountDof(body.joint);
    z_[i].setZero();
    if (body.parent >= 0 && dynamic_[body.parent]) {
      z_[i] = CarryPerturbation(i, z_[body.parent]);
      for (int k = 0; k < n; ++k) (*x)(body.v_start + k) -= a.N.row(k).dot(z_[body.parent]);
    }
    for (int k = 0; k < n; ++k) z_[i] += a.U.col(k) * (*x)(body.v_start + k);
  }
}

void Dynamics::SolveTreeTransposed(const VectorXd& rhs, VectorXd* x) {
  // The two passes of SolveTree, transposed and in the opposite order. z_ and b_ hold the cotangents of z and b.
  const int count = tree_->size();
  for (int i = count - 1; i >= 0; --i) {
    if (!dynamic_[i]) continue;
    const TreeBody& body = tree_->bodies()[i];
    const Articulated& a = articulated_[i];
    const int n = CountDof(body.joint);
    // x holds the cotangent of y until the second pass.
    for (int k = 0; k < n; ++k) (*x)(body.v_start + k) = rhs(body.v_start + k) + a.U.col(k).dot(z_[i]);
    if (body.parent < 0 || !dynamic_[body.parent]) continue;
    PullBackPerturbation(i, z_[i], &z_[body.parent]);
    for (int k = 0; k < n; ++k) z_[body.parent] -= a.N.row(k).transpose() * (*x)(body.v_start + k);
  }
  for (int i = 0; i < count; ++i) {
    if (!dynamic_[i]) continue;
    const TreeBody& body = tree_->bodies()[i];
    const Articulated& a = articulated_[i];
    const int n = CountDof(body.joint);
    b_[i].setZero();
    Vector3d bar_y = Vector3d::Zero();
    for (int k = 0; k < n; ++k) bar_y(k) = (*x)(body.v_start + k);
    if (body.parent >= 0 && dynamic_[body.parent]) {
      b_[i] = ShiftTwist(kinematics_[i].X_PB, b_[body.parent]);
      for (int k = 0; k < n; ++k) bar_y(k) += a.G.col(k).dot(b_[i]);
    }
    if (n == 0) continue;
    const Vector3d bar_rhs = a.M_inverse.transpose() * bar_y;
    for (int k = 0; k < n; ++k) {
      (*x)(body.v_start + k) = bar_rhs(k);
      b_[i] -= S_[i].col(k) * bar_rhs(k);
    }
  }
}

bool Dynamics::FactorCoupling() {
  for (const int i : coupled_) slot_[i] = -1;
  coupled_.clear();
  for (const CrossWrench& c : cross_) {
    if (dynamic_[c.body] && dynamic_[c.other]) slot_[c.body] = 0;
  }
  for (int i = 0; i < tree_->size(); ++i) {
    if (slot_[i] < 0) continue;
    slot_[i] = static_cast<int>(coupled_.size());
    coupled_.push_back(i);
  }
  if (coupled_.empty()) return true;
  coupling_.Resize(6 * static_cast<int>(coupled_.size()));
  for (const int body : coupled_) {
    for (int k = 0; k < 6; ++k) {
      // A unit wrench on the body, k-th component: column of J_tree⁻¹ U.
      const int column = 6 * slot_[body] + k;
      for (Vector6d& b : b_) b.setZero();
      b_[body](k) = -1.0;
      SolveTree(zero_, &coupling_x_);
      CalcCoupling();
      for (std::size_t slot = 0; slot < coupled_.size(); ++slot) {
        for (int row = 0; row < 6; ++row) coupling_(6 * static_cast<int>(slot) + row, column) = -coupling_s_[slot](row);
      }
      coupling_(column, column) += 1.0;
    }
  }
  return coupling_.Factor();
}

// coupling_s_ = V z: what the perturbations of other bodies do to the wrench on each coupled one.
void Dynamics::CalcCoupling() {
  for (std::size_t slot = 0; slot < coupled_.size(); ++slot) coupling_s_[slot].setZero();
  for (const CrossWrench& c : cross_) {
    if (!dynamic_[c.body] || !dynamic_[c.other]) continue;
    coupling_s_[slot_[c.body]] += c.dF_deta * z_[c.other].head<6>() + c.dF_dV * z_[c.other].segment<6>(6);
  }
}

void Dynamics::Solve(const VectorXd& rhs, VectorXd* x) {
  for (Vector6d& b : b_) b.setZero();
  SolveTree(rhs, x);
  if (coupled_.empty()) return;
  CalcCoupling();
  coupling_.Solve(coupling_s_.data()->data());
  for (Vector6d& b : b_) b.setZero();
  for (const int body : coupled_) b_[body] = -coupling_s_[slot_[body]];
  SolveTree(rhs, x);
}

void Dynamics::SolveTransposed(const VectorXd& rhs, VectorXd* x) {
  for (Vector18d& z : z_) z.setZero();
  SolveTreeTransposed(rhs, x);
  if (coupled_.empty()) return;
  for (const int body : coupled_) coupling_s_[slot_[body]] = -b_[body];
  coupling_.SolveTransposed(coupling_s_.data()->data());
  for (Vector18d& z : z_) z.setZero();
  for (const CrossWrench& c : cross_) {
    if (!dynamic_[c.body] || !dynamic_[c.other]) continue;
    const Vector6d& t = coupling_s_[slot_[c.body]];
    z_[c.other].head<6>() += c.dF_deta.transpose() * t;
    z_[c.other].segment<6>(6) += c.dF_dV.transpose() * t;
  }
  SolveTreeTransposed(rhs, x);
}

}  // namespace knap
