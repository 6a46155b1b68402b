// LU factorisation with row pivoting of a small dense matrix whose size changes from call to call without allocating:
// storage only ever grows.
//
//   P A = L U,   Solve: A x = b,   SolveTransposed: Aᵀ x = b.           [Golub & Van Loan 2013, §3.4]
#pragma once

#include <vector>

namespace knap {

class DenseLu {
 public:
  // n×n with unspecified entries, to be filled through (row, column) before Factor.
  void Resize(int n);
  double& operator()(int row, int column) { return a_[static_cast<std::size_t>(row) * n_ + column]; }
  int size() const { return n_; }

  // Overwrites the entries by the factors. False when a pivot is zero or not finite. n³/3 multiplications.
  bool Factor();

  // In place: b holds n values, and the solution afterwards. Needs a successful Factor.
  void Solve(double* b) const;
  void SolveTransposed(double* b) const;

 private:
  double at(int row, int column) const { return a_[static_cast<std::size_t>(row) * n_ + column]; }

  int n_ = 0;
  std::vector<double> a_;  // row by row
  std::vector<int> swap_;  // the row exchanged with row k at step k
};

}  // namespace knap
