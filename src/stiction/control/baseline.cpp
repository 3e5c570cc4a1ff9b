#include "stiction/control/baseline.hpp"

#include "stiction/control/small_cholesky.hpp"

namespace stiction::control {

using core::Status;
using Eigen::Index;

void BaselineWorkspace::reserve(Index n, Index contacts) {
  J.setZero(contacts, n), G.setZero(contacts, contacts);
  rhs.setZero(contacts), lambda.setZero(contacts), column.setZero(n);
}

Status solve_null_space(const BaselineInput& in, BaselineWorkspace& work, Eigen::VectorXd& q_cmd) {
  const Index n = in.q.size();
  Index m = 0;
  for (Index i = 0; i < in.J_u.rows(); ++i) {
    double along = 0;
    for (Index j = 0; j < n; ++j) along += in.J_u(i, j) * (in.q_track[j] - in.q[j]);
    if (along >= 0) continue;
    for (Index j = 0; j < n; ++j) work.J(m, j) = in.J_u(i, j);
    work.lambda[m] = in.lambda_max[i];
    work.rhs[m++] = along;
  }
  for (Index i = 0; i < m; ++i)
    for (Index k = 0; k <= i; ++k) {
      work.G(i, k) = 0;
      for (Index j = 0; j < n; ++j) work.G(i, k) += work.J(i, j) * work.J(k, j) / in.stiffness[j];
    }
  if (!factor_cholesky(work.G, m)) return Status::NumericalFailure;
  solve_cholesky(work.G, m, work.rhs.data());
  q_cmd = in.q_track;
  for (Index i = 0; i < m; ++i)
    for (Index j = 0; j < n; ++j) q_cmd[j] -= work.J(i, j) * (work.rhs[i] + work.lambda[i]) / in.stiffness[j];
  return Status::Solved;
}

Status solve_force_equality(const BaselineInput& in, const RowMatrix& H, BaselineWorkspace& work, Eigen::VectorXd& q_cmd) {
  const Index n = in.q.size();
  const double size = in.J_u.row(0).squaredNorm();
  if (!(size > 0)) return Status::NumericalFailure;
  double error = in.lambda_max[0], along = 0;  // aᵀ (q_track − q) + λ_max,  aᵀ H⁻¹ a,  a = K J_u⁺
  for (Index j = 0; j < n; ++j) {
    work.column[j] = in.stiffness[j] * in.J_u(0, j) / size;
    error += work.column[j] * (in.q_track[j] - in.q[j]);
  }
  solve_cholesky(H, n, work.column.data());
  for (Index j = 0; j < n; ++j) along += in.stiffness[j] * in.J_u(0, j) / size * work.column[j];
  q_cmd = in.q_track - error / along * work.column;
  return Status::Solved;
}

}  // namespace stiction::control
