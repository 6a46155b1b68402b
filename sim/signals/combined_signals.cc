#include "sim/signals/combined_signals.h"

#include <cmath>
#include <cstddef>
#include <utility>

namespace knap {
namespace {

class DifferenceSignalFunction final : public SignalFunction {
 public:
  DifferenceSignalFunction(SignalPointer a, SignalPointer b) : a_(std::move(a)), b_(std::move(b)) {}
  double Calc(const Moment& at) const override { return a_->Calc(at) - b_->Calc(at); }
  void PullBack(const Moment& at, double bar, SignalCotangents* out) const override {
    a_->PullBack(at, bar, out);
    b_->PullBack(at, -bar, out);
  }
  std::unique_ptr<SignalFunction> MakeRate() const override {
    SignalPointer a = a_->MakeRate(), b = b_->MakeRate();
    return a && b ? MakeDifferenceSignal(std::move(a), std::move(b)) : nullptr;
  }

 private:
  SignalPointer a_, b_;
};

class NormSignalFunction final : public SignalFunction {
 public:
  explicit NormSignalFunction(std::vector<SignalPointer> parts) : parts_(std::move(parts)) {}
  double Calc(const Moment& at) const override {
    double sum = 0.0;
    for (const SignalPointer& part : parts_) {
      const double s = part->Calc(at);
      sum += s * s;
    }
    return std::sqrt(sum);
  }
  void PullBack(const Moment& at, double bar, SignalCotangents* out) const override {
    const double norm = Calc(at);
    if (norm == 0.0) return;
    for (const SignalPointer& part : parts_) part->PullBack(at, bar * part->Calc(at) / norm, out);
  }

 private:
  std::vector<SignalPointer> parts_;
};

class ExtremeSignalFunction final : public SignalFunction {
 public:
  ExtremeSignalFunction(std::vector<SignalPointer> parts, double sign) : parts_(std::move(parts)), sign_(sign) {}
  double Calc(const Moment& at) const override { return Choose(at).Calc(at); }
  void PullBack(const Moment& at, double bar, SignalCotangents* out) const override {
    Choose(at).PullBack(at, bar, out);
  }

 private:
  const SignalFunction& Choose(const Moment& at) const {
    std::size_t best = 0;
    double most = sign_ * parts_[0]->Calc(at);
    for (std::size_t i = 1; i < parts_.size(); ++i) {
      const double value = sign_ * parts_[i]->Calc(at);
      if (!(value > most)) continue;
      most = value;
      best = i;
    }
    return *parts_[best];
  }

  std::vector<SignalPointer> parts_;
  double sign_;  // +1: the largest, −1: the least
};

}  // namespace

std::unique_ptr<SignalFunction> MakeDifferenceSignal(SignalPointer a, SignalPointer b) {
  return std::make_unique<DifferenceSignalFunction>(std::move(a), std::move(b));
}
std::unique_ptr<SignalFunction> MakeNormSignal(std::vector<SignalPointer> parts) {
  return std::make_unique<NormSignalFunction>(std::move(parts));
}
std::unique_ptr<SignalFunction> MakeLeastSignal(std::vector<SignalPointer> parts) {
  return std::make_unique<ExtremeSignalFunction>(std::move(parts), -1.0);
}
std::unique_ptr<SignalFunction> MakeLargestSignal(std::vector<SignalPointer> parts) {
  return std::make_unique<ExtremeSignalFunction>(std::move(parts), 1.0);
}

}  // namespace knap
