// The acceleration at the next state, extrapolated from those at the last ones: where Newton starts a step.
//
// With backward differences ∇⁰a_k = a_k, ∇ʲ⁺¹a_k = ∇ʲa_k − ∇ʲa_{k−1}, the polynomial through the last d + 1
// accelerations leads to Σ_{j≤d} ∇ʲa_k, and ∇ᵈ⁺¹a_k is what the same polynomial a state earlier missed a_k by. The
// degree d ≤ kMaxDegree is the one whose miss was clearly least, all rates together: high where motion is smooth, 0
// after a jolt. A guess only changes how many iterations a step takes.
#pragma once

#include <Eigen/Dense>
#include <array>

namespace knap {

class AccelerationPredictor {
 public:
  static constexpr int kMaxDegree = 3;

  explicit AccelerationPredictor(int nv) {
    for (Eigen::VectorXd& difference : differences_) difference.setZero(nv);
    carry_.setZero(nv);
    before_.setZero(nv);
  }

  void Clear() { count_ = 0; }

  // The acceleration at a new state that a step of length h led to. Only equal steps add up.
  void Push(double h, const Eigen::VectorXd& a);

  // Zero before the first Push.
  void Predict(double h, Eigen::VectorXd* a) const;

 private:
  std::array<Eigen::VectorXd, kMaxDegree + 2> differences_;  // ∇ʲ of the last acceleration, count_ of them valid
  Eigen::VectorXd carry_, before_;                           // scratch
  int count_ = 0;
  double h_ = 0.0;
};

}  // namespace knap
