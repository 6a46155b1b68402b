#include "sim/policy/observation.h"

namespace knap {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

Pose GetFrame(const Observation& o, const FeedbackState& at) {
  return o.in < 0 ? Pose{} : at.kinematics[static_cast<std::size_t>(o.in)].X_WB;
}

// All that a body's observation is made of, in the world.
struct Seen {
  Vector3d n;    // the axis e
  Vector3d m;    // the axis f
  Vector3d arm;  // from Bo to P
  Vector3d d;    // from Ao to P
  Vector3d v;    // v_WBo
  Vector3d w;    // w_WB
};

Seen Look(const Observation& o, const FeedbackState& at) {
  const BodyKinematics& kin = at.kinematics[static_cast<std::size_t>(o.body)];
  const Matrix3d& R_WB = kin.X_WB.R;
  const Pose X_WA = GetFrame(o, at);
  Seen seen;
  seen.n = X_WA.R * o.axis;
  seen.m = R_WB * o.of_axis;
  seen.arm = R_WB * o.point;
  seen.d = kin.X_WB.p + seen.arm - X_WA.p;
  seen.v = R_WB * kin.V.tail<3>();
  seen.w = R_WB * kin.V.head<3>();
  return seen;
}

double CalcRaw(const Observation& o, const FeedbackState& at) {
  switch (o.kind) {
    case ObservationKind::kCoordinate:
      return at.q(o.index);
    case ObservationKind::kRate:
      return at.v(o.index);
    case ObservationKind::kElapsedTime:
      return at.time;
    case ObservationKind::kConstant:
      return o.constant;
    default:
      break;
  }
  const Seen seen = Look(o, at);
  switch (o.kind) {
    case ObservationKind::kPosition:
      return seen.n.dot(seen.d);
    case ObservationKind::kVelocity:
      return seen.n.dot(seen.v + seen.w.cross(seen.arm));
    case ObservationKind::kDirection:
      return seen.n.dot(seen.m);
    default:
      return seen.n.dot(seen.w);
  }
}

}  // namespace

double CalcObservation(const Observation& o, const FeedbackState& at) { return (CalcRaw(o, at) - o.offset) / o.scale; }

void PullBackObservation(const Observation& o, const FeedbackState& at, double bar, FeedbackCotangents* out,
                         Vector3d* bar_point) {
  const double s = bar / o.scale;
  switch (o.kind) {
    case ObservationKind::kCoordinate:
      out->pose(o.rate) += s;
      return;
    case ObservationKind::kRate:
      out->v(o.index) += s;
      return;
    case ObservationKind::kElapsedTime:
    case ObservationKind::kConstant:
      return;
    default:
      break;
  }
  const Seen seen = Look(o, at);
  StateCotangent of_body;
  of_body.state = at.state;
  of_body.body = o.body;
  StateCotangent of_frame = of_body;
  of_frame.body = o.in;
  Vector3d bar_arm = Vector3d::Zero();
  switch (o.kind) {
    case ObservationKind::kPosition:
      // n · d with n = R_WA e: dn · d = (dr_A × n) · d.
      of_body.p_W = bar_arm = s * seen.n;
      of_frame.p_W = -s * seen.n;
      of_frame.r_W = s * seen.n.cross(seen.d);
      break;
    case ObservationKind::kVelocity:
      of_body.v_W = s * seen.n;
      of_body.w_W = s * seen.arm.cross(seen.n);
      bar_arm = s * seen.n.cross(seen.w);
      break;
    case ObservationKind::kDirection:
      of_body.r_W = s * seen.m.cross(seen.n);
      of_frame.r_W = s * seen.n.cross(seen.m);
      break;
    default:
      of_body.w_W = s * seen.n;
      break;
  }
  // The arm turns with the body: d(arm) = dr × arm + R_WB dp_B.
  of_body.r_W += seen.arm.cross(bar_arm);
  *bar_point += at.kinematics[static_cast<std::size_t>(o.body)].X_WB.R.transpose() * bar_arm;
  out->bodies.push_back(of_body);
  if (o.in >= 0) out->bodies.push_back(of_frame);
}

}  // namespace knap
