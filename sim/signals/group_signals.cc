#include "sim/signals/group_signals.h"

#include <cstddef>

#include "sim/signals/signal_frame.h"

namespace knap {

using Eigen::Vector3d;

Group::Group(const Tree& tree, const std::vector<int>& bodies) {
  for (const int i : bodies) {
    const Matrix6d& M = tree.bodies()[static_cast<std::size_t>(i)].M;
    members_.push_back({i, M(3, 3), Vector3d(M(2, 4), M(0, 5), M(1, 3)) / M(3, 3)});
    mass_ += M(3, 3);
  }
}

namespace {

class CenterSignalFunction final : public SignalFunction {
 public:
  CenterSignalFunction(const Group& group, int in, const Vector3d& axis_A) : group_(group), in_(in), axis_A_(axis_A) {}

  double Calc(const Moment& at) const override {
    const Pose X_WA = GetFrame(at, in_);
    return (X_WA.R * axis_A_).dot(CalcCenter(at) - X_WA.p);
  }

  void PullBack(const Moment& at, double bar, SignalCotangents* out) const override {
    const Pose X_WA = GetFrame(at, in_);
    const Vector3d n = X_WA.R * axis_A_;
    group_.PullBack(
        at.state, bar * n, [&](int body) { return GetFrame(at, body); }, out);
    if (in_ < 0) return;
    StateCotangent& of_frame = out->states.emplace_back();
    of_frame.state = at.state;
    of_frame.body = in_;
    of_frame.p_W = -bar * n;
    of_frame.r_W = bar * n.cross(CalcCenter(at) - X_WA.p);
  }

 private:
  Vector3d CalcCenter(const Moment& at) const {
    return group_.CalcCenter([&](int body) { return GetFrame(at, body); });
  }

  Group group_;
  int in_;
  Vector3d axis_A_;
};

class DriftSignalFunction final : public SignalFunction {
 public:
  DriftSignalFunction(const Group& group, int carrier, double since, const Vector3d& axis_W)
      : group_(group), carrier_(carrier), since_(since), axis_W_(axis_W) {}

  double Calc(const Moment& at) const override {
    const Past past = Look(at);
    return axis_W_.dot(CalcCenter(at) - GetFrame(at, carrier_) * past.carried);
  }

  void PullBack(const Moment& at, double bar, SignalCotangents* out) const override {
    const Past past = Look(at);
    const Vector3d bar_W = bar * axis_W_;
    group_.PullBack(
        at.state, bar_W, [&](int body) { return GetFrame(at, body); }, out);
    const Pose X = GetFrame(at, carrier_);
    AddCarrier(at.state, -bar_W, bar_W.cross(X.R * past.carried), out);
    // Of p_WoC(s), and of where A was then.
    const Vector3d bar_past = -(past.X.R * (X.R.transpose() * bar_W));
    group_.PullBack(
        past.state, bar_past, [&](int body) { return past.Get(body); }, out);
    AddCarrier(past.state, -bar_past, bar_past.cross(past.X.R * past.carried), out);
  }

 private:
  struct Past {
    int state = 0;
    const std::vector<Pose>* poses = nullptr;
    Pose X;            // of the carrier
    Vector3d carried;  // the centre, in A
    const Pose& Get(int body) const { return (*poses)[static_cast<std::size_t>(body)]; }
  };

  Past Look(const Moment& at) const {
    Past past;
    past.state = at.track->FindState(since_);
    past.poses = &at.track->GetPoses(past.state);
    if (carrier_ >= 0) past.X = past.Get(carrier_);
    past.carried = past.X.ApplyInverse(group_.CalcCenter([&](int body) { return past.Get(body); }));
    return past;
  }

  Vector3d CalcCenter(const Moment& at) const {
    return group_.CalcCenter([&](int body) { return GetFrame(at, body); });
  }

  void AddCarrier(int state, const Vector3d& p_W, const Vector3d& r_W, SignalCotangents* out) const {
    if (carrier_ < 0) return;
    StateCotangent& c = out->states.emplace_back();
    c.state = state;
    c.body = carrier_;
    c.p_W = p_W;
    c.r_W = r_W;
  }

  Group group_;
  int carrier_;
  double since_;
  Vector3d axis_W_;
};

}  // namespace

std::unique_ptr<SignalFunction> MakeCenterSignal(const Group& group, int in, const Vector3d& axis_A) {
  return std::make_unique<CenterSignalFunction>(group, in, axis_A);
}

std::unique_ptr<SignalFunction> MakeDriftSignal(const Group& group, int carrier, double since, const Vector3d& axis_W) {
  return std::make_unique<DriftSignalFunction>(group, carrier, since, axis_W);
}

}  // namespace knap
