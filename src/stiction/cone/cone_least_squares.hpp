#pragma once

#include <Eigen/Core>
#include <vector>

#include "stiction/cone/solver.hpp"

namespace stiction::cone {

/// Bounded least squares with Lorentz cones: x = argmin ‖A x − b‖² + γ‖x‖²  s.t.  lower ≤ x ≤ upper,  Gᵢx + gᵢ ∈ L³.
class ConeLeastSquares {
 public:
  /// @param n  number of unknowns, ≥ 1
  explicit ConeLeastSquares(int n);

  void clear_cones() { cones_.clear(); }
  /// Adds the row block Gx + g ∈ L³ = {w₀ ≥ ‖(w₁, w₂)‖}; the caller scales it to about 1. @param G  3 × n
  void add_cone(const Eigen::Ref<const Eigen::MatrixXd>& G, const Eigen::Vector3d& g);

  /// @param A (m × n)  @param b (m)  @param gamma > 0  @param lower, upper (n), may be infinite
  /// @returns false if no x satisfies the rows or the solver failed; x is then undefined
  bool solve(const Eigen::Ref<const Eigen::MatrixXd>& A, const Eigen::Ref<const Eigen::VectorXd>& b, double gamma,
             const Eigen::Ref<const Eigen::VectorXd>& lower, const Eigen::Ref<const Eigen::VectorXd>& upper, Eigen::VectorXd& x);

 private:
  struct Cone {
    Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::RowMajor> G;
    Eigen::Vector3d g;
  };
  int n_;
  int support_;
  std::vector<Cone> cones_;
  cone::Problem problem_;
  cone::Workspace work_;
  cone::Result result_;
};

}  // namespace stiction::cone
