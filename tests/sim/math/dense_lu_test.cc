// The small LU against Eigen's, on random matrices of changing size, singular ones included.
#include "sim/math/dense_lu.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <cstdlib>

namespace knap {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

TEST(DenseLu, SolvesBothWaysInAnySize) {
  std::srand(7);
  DenseLu lu;
  for (const int n : {6, 12, 6, 1, 30, 2}) {
    MatrixXd A = MatrixXd::Random(n, n);
    if (n > 1) A(0, 0) = 0.0;  // needs an exchange of rows
    lu.Resize(n);
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j < n; ++j) lu(i, j) = A(i, j);
    }
    ASSERT_TRUE(lu.Factor());
    const VectorXd b = VectorXd::Random(n);
    const double scale = 1e-13 * A.inverse().norm();
    VectorXd x = b;
    lu.Solve(x.data());
    EXPECT_LT((A * x - b).norm(), scale) << n;
    x = b;
    lu.SolveTransposed(x.data());
    EXPECT_LT((A.transpose() * x - b).norm(), scale) << n;
  }
}

TEST(DenseLu, RefusesWhatIsSingularOrNotFinite) {
  DenseLu lu;
  for (const double last : {4.0, std::nan("")}) {
    lu.Resize(2);
    lu(0, 0) = 1.0;
    lu(0, 1) = 2.0;
    lu(1, 0) = 2.0;
    lu(1, 1) = last;
    EXPECT_FALSE(lu.Factor());
  }
}

}  // namespace
}  // namespace knap
