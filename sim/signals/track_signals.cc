#include "sim/signals/track_signals.h"

#include <utility>

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
  ForceSignalFunction(int series, std::vector<int> contacts) : series_(series), contacts_(std::move(contacts)) {}
  double Calc(const Moment& at) const override { return at.track->GetForce(series_, at.state).norm(); }
  void PullBack(const Moment& at, double bar, SignalCotangents* out) const override {
    const Eigen::Vector3d& f_W = at.track->GetForce(series_, at.state);
    const double size = f_W.norm();
    if (size == 0.0) return;
    for (const int contact : contacts_) {
      StateCotangent& c = out->states.emplace_back();
      c.state = at.track->FindForce(at.state);
      c.contact = contact;
      c.f_W = bar / size * f_W;
    }
  }

 private:
  int series_;
  std::vector<int> contacts_;
};

}  // namespace

std::unique_ptr<SignalFunction> MakeTimeSignal() { return std::make_unique<TimeSignalFunction>(); }
std::unique_ptr<SignalFunction> MakeConstantSignal(double value) {
  return std::make_unique<ConstantSignalFunction>(value);
}
std::unique_ptr<SignalFunction> MakeCommandSignal(int row) { return std::make_unique<CommandSignalFunction>(row); }
std::unique_ptr<SignalFunction> MakeForceSignal(int series, std::vector<int> contacts) {
  return std::make_unique<ForceSignalFunction>(series, std::move(contacts));
}

}  // namespace knap
