#include "sim/math/spatial.h"
#include "sim/multibody/dynamics.h"

namespace knap {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

void Dynamics::PullBackResidual(const VectorXd& lambda, JointCotangents* out, ParameterCotangents* parameters) {
  for (int i = 0; i < tree_->size(); ++i) {
    W_[i].setZero();
    bars_[i] = BodyCotangent{};
    if (!dynamic_[i]) continue;
    const TreeBody& body = tree_->bodies()[i];
    if (body.parent >= 0 && dynamic_[body.parent]) W_[i] = ShiftTwist(kinematics_[i].X_PB, W_[body.parent]);
    for (int k = 0; k < dof_[i]; ++k) W_[i] += S_[i].col(k) * lambda(body.v_start + k);
    bars_[i].eta = -external_[i].dF_deta.transpose() * W_[i];
    // M A + crf(V) M V − f_ext, transposed.
    const Vector6d& V = kinematics_[i].V;
    bars_[i].V = -CrossForce(W_[i], body.M * V) - body.M * CrossMotion(V, W_[i]);
    bars_[i].V -= external_[i].dF_dV.transpose() * W_[i];
    bars_[i].A = body.M * W_[i];
    if (parameters != nullptr) PullBackInertia(i, &parameters->bodies[i]);
  }
  for (const CrossWrench& c : cross_) {
    if (!dynamic_[c.body]) continue;
    bars_[c.other].eta -= c.dF_deta.transpose() * W_[c.body];
    bars_[c.other].V -= c.dF_dV.transpose() * W_[c.body];
  }
  PullBackTree(&lambda, &bars_, out, parameters);
  PullBackJointForces(lambda, out, parameters);
}

void Dynamics::PullBackKinematics(std::vector<BodyCotangent>* bodies, JointCotangents* out,
                                  ParameterCotangents* parameters) const {
  PullBackTree(nullptr, bodies, out, parameters);
}

// Wᵀ (M A + crf(V) M V) in M: the matrix W Aᵀ − (crm(V) W) Vᵀ, on the ten numbers that M is made of.
void Dynamics::PullBackInertia(int i, BodyParameterCotangent* out) const {
  const Vector6d& V = kinematics_[i].V;
  const Vector6d& A = kinematics_[i].A;
  const Vector6d& W = W_[i];
  const Vector6d Y = -CrossMotion(V, W);
  const auto w = [](const Vector6d& twist) { return twist.head<3>(); };
  const auto v = [](const Vector6d& twist) { return twist.tail<3>(); };
  // xᵀ M y = w_xᵀ I w_y + h·(v_y × w_x) + h·(v_x × w_y) + m v_x·v_y, with first moment h.
  out->mass += v(W).dot(v(A)) + v(Y).dot(v(V));
  out->first_moment += v(A).cross(w(W)) + v(W).cross(w(A)) + v(V).cross(w(Y)) + v(Y).cross(w(V));
  const Matrix3d half = 0.5 * (w(W) * w(A).transpose() + w(Y) * w(V).transpose());
  out->inertia += half + half.transpose();
}

void Dynamics::PullBackTree(const VectorXd* lambda, std::vector<BodyCotangent>* bodies, JointCotangents* out,
                            ParameterCotangents* parameters) const {
  for (int i = tree_->size() - 1; i >= 0; --i) {
    // Where nothing moves freely only the parameters are of interest.
    if (!dynamic_[i] && parameters == nullptr) continue;
    const TreeBody& body = tree_->bodies()[i];
    const BodyKinematics& kin = kinematics_[i];
    BodyCotangent& bar = (*bodies)[i];
    const Vector6d bar_V = bar.V + CrossForce(kin.V_joint, bar.A);  // dA_i also falls with −crm(V_joint) dV_i
    const Vector6d bar_rate = bar_V - CrossForce(kin.V, bar.A);     // of V_joint
    // Of a displacement of B against its parent, in B: it also changes how the parent's motion is seen.
    Vector6d bar_shift = bar.eta - CrossForce(kin.V_carried, bar_V) - CrossForce(kin.A_carried, bar.A);
    if (lambda != nullptr && body.parent >= 0 && dynamic_[body.parent]) {
      // It also turns the subtree's wrench that the joint passes to the parent.
      bar_shift -= CrossForce(ShiftTwist(kin.X_PB, W_[body.parent]), F_[i]);
    }
    for (int k = 0; k < dof_[i]; ++k) {
      const int row = body.v_start + k;
      out->pose(row) = S_[i].col(k).dot(bar_shift);
      out->v(row) = S_[i].col(k).dot(bar_rate);
      out->vdot(row) = S_[i].col(k).dot(bar.A);
    }
    if (parameters != nullptr) {
      if (body.joint == JointType::kPrescribed) {
        const PrescribedState& state = prescribed_[i];
        parameters->time += bar_shift.dot(state.V) + bar_rate.dot(state.A) + bar.A.dot(state.jerk);
      }
      BodyParameterCotangent& p = parameters->bodies[i];
      p.placement += ShiftWrench(kin.X_FB, bar_shift);
      if (dof_[i] == 1) {
        const bool turns = body.joint == JointType::kRevolute;
        const double q = q_(body.q_start);
        const auto part = [turns](const Vector6d& f) { return turns ? f.head<3>() : f.tail<3>(); };
        Vector3d bar_axis = v_(body.v_start) * part(bar_rate) + vdot_(body.v_start) * part(bar.A);
        // Exp(q (axis + d)) = Exp(q axis) Exp(Jr(q axis) q d).
        if (turns) {
          bar_axis += q * (RightJacobianSo3(q * body.axis).transpose() * part(bar_shift));
        } else {
          bar_axis += q * part(bar_shift);
        }
        if (lambda != nullptr) bar_axis += (*lambda)(body.v_start) * part(F_[i]);
        p.axis += bar_axis - body.axis * body.axis.dot(bar_axis);
      }
    }
    if (body.parent < 0) {
      // The world's acceleration is −gravity.
      if (parameters != nullptr) parameters->gravity -= kin.X_PB.R * bar.A.tail<3>();
      continue;
    }
    BodyCotangent& parent = (*bodies)[body.parent];
    parent.eta += ShiftWrench(kin.X_PB, bar.eta);
    parent.V += ShiftWrench(kin.X_PB, bar_V);
    parent.A += ShiftWrench(kin.X_PB, bar.A);
  }
}

void Dynamics::PullBackJointForces(const VectorXd& lambda, JointCotangents* out,
                                   ParameterCotangents* parameters) const {
  for (int i = 0; i < tree_->size(); ++i) {
    const TreeBody& body = tree_->bodies()[i];
    const int n = dof_[i];
    if (n == 0) continue;
    Vector3d bar_tau = Vector3d::Zero();
    for (int k = 0; k < n; ++k) bar_tau(k) = -lambda(body.v_start + k);
    const JointForce& force = joint_forces_[i];
    const Vector3d bar_pose = force.by_pose.transpose() * bar_tau;
    for (int k = 0; k < n; ++k) {
      out->pose(body.v_start + k) += bar_pose(k);
      out->v(body.v_start + k) += force.by_v(k) * bar_tau(k);
    }
    if (parameters == nullptr) continue;
    const double* q = q_.data() + body.q_start;
    const double* v = v_.data() + body.v_start;
    if (body.joint == JointType::kBall) {
      PullBackBallLaw(body.law, q, v, bar_tau.data(), &parameters->bodies[i].law);
    } else {
      PullBackLaw(body.law, n, q, v, bar_tau.data(), &parameters->bodies[i].law);
    }
  }
  if (parameters == nullptr) return;
  for (int a = 0; a < tree_->num_controls(); ++a) {
    const Actuator& actuator = tree_->actuators()[a];
    const int row = tree_->bodies()[actuator.body].v_start + actuator.dof;
    parameters->controls(a) -= by_control_(a) * lambda(row);
  }
}

}  // namespace knap
