// The acceleration at the next state, extrapolated from those at the last ones: where Newton starts a step.
//
// With divided differences a[k] = a_k, a[k…k−j] = (a[k…k−j+1] − a[k−1…k−j])/(t_k − t_{k−j}), the polynomial through the
// last d + 1 accelerations is Σ_{j≤d} a[k…k−j] Π_{i<j} (t − t_{k−i}), and the term of degree d + 1 at t_k, Newton's
// nodes moved on by one, is what the same polynomial a state earlier missed a_k by. The degree d ≤ kMaxDegree is the
// one whose miss was clearly least, all rates together: high where motion is smooth, 0 after a jolt. A guess only
// changes how many iterations a step takes.
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

  // The acceleration at a state later than the last one.
  void Push(double time, const Eigen::VectorXd& a);

  // Zero before the first Push.
  void Predict(double time, Eigen::VectorXd* a) const;

 private:
  static constexpr int kNodes = kMaxDegree + 2;
  std::array<Eigen::VectorXd, kNodes> differences_;  // a[k…k−j], count_ of them valid
  std::array<double, kNodes> times_{};               // t_{k−j}
  Eigen::VectorXd carry_, before_;                   // scratch
  int count_ = 0;
};

}  // namespace knap
