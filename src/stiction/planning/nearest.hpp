#pragma once

#include <Eigen/Core>
#include <vector>

#include "stiction/world/object_space.hpp"

namespace stiction::planning {

/// Points c_i of the object space, each with its own metric, and the nearest of them under d_i(q) = eᵀS_i⁻¹e, e = q ⊖ c_i (3.5), (3.8).
/// Every search computes the distance of every point, because an extension costs more than a thousand of them.
/// Tests: tests/planning/nearest_test.cpp
class NearestPoints {
 public:
  explicit NearestPoints(const world::ObjectSpace& space);

  /// Adds the point c, with the next number and the metric S = L Lᵀ.
  /// @param c  (n_q)  @param S  (n_v × n_v) positive definite  @param L_inv  inverse of its Cholesky factor, lower triangular
  void add(const Eigen::VectorXd& c, const Eigen::MatrixXd& S, const Eigen::MatrixXd& L_inv);
  /// Adds the point c with d(q) = Σ w_i e_i². @param weights  w > 0 (n_v)
  void add(const Eigen::VectorXd& c, const Eigen::VectorXd& weights) {
    add(c, weights.cwiseInverse().asDiagonal().toDenseMatrix(), weights.cwiseSqrt().asDiagonal().toDenseMatrix());
  }

  /// Takes a point out of all later searches.
  void remove(int i) { removed_[static_cast<std::size_t>(i)] = 1; }
  bool removed(int i) const { return removed_[static_cast<std::size_t>(i)] != 0; }

  int size() const { return static_cast<int>(removed_.size()); }

  /// d_i(q). @param q  at least n_q numbers  @param v  ascending coordinates that count, by e_vᵀ(S_vv)⁻¹e_v; others are free; empty: all
  double distance(int i, const double* q, const std::vector<int>& v = {}) const;

  /// argmin_i d_i(q), the first of several; −1 if there is none.
  int nearest(const double* q, const std::vector<int>& v = {}) const;

 private:
  const double* centre(int i) const { return centres_.data() + static_cast<std::ptrdiff_t>(i) * space_->n_q(); }
  double form(int i, const double* e, double enough) const;
  double form_of_some(int i, const double* e, const std::vector<int>& v) const;

  const world::ObjectSpace* space_;
  int n_form_;                       // number of entries of a triangle, n_v (n_v + 1)/2
  std::vector<double> centres_;      // n_q per point
  std::vector<double> covariances_;  // S, lower triangle by rows
  std::vector<double> factors_;      // L_inv likewise
  std::vector<char> removed_;
};

}  // namespace stiction::planning
