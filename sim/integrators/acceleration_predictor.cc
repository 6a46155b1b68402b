#include "sim/integrators/acceleration_predictor.h"

#include <algorithm>

namespace knap {

using Eigen::VectorXd;

namespace {

// A higher degree is taken where the square of its miss is no more than this share of a lower one's: after a jolt all
// miss by about as much, and the higher ones overshoot.
constexpr double kWorthwhile = 0.5;

}  // namespace

void AccelerationPredictor::Push(double h, const VectorXd& a) {
  if (h != h_) count_ = 0;
  h_ = h;
  count_ = std::min(count_ + 1, static_cast<int>(differences_.size()));
  carry_ = a;
  for (int j = 0; j < count_; ++j) {
    before_ = differences_[j];
    differences_[j] = carry_;
    carry_ -= before_;
  }
}

void AccelerationPredictor::Predict(double h, VectorXd* a) const {
  a->setZero();
  if (count_ == 0) return;
  *a = differences_[0];
  if (h != h_ || count_ == 1) return;
  int degree = 0;
  double least = differences_[1].squaredNorm();
  for (int d = 1; d + 1 < count_; ++d) {
    const double miss = differences_[d + 1].squaredNorm();
    if (miss >= kWorthwhile * least) continue;
    degree = d;
    least = miss;
  }
  for (int j = 1; j <= degree; ++j) *a += differences_[j];
}

}  // namespace knap
