#include "sim/signals/body_signals.h"

#include <cstddef>
#include <utility>

#include "sim/signals/signal_frame.h"
#include "sim/signals/timed_choice.h"

namespace knap {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

StateCotangent MakeCotangent(const Moment& at, int body) {
  StateCotangent out;
  out.state = at.state;
  out.body = body;
  return out;
}

// What `bar_W`, the cotangent of p_WP, puts on the body and on the point.
void AddPointCotangent(const Moment& at, const WatchedPoint& point, const Vector3d& bar_W, SignalCotangents* out) {
  const Matrix3d& R_WB = GetKinematics(at, point.body).X_WB.R;
  StateCotangent c = MakeCotangent(at, point.body);
  c.p_W = bar_W;
  c.r_W = (R_WB * point.p_B).cross(bar_W);
  out->states.push_back(c);
  out->points[static_cast<std::size_t>(point.number)] += R_WB.transpose() * bar_W;
}

class VelocitySignalFunction final : public SignalFunction {
 public:
  VelocitySignalFunction(const WatchedPoint& point, const Vector3d& axis_W) : point_(point), axis_W_(axis_W) {}

  double Calc(const Moment& at) const override {
    const BodyKinematics& kin = GetKinematics(at, point_.body);
    const Matrix3d& R_WB = kin.X_WB.R;
    const Vector3d v_W = R_WB * kin.V.tail<3>(), w_W = R_WB * kin.V.head<3>();
    return axis_W_.dot(v_W + w_W.cross(R_WB * point_.p_B));
  }

  void PullBack(const Moment& at, double bar, SignalCotangents* out) const override {
    const BodyKinematics& kin = GetKinematics(at, point_.body);
    const Matrix3d& R_WB = kin.X_WB.R;
    const Vector3d arm = R_WB * point_.p_B, w_W = R_WB * kin.V.head<3>();
    StateCotangent c = MakeCotangent(at, point_.body);
    c.v_W = bar * axis_W_;
    c.w_W = bar * arm.cross(axis_W_);
    // The arm turns with the body: d(arm) = dr × arm + R_WB dp_B.
    const Vector3d bar_arm = bar * axis_W_.cross(w_W);
    c.r_W = arm.cross(bar_arm);
    out->states.push_back(c);
    out->points[static_cast<std::size_t>(point_.number)] += R_WB.transpose() * bar_arm;
  }

 private:
  WatchedPoint point_;
  Vector3d axis_W_;
};

class PositionSignalFunction final : public SignalFunction {
 public:
  PositionSignalFunction(const WatchedPoint& point, int in, const Vector3d& axis_A)
      : point_(point), in_(in), axis_A_(axis_A) {}

  double Calc(const Moment& at) const override {
    const Pose X_WA = GetFrame(at, in_);
    return (X_WA.R * axis_A_).dot(GetKinematics(at, point_.body).X_WB * point_.p_B - X_WA.p);
  }

  void PullBack(const Moment& at, double bar, SignalCotangents* out) const override {
    const Pose X_WA = GetFrame(at, in_);
    const Vector3d n = X_WA.R * axis_A_;
    AddPointCotangent(at, point_, bar * n, out);
    // n · d with n = R_WA e: dn · d = (dr_A × n) · d.
    if (in_ == kWorldFrame) return;
    StateCotangent of_frame = MakeCotangent(at, in_);
    of_frame.p_W = -bar * n;
    of_frame.r_W = bar * n.cross(GetKinematics(at, point_.body).X_WB * point_.p_B - X_WA.p);
    out->states.push_back(of_frame);
  }

  // Seen from a body that moves, the rate has parts of its own.
  std::unique_ptr<SignalFunction> MakeRate() const override {
    return in_ == kWorldFrame ? MakeVelocitySignal(point_, axis_A_) : nullptr;
  }

 private:
  WatchedPoint point_;
  int in_;
  Vector3d axis_A_;
};

class DirectionSignalFunction final : public SignalFunction {
 public:
  DirectionSignalFunction(int body, const Vector3d& of_axis_B, int in, const Vector3d& axis_A)
      : body_(body), of_axis_B_(of_axis_B), in_(in), axis_A_(axis_A) {}

