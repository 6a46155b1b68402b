#include "sim/signals/track_signals.h"

#include "sim/math/check.h"

namespace knap {
namespace {

class ConstantSignalFunction final : public SignalFunction {
 public:
  explicit ConstantSignalFunction(double value) : value_(value) {}
  double Calc(const Moment&) const override { return value_; }
  void PullBack(const Moment&, double, SignalCotangents*) const override {}
  std::unique_ptr<SignalFunction> MakeRate() const override { return MakeConstantSignal(0.0); }

 private:
  double value_;
};

class TimeSignalFunction final : public SignalFunction {
 public:
  double Calc(const Moment& at) const override { return at.time; }
  void PullBack(const Moment& at, double bar, SignalCotangents* out) const override {
    StateCotangent& c = out->states.emplace_back();
    c.state = at.state;
    c.clock = bar;
  }
  std::unique_ptr<SignalFunction> MakeRate() const override { return MakeConstantSignal(1.0); }
};

class CommandSignalFunction final : public SignalFunction {
 public:
  explicit CommandSignalFunction(int row) : row_(row) {}
  double Calc(const Moment& at) const override { return at.track->GetCommand(row_, at.track->FindInterval(at.state)); }
  void PullBack(const Moment& at, double bar, SignalCotangents* out) const override {
    out->commands.push_back({row_, at.track->FindInterval(at.state), bar});
  }

 private:
  int row_;
};

class ForceSignalFunction final : public SignalFunction {
 public:
  explicit ForceSignalFunction(int series) : series_(series) {}
  double Calc(const Moment& at) const override { return at.track->GetForce(series_, at.state); }
  void PullBack(const Moment&, double, SignalCotangents*) const override {
    KNAP_CHECK(false, "the derivative of a contact's force {} was asked for", series_);
  }

 private:
  int series_;
};

}  // namespace

std::unique_ptr<SignalFunction> MakeTimeSignal() { return std::make_unique<TimeSignalFunction>(); }
std::unique_ptr<SignalFunction> MakeConstantSignal(double value) {
  return std::make_unique<ConstantSignalFunction>(value);
}
std::unique_ptr<SignalFunction> MakeCommandSignal(int row) { return std::make_unique<CommandSignalFunction>(row); }
std::unique_ptr<SignalFunction> MakeForceSignal(int series) { return std::make_unique<ForceSignalFunction>(series); }

}  // namespace knap
