#include "sim/integrators/acceleration_predictor.h"

#include <algorithm>

namespace knap {

using Eigen::VectorXd;

namespace {

// A higher degree is taken where the square of its miss is no more than this share of a lower one's: after a jolt all
// miss by about as much, and the higher ones overshoot.
constexpr double kWorthwhile = 0.5;

}  // namespace

void AccelerationPredictor::Push(double time, const VectorXd& a) {
  const int before = count_;
  count_ = std::min(count_ + 1, kNodes);
  carry_ = a;
  for (int j = 0; j < count_; ++j) {
    before_ = differences_[j];
    differences_[j] = carry_;
    if (j < before) carry_ = (carry_ - before_) / (time - times_[j]);
  }
  for (int j = count_ - 1; j > 0; --j) times_[j] = times_[j - 1];
  times_[0] = time;
}

void AccelerationPredictor::Predict(double time, VectorXd* a) const {
  a->setZero();
  if (count_ == 0) return;
  *a = differences_[0];
  if (count_ == 1) return;
  int degree = 0;
  double reach = times_[0] - times_[1];
  double least = reach * reach * differences_[1].squaredNorm();
  for (int d = 1; d + 1 < count_; ++d) {
    reach *= times_[0] - times_[d + 1];
    const double miss = reach * reach * differences_[d + 1].squaredNorm();
    if (miss >= kWorthwhile * least) continue;
    degree = d;
    least = miss;
  }
  double power = 1.0;
  for (int j = 1; j <= degree; ++j) {
    power *= time - times_[j - 1];
    *a += power * differences_[j];
  }
}

}  // namespace knap
