#include "sim/transfer/soft_links.h"

#include <Eigen/LU>
#include <cstddef>

namespace knap {

using Eigen::Matrix3d;
using Eigen::Vector3d;

void DampJoints(double damping_step, const std::vector<Matrix3d>& inertia, std::vector<Vector3d>* w) {
  const std::size_t n = w->size();
  if (n < 2 || damping_step == 0.0) return;
  // Elimination from the first link on: D_i w_i − a w_{i+1} = b_i.
  std::vector<Matrix3d> inverse(n);
  std::vector<Vector3d> b(n);
  for (std::size_t i = 0; i < n; ++i) {
    const double neighbours = i == 0 || i + 1 == n ? 1.0 : 2.0;
    Matrix3d D = inertia[i] + neighbours * damping_step * Matrix3d::Identity();
    b[i] = inertia[i] * (*w)[i];
    if (i > 0) {
      D -= damping_step * damping_step * inverse[i - 1];
      b[i] += damping_step * (inverse[i - 1] * b[i - 1]);
    }
    inverse[i] = D.inverse();
  }
  (*w)[n - 1] = inverse[n - 1] * b[n - 1];
  for (std::size_t i = n - 1; i-- > 0;) (*w)[i] = inverse[i] * (b[i] + damping_step * (*w)[i + 1]);
}

}  // namespace knap
