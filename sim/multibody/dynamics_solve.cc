#include <cmath>

#include "sim/math/spatial.h"
#include "sim/multibody/dynamics.h"

namespace knap {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

// The body's own part of P, and its pose, in R.
//
// With mass m, first moment h and inertia I about R's origin, twist (w, v), momentum (L, p), and dA = w' − crm(V) dV
// for the third part w' of z, the gyroscopic terms crf(V) M + CrossBar(M V) − M crm(V) gather to
//
//   [w× I − I w× − L× − v hᵀ − h vᵀ + 2 (v·h) 1,   0;   −2 p×,   0]
void Dynamics::StartArticulated(int i) {
  const BodyKinematics& k = kinematics_[i];
  Articulated& a = articulated_[i];
  a.X_RB = {k.X_WB.R, k.X_WB.p - kinematics_[root_[i]].X_WB.p};
  const Matrix3d& R = a.X_RB.R;
  const Vector3d& x = a.X_RB.p;
  const Matrix6d& M = tree_->bodies()[i].M;
  const double m = M(3, 3);
  const Vector3d h_turned = R * Vector3d(M(2, 4), M(0, 5), M(1, 3));
  const Vector3d h = h_turned + m * x;
  Matrix3d I = R * M.topLeftCorner<3, 3>() * R.transpose();
  I -= x * h.transpose() + h_turned * x.transpose();
  I.diagonal().array() += x.dot(h + h_turned);
  const Vector6d V = ShiftTwistBack(a.X_RB, k.V);
  const Vector3d w = V.head<3>();
  const Vector3d v = V.tail<3>();
  const Vector3d p = m * v + w.cross(h);
  const Vector3d L = I * w + h.cross(v);

  // Rows of Pᵀ: the pose, the twist, and the third part of z; columns: the moment and the force.
  a.Pt.topRows<9>().setZero();
  Matrix3d turning = Skew(w) * I;
  turning -= Skew(L) + v * h.transpose() + h * v.transpose();
  turning -= I * Skew(w);
  turning.diagonal().array() += 2.0 * v.dot(h);
  a.Pt.block<3, 3>(6, 0) = turning.transpose();
  a.Pt.block<3, 3>(6, 3) = 2.0 * Skew(p);
  a.Pt.middleRows<3>(9).setZero();
  a.Pt.block<3, 3>(12, 0) = I.transpose();
  a.Pt.block<3, 3>(15, 0) = -Skew(h);
  a.Pt.block<3, 3>(12, 3) = Skew(h);
  a.Pt.block<3, 3>(15, 3) = m * Matrix3d::Identity();
  const ExternalWrench& external = external_[i];
  if ((external.dF_deta.array() != 0.0).any() || (external.dF_dV.array() != 0.0).any()) {
    const Matrix6d X = TwistMatrix(a.X_RB);
    a.Pt.topRows<6>() -= X.transpose() * external.dF_deta.transpose() * X;
    a.Pt.middleRows<6>(6) -= X.transpose() * external.dF_dV.transpose() * X;
  }
}

bool Dynamics::Factor(const VectorXd& xi, double c_v, double c_a) {
  for (int i = 0; i < tree_->size(); ++i) {
    if (dynamic_[i]) StartArticulated(i);
  }
  for (int i = tree_->size() - 1; i >= 0; --i) {
    if (!dynamic_[i]) continue;
    bool ok = true;
    if (dof_[i] == 1) ok = FactorJoint<1>(i, xi, c_v, c_a);
    if (dof_[i] == 3) ok = FactorJoint<3>(i, xi, c_v, c_a);
    if (!ok) return false;
    if (i != root_[i]) articulated_[tree_->bodies()[i].parent].Pt += articulated_[i].Pt;
  }
  return FactorCoupling();
}

// Eliminates the joint's increment from dF = P z_i, z_i = z_p + U dxi, where what reaches the parent is dF plus the
// turning of F with the joint: P becomes P − G N, N = M⁻¹ Sᵀ P, to be applied to z_p.
template <int n>
bool Dynamics::FactorJoint(int i, const VectorXd& xi, double c_v, double c_a) {
  using Matrix6xn = Eigen::Matrix<double, 6, n>;
  const TreeBody& body = tree_->bodies()[i];
  const BodyKinematics& k = kinematics_[i];
  Articulated& a = articulated_[i];
  Matrix6xn S_B_pose = S_[i].leftCols<n>();  // S Jr
  Eigen::Matrix<double, n, n> Jr = Eigen::Matrix<double, n, n>::Identity();
  if constexpr (n == 3) {
    if (body.joint == JointType::kBall) {
      Jr = RightJacobianSo3(xi.segment<3>(body.v_start));
      S_B_pose.template topRows<3>() = Jr;
    }
  }
  const Vector6d V = ShiftTwistBack(a.X_RB, k.V);
  const Vector6d V_carried = ShiftTwistBack(a.X_RB, k.V_carried);
  const Vector6d A_carried = ShiftTwistBack(a.X_RB, k.A_carried);
  const Vector6d F = ShiftWrench(a.X_RB, F_[i]);
  Matrix6xn turned;
  for (int c = 0; c < n; ++c) {
    a.S.col(c) = ShiftTwistBack(a.X_RB, S_[i].col(c));
    const Vector6d S = a.S.col(c);
    const Vector6d S_pose = n == 3 ? ShiftTwistBack(a.X_RB, S_B_pose.col(c)) : S;
    const Vector6d U_V = c_v * S + CrossMotion(V_carried, S_pose);
    a.U.template block<6, 1>(0, c) = S_pose;
    a.U.template block<6, 1>(6, c) = U_V;
    a.U.template block<6, 1>(12, c) =
        c_a * S + CrossMotion(A_carried, S_pose) + c_v * CrossMotion(V, S) + CrossMotion(V_carried, U_V);
    turned.col(c) = CrossForce(S_pose, F);
  }
  const Matrix6xn S = a.S.template leftCols<n>();
  const Matrix6xn PU = a.Pt.transpose().lazyProduct(a.U.template leftCols<n>());
  Eigen::Matrix<double, n, n> M = S.transpose() * PU;
  const JointForce& force = joint_forces_[i];
  M -= force.by_pose.template topLeftCorner<n, n>() * Jr;
  M.diagonal() -= c_v * force.by_v.template head<n>();
  if constexpr (n == 1) {
    if (!(std::abs(M(0, 0)) > 0.0) || !std::isfinite(M(0, 0))) return false;
    a.M_inverse(0, 0) = 1.0 / M(0, 0);
  } else {
    const double determinant = M.determinant();
    if (!(std::abs(determinant) > 0.0) || !std::isfinite(determinant)) return false;
    a.M_inverse = M.inverse();
  }
  if (i == root_[i]) return true;
  a.G.template leftCols<n>() = PU + turned;
  // Products as they stand: Eigen's general one, for large matrices, costs several times as much here.
  const Eigen::Matrix<double, 18, n> SPt = a.Pt.lazyProduct(S);
  const Eigen::Matrix<double, n, n> M_inverse_t = a.M_inverse.template topLeftCorner<n, n>().transpose();
  a.Nt.template leftCols<n>() = SPt.lazyProduct(M_inverse_t);
  a.Pt -= a.Nt.template leftCols<n>().lazyProduct(a.G.template leftCols<n>().transpose());
  return true;
}

void Dynamics::SolveTree(const VectorXd& rhs, VectorXd* x) {
  const int count = tree_->size();
  // Tips to root: with dF = P z + b and Sᵀ dF = rhs, the joint's own part is y = M⁻¹ (rhs − Sᵀ b).
  for (int i = count - 1; i >= 0; --i) {
    if (!dynamic_[i]) continue;
    const TreeBody& body = tree_->bodies()[i];
    const Articulated& a = articulated_[i];
    Vector3d y = Vector3d::Zero();
    if (dof_[i] > 0) {
      Vector3d e = Vector3d::Zero();
      for (int k = 0; k < dof_[i]; ++k) e(k) = rhs(body.v_start + k) - a.S.col(k).dot(b_[i]);
      y = a.M_inverse * e;
      for (int k = 0; k < dof_[i]; ++k) (*x)(body.v_start + k) = y(k);
    }
    if (i == root_[i]) continue;
    Vector6d& b = b_[body.parent];
    b += b_[i];
    for (int k = 0; k < dof_[i]; ++k) b += a.G.col(k) * y(k);
  }
  for (int i = 0; i < count; ++i) {
    if (!dynamic_[i]) continue;
    const TreeBody& body = tree_->bodies()[i];
    const Articulated& a = articulated_[i];
    if (i == root_[i]) {
      z_[i].setZero();
    } else {
      z_[i] = z_[body.parent];
      for (int k = 0; k < dof_[i]; ++k) (*x)(body.v_start + k) -= a.Nt.col(k).dot(z_[body.parent]);
    }
    for (int k = 0; k < dof_[i]; ++k) z_[i] += a.U.col(k) * (*x)(body.v_start + k);
  }
}

void Dynamics::SolveTreeTransposed(const VectorXd& rhs, VectorXd* x) {
  // The two passes of SolveTree, transposed and in the opposite order. z_ and b_ hold the cotangents of z and b.
  const int count = tree_->size();
  for (int i = count - 1; i >= 0; --i) {
    if (!dynamic_[i]) continue;
    const TreeBody& body = tree_->bodies()[i];
    const Articulated& a = articulated_[i];
    // x holds the cotangent of y until the second pass.
    for (int k = 0; k < dof_[i]; ++k) (*x)(body.v_start + k) = rhs(body.v_start + k) + a.U.col(k).dot(z_[i]);
    if (i == root_[i]) continue;
    Vector18d& z = z_[body.parent];
    z += z_[i];
    for (int k = 0; k < dof_[i]; ++k) z -= a.Nt.col(k) * (*x)(body.v_start + k);
  }
  for (int i = 0; i < count; ++i) {
    if (!dynamic_[i]) continue;
    const TreeBody& body = tree_->bodies()[i];
    const Articulated& a = articulated_[i];
    b_[i].setZero();
    if (i != root_[i]) b_[i] = b_[body.parent];
    if (dof_[i] == 0) continue;
    Vector3d bar_y = Vector3d::Zero();
    for (int k = 0; k < dof_[i]; ++k) {
      bar_y(k) = (*x)(body.v_start + k);
      if (i != root_[i]) bar_y(k) += a.G.col(k).dot(b_[i]);
    }
    const Vector3d bar_rhs = a.M_inverse.transpose() * bar_y;
    for (int k = 0; k < dof_[i]; ++k) {
      (*x)(body.v_start + k) = bar_rhs(k);
      b_[i] -= a.S.col(k) * bar_rhs(k);
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
    const Pose& X_RO = articulated_[c.other].X_RB;
    const Vector6d F =
        c.dF_deta * ShiftTwist(X_RO, z_[c.other].head<6>()) + c.dF_dV * ShiftTwist(X_RO, z_[c.other].segment<6>(6));
    coupling_s_[slot_[c.body]] += ShiftWrench(articulated_[c.body].X_RB, F);
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
    const Vector6d t = ShiftTwist(articulated_[c.body].X_RB, coupling_s_[slot_[c.body]]);
    const Pose& X_RO = articulated_[c.other].X_RB;
    z_[c.other].head<6>() += ShiftWrench(X_RO, c.dF_deta.transpose() * t);
    z_[c.other].segment<6>(6) += ShiftWrench(X_RO, c.dF_dV.transpose() * t);
  }
  SolveTreeTransposed(rhs, x);
}

}  // namespace knap
