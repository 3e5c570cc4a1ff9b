#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <vector>

#include "stiction/core/status.hpp"

namespace stiction::trajopt {

/// Row-major, because the rows of constraints are combined with vectors of multipliers.
using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// One stage of a BoxLqProblem: from x_t, u_t to x_{t+1}.
struct LqStage {
  Eigen::MatrixXd A;             ///< (n × n)
  Eigen::MatrixXd B;             ///< (n × m)
  Eigen::MatrixXd Q;             ///< cost Hessian of x_{t+1}, symmetric, ⪰ 0 (n × n)
  Eigen::VectorXd q;             ///< linear cost of x_{t+1} (n)
  Eigen::VectorXd r;             ///< nominal change of the input ū_t − ū_{t−1} (m)
  Eigen::VectorXd lower, upper;  ///< bounds of u_t (m), finite, lower ≤ upper
  RowMatrix Gx, Gu;              ///< rows Gx x_t + Gu u_t + g ≥ 0 (k × n, k × m); k may be 0
  Eigen::VectorXd g;             ///< (k)
};

/// Optimal control problem with linear dynamics, a quadratic cost that penalises changes of the input, bounds on the input and linear rows:
///
///   min  Σ_{t=0}^{T−1} ½ x_{t+1}ᵀ Q_t x_{t+1} + q_tᵀ x_{t+1} + ½ (r_t + u_t − u_{t−1})ᵀ R (r_t + u_t − u_{t−1}) ,   u_{−1} = 0       (T.3)
///   s.t. x_{t+1} = A_t x_t + B_t u_t ,  x_0 given ,  lower_t ≤ u_t ≤ upper_t ,  Gx_t x_t + Gu_t u_t + g_t ≥ 0
struct BoxLqProblem {
  Eigen::VectorXd x0;           ///< (n)
  Eigen::VectorXd R;            ///< diagonal, ≥ 0 (m)
  std::vector<LqStage> stages;  ///< T ≥ 1
};

struct BoxLqOptions {
  double tolerance = 1e-9;  ///< the cost of the solution is at most this far above the minimum, > 0
  int max_iterations = 60;  ///< ≥ 1
};

/// Feedback gains of the last quadratic model before the solution: u_t + K_x (x − x_t) + K_u (u_{t−1}' − u_{t−1}). The gains of an input at
/// a bound are close to zero.
struct LqGains {
  Eigen::MatrixXd K_x;  ///< (m × n)
  Eigen::MatrixXd K_u;  ///< (m × m)
};

struct BoxLqResult {
  core::Status status = core::Status::NumericalFailure;
  std::vector<Eigen::VectorXd> u;  ///< T, (m)
  std::vector<Eigen::VectorXd> x;  ///< T + 1, (n)
  std::vector<LqGains> gains;      ///< T
  double cost = 0;                 ///< cost (T.3)
  double gap = 0;                  ///< upper bound of the distance from the cost to its minimum
  int iterations = 0;              ///< number of factorisations
};

/// Scratch; sized by the first call.
class BoxLqWorkspace {
 public:
  struct Stage {
    Eigen::MatrixXd S_xx, S_xu, S_uu;  // Hessian of the cost to go after this stage, in (x_{t+1}, u_t)
    Eigen::MatrixXd P_xx, P_xu, P_uu;  // Hessian of the cost to go from this stage on, in (x_t, u_{t−1})
    Eigen::MatrixXd M;                 // S_xx B + S_xu
    Eigen::MatrixXd W_xu, H;
    Eigen::LLT<Eigen::MatrixXd> llt;
    LqGains gains;
    Eigen::VectorXd p_x, k;                            // linear term of the cost to go, and k of the step du = K_x dx + K_u du_{t−1} + k
    Eigen::VectorXd u, x_next, du, dx_next, gradient;  // iterate, step, gradient of the Lagrangian without the multipliers of the bounds
    Eigen::VectorXd s_lower, s_upper;                  // slacks of the bounds
    Eigen::VectorXd z_lower, z_upper, dz_lower, dz_upper;    // multipliers of the bounds
    Eigen::VectorXd s_row, y_row, ds_row, dy_row;            // slacks and multipliers of the rows
    Eigen::VectorXd center_lower, center_upper, center_row;  // target values of slack · multiplier
  };
  std::vector<Stage> stages;
  Eigen::MatrixXd S_A;
  RowMatrix weighted_x, weighted_u;
  Eigen::VectorXd costate, x, u_before, change, row;
};

/// Solves (T.3) by a primal–dual interior-point method with Mehrotra's corrector. A Riccati recursion over (x_t, u_{t−1}) is the
/// factorisation, so one iteration costs O(T (n + m)³). All iterates lie strictly within the bounds. Bounds closer than 1e-9 are widened to
/// 1e-9.
///
/// @returns Solved: gap ≤ tolerance | MaxIterations: `out` is the best feasible point | NumericalFailure
/// @throws  core::InvalidInput: sizes that do not fit, a lower bound above its upper bound, numbers that are not finite
/// Tests: tests/trajopt/box_lq_test.cpp (closed form, ProxQP)
[[nodiscard]] core::Status solve_box_lq(const BoxLqProblem& problem, const BoxLqOptions& options, BoxLqWorkspace& work, BoxLqResult& out);

}  // namespace stiction::trajopt