  double Calc(const Moment& at) const override {
    return (GetFrame(at, in_).R * axis_A_).dot(GetKinematics(at, body_).X_WB.R * of_axis_B_);
  }

  void PullBack(const Moment& at, double bar, SignalCotangents* out) const override {
    const Vector3d n = GetFrame(at, in_).R * axis_A_, m = GetKinematics(at, body_).X_WB.R * of_axis_B_;
    StateCotangent of_body = MakeCotangent(at, body_);
    of_body.r_W = bar * m.cross(n);
    out->states.push_back(of_body);
    if (in_ == kWorldFrame) return;
    StateCotangent of_frame = MakeCotangent(at, in_);
    of_frame.r_W = bar * n.cross(m);
    out->states.push_back(of_frame);
  }

 private:
  int body_;
  Vector3d of_axis_B_;
  int in_;
  Vector3d axis_A_;
};

class AngularVelocitySignalFunction final : public SignalFunction {
 public:
  AngularVelocitySignalFunction(int body, const Vector3d& axis_W) : body_(body), axis_W_(axis_W) {}

  double Calc(const Moment& at) const override {
    const BodyKinematics& kin = GetKinematics(at, body_);
    return axis_W_.dot(kin.X_WB.R * kin.V.head<3>());
  }

  void PullBack(const Moment& at, double bar, SignalCotangents* out) const override {
    StateCotangent c = MakeCotangent(at, body_);
    c.w_W = bar * axis_W_;
    out->states.push_back(c);
  }

 private:
  int body_;
  Vector3d axis_W_;
};

class DistanceSignalFunction final : public SignalFunction {
 public:
  DistanceSignalFunction(const WatchedPoint& point, int in, std::vector<TimedPoint> targets)
      : point_(point), in_(in), targets_(std::move(targets)) {}

  double Calc(const Moment& at) const override { return CalcOffset(at).norm(); }

  void PullBack(const Moment& at, double bar, SignalCotangents* out) const override {
    const Vector3d offset = CalcOffset(at);  // in W
    const double distance = offset.norm();
    if (distance == 0.0) return;
    const Vector3d bar_W = bar / distance * offset;
    AddPointCotangent(at, point_, bar_W, out);
    if (in_ == kWorldFrame) return;
    StateCotangent of_frame = MakeCotangent(at, in_);
    of_frame.p_W = -bar_W;
    of_frame.r_W = bar_W.cross(GetFrame(at, in_).R * ChooseAfter(targets_, at.time).p_A);
    out->states.push_back(of_frame);
  }

 private:
  Vector3d CalcOffset(const Moment& at) const {
    return GetKinematics(at, point_.body).X_WB * point_.p_B - GetFrame(at, in_) * ChooseAfter(targets_, at.time).p_A;
  }

  WatchedPoint point_;
  int in_;
  std::vector<TimedPoint> targets_;
};

}  // namespace

std::unique_ptr<SignalFunction> MakePositionSignal(const WatchedPoint& point, int in, const Vector3d& axis_A) {
  return std::make_unique<PositionSignalFunction>(point, in, axis_A);
}

std::unique_ptr<SignalFunction> MakeVelocitySignal(const WatchedPoint& point, const Vector3d& axis_W) {
  return std::make_unique<VelocitySignalFunction>(point, axis_W);
}

std::unique_ptr<SignalFunction> MakeDirectionSignal(int body, const Vector3d& of_axis_B, int in,
                                                    const Vector3d& axis_A) {
  return std::make_unique<DirectionSignalFunction>(body, of_axis_B, in, axis_A);
}

std::unique_ptr<SignalFunction> MakeAngularVelocitySignal(int body, const Vector3d& axis_W) {
  return std::make_unique<AngularVelocitySignalFunction>(body, axis_W);
}

std::unique_ptr<SignalFunction> MakeDistanceSignal(const WatchedPoint& point, int in, std::vector<TimedPoint> targets) {
  return std::make_unique<DistanceSignalFunction>(point, in, std::move(targets));
}

}  // namespace knap
