#include "sim/multibody/dynamics.h"

#include "sim/math/check.h"
#include "sim/math/spatial.h"

namespace knap {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

Dynamics::Dynamics(const Tree& tree) : tree_(&tree) {
  const int n = tree.size();
  prescribed_.resize(n);
  kinematics_.resize(n);
  external_.resize(n);
  F_.resize(n);
  F_magnitude_.resize(n);
  articulated_.resize(n);
  b_.resize(n);
  z_.resize(n);
  W_.resize(n);
  bars_.resize(n);
  S_.resize(n);
  dynamic_.resize(n);
  dof_.resize(n);
  root_.assign(n, -1);
  slot_.assign(n, -1);
  coupled_.reserve(n);
  coupling_s_.resize(n);
  coupling_x_.setZero(tree.nv());
  joint_forces_.resize(n);
  controls_.setZero(tree.num_controls());
  by_control_.setZero(tree.num_controls());
  zero_.setZero(tree.nv());
  for (int i = 0; i < n; ++i) {
    const TreeBody& body = tree.bodies()[i];
    dynamic_[i] = tree.IsDynamic(i);
    dof_[i] = CountDof(body.joint);
    if (dynamic_[i]) root_[i] = body.parent >= 0 && dynamic_[body.parent] ? root_[body.parent] : i;
    S_[i].setZero();
    articulated_[i].M_inverse.setZero();
    switch (body.joint) {
      case JointType::kRevolute:
        S_[i].col(0).head<3>() = body.axis;
        break;
      case JointType::kPrismatic:
        S_[i].col(0).tail<3>() = body.axis;
        break;
      case JointType::kTranslation:
        S_[i].bottomRows<3>().setIdentity();
        break;
      case JointType::kBall:
        S_[i].topRows<3>().setIdentity();
        break;
      case JointType::kFixed:
      case JointType::kPrescribed:
        break;
    }
  }
}

void Dynamics::CalcKinematics(const VectorXd& q, const VectorXd& v, const VectorXd& vdot, double time) {
  Vector6d A_world = Vector6d::Zero();
  A_world.tail<3>() = -tree_->gravity;
  cross_.clear();
  q_ = q;
  v_ = v;
  vdot_ = vdot;
  for (int i = 0; i < tree_->size(); ++i) {
    const TreeBody& body = tree_->bodies()[i];
    BodyKinematics& k = kinematics_[i];
    Vector6d A_joint = Vector6d::Zero();
    Pose& X_FB = k.X_FB;
    X_FB = Pose{};
    k.V_joint.setZero();
    switch (body.joint) {
      case JointType::kFixed:
        break;
      case JointType::kPrescribed: {
        PrescribedState& state = prescribed_[i];
        if (time != prescribed_time_) state = body.motion(time);
        X_FB = state.X_FB;
        k.V_joint = state.V;
        A_joint = state.A;
        break;
      }
      case JointType::kRevolute:
        X_FB.R = Eigen::AngleAxisd(q(body.q_start), body.axis).toRotationMatrix();
        k.V_joint.head<3>() = body.axis * v(body.v_start);
        A_joint.head<3>() = body.axis * vdot(body.v_start);
        break;
      case JointType::kPrismatic:
        X_FB.p = body.axis * q(body.q_start);
        k.V_joint.tail<3>() = body.axis * v(body.v_start);
        A_joint.tail<3>() = body.axis * vdot(body.v_start);
        break;
      case JointType::kTranslation:
        X_FB.p = q.segment<3>(body.q_start);
        k.V_joint.tail<3>() = v.segment<3>(body.v_start);
        A_joint.tail<3>() = vdot.segment<3>(body.v_start);
        break;
      case JointType::kBall:
        X_FB.R = Eigen::Quaterniond(q.segment<4>(body.q_start)).toRotationMatrix();
        k.V_joint.head<3>() = v.segment<3>(body.v_start);
        A_joint.head<3>() = vdot.segment<3>(body.v_start);
        break;
    }
    k.X_PB = body.X_PF * X_FB;
    if (body.parent < 0) {
      k.X_WB = k.X_PB;
      k.V_carried.setZero();
      k.A_carried = ShiftTwist(k.X_PB, A_world);
    } else {
      const BodyKinematics& parent = kinematics_[body.parent];
      k.X_WB = parent.X_WB * k.X_PB;
      k.V_carried = ShiftTwist(k.X_PB, parent.V);
      k.A_carried = ShiftTwist(k.X_PB, parent.A);
    }
    k.V = k.V_carried + k.V_joint;
    k.A = k.A_carried + A_joint + CrossMotion(k.V, k.V_joint);
    external_[i].F.setZero();
    external_[i].moment_scale = 0.0;
    external_[i].dF_deta.setZero();
    external_[i].dF_dV.setZero();
  }
  prescribed_time_ = time;
  CalcJointForces();
}

void Dynamics::CalcJointForces() {
  for (int i = 0; i < tree_->size(); ++i) {
    const TreeBody& body = tree_->bodies()[i];
    const int n = dof_[i];
    if (n == 0) continue;
    const double* q = q_.data() + body.q_start;
    const double* v = v_.data() + body.v_start;
    JointForce& force = joint_forces_[i];
    force = JointForce{};
    AddDamping(body.law, n, v, &force);
    if (body.law.stiffness != 0.0) {
      if (body.joint == JointType::kBall) {
        AddBallSpring(body.law, q, &force);
      } else {
        AddSpring(body.law, n, q, &force);
      }
    }
    if (n == 1) AddLimit(body.law.limit, q[0], v[0], &force);
  }
  for (int a = 0; a < tree_->num_controls(); ++a) {
    const Actuator& actuator = tree_->actuators()[a];
    const TreeBody& body = tree_->bodies()[actuator.body];
    // A ball has force actuators only, which ask for no position.
    const double x = body.joint == JointType::kBall ? 0.0 : q_(body.q_start + actuator.dof);
    by_control_(a) =
        AddActuator(actuator, x, v_(body.v_start + actuator.dof), controls_(a), &joint_forces_[actuator.body]);
  }
}

void Dynamics::CalcResidual(double rate, VectorXd* r, VectorXd* magnitude) {
  for (int i = 0; i < tree_->size(); ++i) {
    if (!dynamic_[i]) continue;
    const Matrix6d& M = tree_->bodies()[i].M;
    const Vector6d inertial = M * kinematics_[i].A;
    const Vector6d momentum = M * kinematics_[i].V;
    const Vector6d gyroscopic = CrossForce(kinematics_[i].V, momentum);
    F_[i] = inertial + gyroscopic - external_[i].F;
    F_magnitude_[i] =
        inertial.cwiseAbs() + gyroscopic.cwiseAbs() + external_[i].F.cwiseAbs() + rate * momentum.cwiseAbs();
    // v × m v cancels, but not its rounding.
    F_magnitude_[i].head<3>().array() +=
        external_[i].moment_scale + kinematics_[i].V.tail<3>().norm() * momentum.tail<3>().norm();
  }
  for (int i = tree_->size() - 1; i >= 0; --i) {
    if (!dynamic_[i]) continue;
    const TreeBody& body = tree_->bodies()[i];
    for (int k = 0; k < dof_[i]; ++k) {
      const int row = body.v_start + k;
      (*r)(row) = S_[i].col(k).dot(F_[i]) - joint_forces_[i].tau(k);
      (*magnitude)(row) = S_[i].col(k).cwiseAbs().dot(F_magnitude_[i]) + joint_forces_[i].magnitude(k);
    }
    if (body.parent < 0 || !dynamic_[body.parent]) continue;
    const Pose& X_PB = kinematics_[i].X_PB;
    F_[body.parent] += ShiftWrench(X_PB, F_[i]);
    // |R| |F| + |p| × …, bounded above: a magnitude need not be sharp.
    const Vector3d f = X_PB.R.cwiseAbs() * F_magnitude_[i].tail<3>();
    F_magnitude_[body.parent].tail<3>() += f;
    F_magnitude_[body.parent].head<3>() +=
        X_PB.R.cwiseAbs() * F_magnitude_[i].head<3>() + Vector3d::Constant(X_PB.p.norm() * f.norm());
  }
}

}  // namespace knap
