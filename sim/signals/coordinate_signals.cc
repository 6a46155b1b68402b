#include "sim/signals/coordinate_signals.h"

namespace knap {
namespace {

class RateSignalFunction final : public SignalFunction {
 public:
  explicit RateSignalFunction(int v_index) : v_index_(v_index) {}
  double Calc(const Moment& at) const override { return at.v(v_index_); }
  void PullBack(const Moment& at, double bar, SignalCotangents* out) const override {
    StateCotangent& c = out->states.emplace_back();
    c.state = at.state;
    c.coordinate = v_index_;
    c.rate = bar;
  }

 private:
  int v_index_;
};

class CoordinateSignalFunction final : public SignalFunction {
 public:
  CoordinateSignalFunction(int q_index, int v_index) : q_index_(q_index), v_index_(v_index) {}
  double Calc(const Moment& at) const override { return at.q(q_index_); }
  void PullBack(const Moment& at, double bar, SignalCotangents* out) const override {
    StateCotangent& c = out->states.emplace_back();
    c.state = at.state;
    c.coordinate = v_index_;
    c.pose = bar;
  }
  std::unique_ptr<SignalFunction> MakeRate() const override { return MakeRateSignal(v_index_); }

 private:
  int q_index_, v_index_;
};

}  // namespace

std::unique_ptr<SignalFunction> MakeCoordinateSignal(int q_index, int v_index) {
  return std::make_unique<CoordinateSignalFunction>(q_index, v_index);
}

std::unique_ptr<SignalFunction> MakeRateSignal(int v_index) { return std::make_unique<RateSignalFunction>(v_index); }

}  // namespace knap
