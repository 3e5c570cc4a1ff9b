#pragma once

#include <Eigen/Core>
#include <vector>

#include "stiction/world/object_space.hpp"

namespace stiction::planning {

/// Points c_i of the object space, each with a metric of its own, and the nearest of them under d_i(q) = eᵀS_i⁻¹e, e = q ⊖ c_i (3.5), (3.8).
///
/// The answer is that of the linear scan, ties by number. No form is evaluated where a bound already loses (docs/theory/planning.md, N.1, N.2):
/// points lie in balls of world::ObjectSpace::chord, a metric of the space that is at most ‖De‖, and d_i(q) ≥ ‖De‖²/λ_max(D S_i D). Balls are built once
/// and never changed; those of like size are merged (Bentley and Saxe 1980), so that adding costs O(log² n).
class NearestPoints {
 public:
  explicit NearestPoints(const world::ObjectSpace& space);

  /// The next number gets the point c and the metric S = L Lᵀ.
  /// @param c  (n_q)  @param S  (n_v × n_v) positive definite  @param L_inv  inverse of its Cholesky factor, lower triangular
  void add(const Eigen::VectorXd& c, const Eigen::MatrixXd& S, const Eigen::MatrixXd& L_inv);
  /// The same with d(q) = Σ w_i e_i². @param weights  w > 0 (n_v)
  void add(const Eigen::VectorXd& c, const Eigen::VectorXd& weights) {
    add(c, weights.cwiseInverse().asDiagonal().toDenseMatrix(), weights.cwiseSqrt().asDiagonal().toDenseMatrix());
  }

  /// Takes a point out of every later search.
  void remove(int i) { removed_[static_cast<std::size_t>(i)] = 1; }
  bool removed(int i) const { return removed_[static_cast<std::size_t>(i)] != 0; }

  int size() const { return static_cast<int>(removed_.size()); }

  /// d_i(q). @param q  at least n_q numbers
  double distance(int i, const double* q) const;

  /// The same for some coordinates alone, when the others may be anywhere: e_vᵀ(S_vv)⁻¹e_v. @param v  their numbers
  double distance(int i, const double* q, const std::vector<int>& v) const;

  /// argmin_i d_i(q), −1 when there is none. @param evaluated  when given: how many forms were computed
  int nearest(const double* q, long* evaluated = nullptr) const;

 private:
  struct Ball {
    int centre;         // a point
    double radius = 0;  // chord from there to the farthest of its points
    double least = 0;   // of 1/λ_max over them
    int begin, end;     // in Part::points
    int left = -1, right = -1;
  };
  struct Part {
    std::vector<int> points;
    std::vector<double> least;  // 1/λ_max(D S D), beside `points`
    std::vector<Ball> balls;    // the first holds all
    Eigen::VectorXd weights;    // diagonal of D² (n_v)
  };
  struct Search;

  const double* centre(int i) const { return centres_.data() + static_cast<std::ptrdiff_t>(i) * space_->n_q(); }
  double form(int i, const double* e, double enough) const;
  double chord(const Part& part, int i, const double* q) const { return space_->chord(centre(i), q, part.weights); }
  Part make_part(std::vector<int> points) const;
  int add_ball(Part& part, int begin, int end) const;
  void descend(const Part& part, int ball, Search& search) const;
  void consider(int i, Search& search) const;

  const world::ObjectSpace* space_;
  int n_form_;                       // numbers of a triangle, n_v (n_v + 1)/2
  std::vector<double> centres_;      // n_q per point
  std::vector<double> covariances_;  // S, lower triangle by rows
  std::vector<double> factors_;      // L_inv likewise
  std::vector<char> removed_;
  std::vector<Part> parts_;  // the larger the earlier
  std::vector<int> fresh_;   // not in a part yet
};

}  // namespace stiction::planning
