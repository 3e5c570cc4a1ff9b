#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>

namespace stiction::bench {

/// min ½ xᵀH x + gᵀx  s.t.  A x = b ,  lower ≤ C x ≤ upper , with ±1e20 where there is no bound. A and b are empty where there are no equations.
struct QuadraticProgram {
  Eigen::MatrixXd H = {};
  Eigen::VectorXd g = {};
  Eigen::MatrixXd A = {};
  Eigen::VectorXd b = {};
  Eigen::MatrixXd C = {};
  Eigen::VectorXd lower = {}, upper = {};
};

struct ProxQpOptions {
  double residual = 1e-10;     ///< largest residual of a solution, absolute
  int max_iterations = 20000;  ///< ≥ 1
  bool warm_start = false;     ///< a program starts from the solution of the one before
};

/// The dense solver ProxQP, which keeps its workspace from program to program.
class ProxQp {
 public:
  /// Of programs with n unknowns, so many rows of A and so many of C.
  ProxQp(Eigen::Index n, Eigen::Index equations, Eigen::Index rows, const ProxQpOptions& options);
  ~ProxQp();
  ProxQp(ProxQp&&) noexcept;
  /// @returns whether the program was solved; then x() is its minimiser
  bool solve(const QuadraticProgram& program);
  const Eigen::VectorXd& x() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// The minimiser of one program; nullopt where ProxQP gives up.
std::optional<Eigen::VectorXd> minimise_by_proxqp(const QuadraticProgram& program, const ProxQpOptions& options);

}  // namespace stiction::bench
