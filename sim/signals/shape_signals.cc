#include "sim/signals/shape_signals.h"

#include <cstddef>

#include "sim/signals/track_signals.h"

namespace knap {
namespace {

class MeasureSignalFunction final : public SignalFunction {
 public:
  MeasureSignalFunction(double value, int number) : value_(value), number_(static_cast<std::size_t>(number)) {}
  double Calc(const Moment&) const override { return value_; }
  void PullBack(const Moment&, double bar, SignalCotangents* out) const override { out->measures[number_] += bar; }
  std::unique_ptr<SignalFunction> MakeRate() const override { return MakeConstantSignal(0.0); }

 private:
  double value_;
  std::size_t number_;
};

}  // namespace

std::unique_ptr<SignalFunction> MakeMeasureSignal(double value, int number) {
  return std::make_unique<MeasureSignalFunction>(value, number);
}

}  // namespace knap
