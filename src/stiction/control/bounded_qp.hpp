#pragma once

#include <Eigen/Core>
#include <vector>

#include "stiction/control/small_cholesky.hpp"
#include "stiction/core/status.hpp"

namespace stiction::control {

/// A strictly convex program with a hard box and soft rows:
///
///   min  ½ (x − x̂)ᵀ H (x − x̂) + ½ Σ_i ω_i s_i²    s.t.  lower ≤ x ≤ upper ,  A x ≤ b + s                                        (C.10)
///
/// with ω_i = priority_i / (a_i H⁻¹ a_iᵀ). If no other constraint is active, s_i is the share 1/(1 + priority_i) of the violation that the
/// unconstrained minimum has. Every such program has exactly one solution, even if rows are parallel or contradict each other or the box.
struct BoundedQp {
  RowMatrix H;                   ///< (n × n), symmetric, positive definite; if `diagonal` is set, only its diagonal is read
  bool diagonal = false;         ///< whether H is diagonal
  Eigen::VectorXd center;        ///< x̂ (n)
  Eigen::VectorXd lower, upper;  ///< (n), lower ≤ upper
  RowMatrix A;                   ///< (at least m × n): the first m rows are used
  Eigen::VectorXd b;             ///< (at least m)
  Eigen::VectorXd priority;      ///< (at least m) [-], > 0
  Eigen::Index m = 0;            ///< number of rows

  /// Allocates n variables and up to `rows` rows.
  void reserve(Eigen::Index n, Eigen::Index rows);
};

struct BoundedQpOptions {
  double tolerance = 1e-12;  ///< violation of a bound or row that counts as none, relative to the largest term of its sum, in (0, 1e-6]
  int max_iterations = 0;    ///< largest number of changes of the active set; 0: 20 + 10 (n + m)
  bool closed_form = true;   ///< uses solve_closed_form() for programs that have a closed form
};

struct BoundedQpResult {
  core::Status status = core::Status::NumericalFailure;
  Eigen::VectorXd x;      ///< (n), exactly inside the box
  Eigen::VectorXd y;      ///< (at least m) multipliers of the rows, ≥ 0; s_i = y_i / ω_i
  Eigen::VectorXd z;      ///< (n) multipliers of the box: > 0 at `upper`, < 0 at `lower`;  H (x − x̂) + Aᵀ y + z = 0
  Eigen::VectorXd slack;  ///< (at least m) s ≥ 0
  int iterations = 0;     ///< 0 for the closed form
};

/// Scratch of solve_bounded_qp, sized by reserve(); one per thread.
class BoundedQpWorkspace {
 public:
  void reserve(Eigen::Index n, Eigen::Index rows);

  Eigen::VectorXd omega_inverse;     // 1/ω (rows)
  RowMatrix factor;                  // Cholesky factor of H, or of its free part
  RowMatrix V;                       // H⁻¹ A_fᵀ of the free part, one row per row of A (rows × n)
  RowMatrix S;                       // A_f H⁻¹ A_fᵀ + 1/ω over the active rows, factored
  Eigen::VectorXd z, dx, dz;         // (n)
  Eigen::VectorXd y, dy;             // (rows)
  std::vector<int> side;             // state of the n coordinates: 0 free, +1 at upper, −1 at lower
  std::vector<Eigen::Index> free;    // free coordinates
  std::vector<Eigen::Index> active;  // active rows
  Eigen::VectorXd enters, leaves;    // (n) closed form: multipliers between which a coordinate is free
};

/// Solves (C.10) by the dual active-set method of Goldfarb and Idnani (Math. Programming 27, 1983). The method starts at x̂; every
/// iteration adds the most violated constraint or drops a blocking one. In (x, s) the gradients of all constraints are linearly
/// independent, so any constraint can be added. A diagonal H with one row, or with the two sides of one row, is solved in closed form.
///
/// @returns Solved | MaxIterations (x is inside the box, `slack` has the violations of the rows)
/// | NumericalFailure: H is not positive definite
/// No heap use as long as m does not exceed the rows reserved for this n. Worst case: `max_iterations` of O((n + m)³) each.
/// Tests: tests/control/bounded_qp_test.cpp (brute force over all active sets, ProxQP, residuals)
[[nodiscard]] core::Status solve_bounded_qp(const BoundedQp& qp, const BoundedQpOptions& options, BoundedQpWorkspace& work,
                                            BoundedQpResult& out);

}  // namespace stiction::control
