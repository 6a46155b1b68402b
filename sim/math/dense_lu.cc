#include "sim/math/dense_lu.h"

#include <cmath>
#include <cstddef>
#include <utility>

namespace knap {

void DenseLu::Resize(int n) {
  n_ = n;
  const std::size_t entries = static_cast<std::size_t>(n) * n;
  if (a_.size() < entries) {
    a_.resize(entries);
    swap_.resize(n);
  }
}

bool DenseLu::Factor() {
  for (int k = 0; k < n_; ++k) {
    int pivot = k;
    for (int i = k + 1; i < n_; ++i) {
      if (std::abs(at(i, k)) > std::abs(at(pivot, k))) pivot = i;
    }
    swap_[k] = pivot;
    if (!(std::abs(at(pivot, k)) > 0.0) || !std::isfinite(at(pivot, k))) return false;
    if (pivot != k) {
      for (int j = 0; j < n_; ++j) std::swap((*this)(k, j), (*this)(pivot, j));
    }
    for (int i = k + 1; i < n_; ++i) {
      const double factor = at(i, k) / at(k, k);
      (*this)(i, k) = factor;
      for (int j = k + 1; j < n_; ++j) (*this)(i, j) -= factor * at(k, j);
    }
  }
  return true;
}

void DenseLu::Solve(double* b) const {
  for (int k = 0; k < n_; ++k) std::swap(b[k], b[swap_[k]]);
  for (int k = 0; k < n_; ++k) {
    for (int i = k + 1; i < n_; ++i) b[i] -= at(i, k) * b[k];
  }
  for (int i = n_ - 1; i >= 0; --i) {
    for (int j = i + 1; j < n_; ++j) b[i] -= at(i, j) * b[j];
    b[i] /= at(i, i);
  }
}

void DenseLu::SolveTransposed(double* b) const {
  for (int i = 0; i < n_; ++i) {
    b[i] /= at(i, i);
    for (int j = i + 1; j < n_; ++j) b[j] -= at(i, j) * b[i];
  }
  for (int k = n_ - 1; k >= 0; --k) {
    for (int i = k + 1; i < n_; ++i) b[k] -= at(i, k) * b[i];
  }
  for (int k = n_ - 1; k >= 0; --k) std::swap(b[k], b[swap_[k]]);
}

}  // namespace knap
