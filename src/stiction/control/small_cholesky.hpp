#pragma once

#include <Eigen/Core>
#include <cmath>

// Cholesky factors of leading blocks of preallocated matrices: real-time code neither allocates nor dispatches on size.

namespace stiction::control {

/// Row-major, in the order of the loops below.
using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// A = C Cᵀ over the leading n × n block. Reads the lower triangle and replaces it by C.
/// @returns false if a pivot is not a number > 0, that is, if A is not positive definite
inline bool factor_cholesky(RowMatrix& A, Eigen::Index n) {
  for (Eigen::Index j = 0; j < n; ++j) {
    double* row_j = A.data() + j * A.outerStride();
    double pivot = row_j[j];
    for (Eigen::Index k = 0; k < j; ++k) pivot -= row_j[k] * row_j[k];
    if (!(pivot > 0) || !std::isfinite(pivot)) return false;
    row_j[j] = std::sqrt(pivot);
    for (Eigen::Index i = j + 1; i < n; ++i) {
      double* row_i = A.data() + i * A.outerStride();
      double sum = row_i[j];
      for (Eigen::Index k = 0; k < j; ++k) sum -= row_i[k] * row_j[k];
      row_i[j] = sum / row_j[j];
    }
  }
  return true;
}

/// x ← (C Cᵀ)⁻¹ x for n numbers, `stride` apart.
inline void solve_cholesky(const RowMatrix& C, Eigen::Index n, double* x, Eigen::Index stride = 1) {
  for (Eigen::Index i = 0; i < n; ++i) {
    const double* row = C.data() + i * C.outerStride();
    double sum = x[i * stride];
    for (Eigen::Index k = 0; k < i; ++k) sum -= row[k] * x[k * stride];
    x[i * stride] = sum / row[i];
  }
  for (Eigen::Index i = n; i-- > 0;) {
    double sum = x[i * stride];
    for (Eigen::Index k = i + 1; k < n; ++k) sum -= C(k, i) * x[k * stride];
    x[i * stride] = sum / C(i, i);
  }
}

}  // namespace stiction::control
