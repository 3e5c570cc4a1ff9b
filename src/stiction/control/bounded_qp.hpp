#pragma once

#include <Eigen/Core>
#include <vector>

#include "stiction/control/small_cholesky.hpp"
#include "stiction/core/status.hpp"

namespace stiction::control {

/// A strictly convex program with a box and rows that give way:
///
///   min  ½ (x − x̂)ᵀ H (x − x̂) + ½ Σ_i ω_i s_i²    s.t.  lower ≤ x ≤ upper ,  A x ≤ b + s                                        (C.10)
///
/// ω_i = priority_i / (a_i H⁻¹ a_iᵀ): where nothing else holds x back, s_i is 1/(1 + priority_i) of what the row would be broken by without it.
/// Every such program has exactly one solution, whatever its rows are: parallel, contradictory, against the box.
struct BoundedQp {
  RowMatrix H;                   ///< (n × n), symmetric, positive definite; only its diagonal is read where `diagonal` is set
  bool diagonal = false;         ///< H is
  Eigen::VectorXd center;        ///< x̂ (n)
  Eigen::VectorXd lower, upper;  ///< (n), lower ≤ upper
  RowMatrix A;                   ///< (at least m × n): the first m rows count
  Eigen::VectorXd b;             ///< (at least m)
  Eigen::VectorXd priority;      ///< (at least m) [-], > 0
  Eigen::Index m = 0;            ///< number of rows

  /// Room for n variables and up to m rows.
  void reserve(Eigen::Index n, Eigen::Index rows);
};

struct BoundedQpOptions {
  double tolerance = 1e-12;  ///< of a bound or row, relative to the largest of the numbers whose sum it judges, in (0, 1e-6]
  int max_iterations = 0;    ///< changes of the active set; 0: 20 + 10 (n + m)
  bool closed_form = true;   ///< one row or its two sides, diagonal H: the root of a piecewise linear function of its multiplier
};

struct BoundedQpResult {
  core::Status status = core::Status::NumericalFailure;
  Eigen::VectorXd x;      ///< (n), inside the box to the last bit
  Eigen::VectorXd y;      ///< (at least m) multipliers of the rows, ≥ 0; s_i = y_i / ω_i
  Eigen::VectorXd z;      ///< (n) of the box: > 0 at `upper`, < 0 at `lower`;  H (x − x̂) + Aᵀ y + z = 0
  Eigen::VectorXd slack;  ///< (at least m) s ≥ 0
  int iterations = 0;     ///< 0 for the closed form
};

/// Scratch of solve_bounded_qp, sized by reserve(); one per thread.
class BoundedQpWorkspace {
 public:
  void reserve(Eigen::Index n, Eigen::Index rows);

  Eigen::VectorXd omega_inverse;     // 1/ω (rows)
  RowMatrix factor;                  // of H, or of its free part
  RowMatrix V;                       // H⁻¹ A_fᵀ of the free part, a row each (rows × n)
  RowMatrix S;                       // A_f H⁻¹ A_fᵀ + 1/ω over the active rows, factored
  Eigen::VectorXd z, dx, dz;         // (n)
  Eigen::VectorXd y, dy;             // (rows)
  std::vector<int> side;             // of the n bounds: 0 free, +1 at upper, −1 at lower
  std::vector<Eigen::Index> free;    // coordinates
  std::vector<Eigen::Index> active;  // rows
  Eigen::VectorXd enters, leaves;    // (n) of the closed form: multipliers between which a coordinate is free
};

/// Solves (C.10) by the dual active-set method of Goldfarb and Idnani (Math. Programming 27, 1983): from x̂ on, every iteration adds the most
/// violated constraint or drops one that blocks. The gradients of all constraints of the program in (x, s) are linearly independent, so
/// that every one of them can be added. One row or its two sides, and a diagonal H: the closed form.
///
/// @returns Solved | MaxIterations (x is inside the box, slack says by how much rows are broken) | NumericalFailure: H is not positive definite
/// No heap use where m is within what was reserved for this n. Worst case: `max_iterations` of O((n + m)³) each.
/// Tests: tests/control/bounded_qp_test.cpp (brute force over all active sets, ProxQP, residuals)
[[nodiscard]] core::Status solve_bounded_qp(const BoundedQp& qp, const BoundedQpOptions& options, BoundedQpWorkspace& work,
                                            BoundedQpResult& out);

}  // namespace stiction::control
