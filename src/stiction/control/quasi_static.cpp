#include "stiction/control/quasi_static.hpp"

#include <Eigen/Cholesky>

#include "stiction/core/invalid_input.hpp"

namespace stiction::control {

using core::Status;
using Eigen::Index;

namespace {

void require(VectorRef K, MatrixRef J_u) {
  core::require_size("J_u.cols", J_u.cols(), K.size());
  for (const double k : K) core::require_positive("K", k);
}

/// Factor of J_u K⁻¹ J_uᵀ; rows that depend on each other leave a pivot of rounding alone.
bool factor_compliance(VectorRef K, MatrixRef J_u, Eigen::LLT<Eigen::MatrixXd>& llt) {
  const Eigen::MatrixXd G = J_u * K.cwiseInverse().asDiagonal() * J_u.transpose();
  llt.compute(G);
  const double rounding = static_cast<double>(K.size()) * Eigen::NumTraits<double>::epsilon();
  return llt.info() == Eigen::Success && (G.rows() == 0 || llt.rcond() > rounding);
}

}  // namespace

Status calc_stiffness_consistent_inverse(VectorRef K, MatrixRef J_u, Eigen::MatrixXd& out) {
  require(K, J_u);
  Eigen::LLT<Eigen::MatrixXd> llt;
  if (!factor_compliance(K, J_u, llt)) return Status::NumericalFailure;
  out = (llt.solve(Eigen::MatrixXd(J_u * K.cwiseInverse().asDiagonal()))).transpose();
  return Status::Solved;
}

Status calc_equilibrium(VectorRef K, MatrixRef J_u, VectorRef q, VectorRef u, Equilibrium& out) {
  require(K, J_u);
  core::require_size("q", q.size(), K.size());
  core::require_size("u", u.size(), K.size());
  Eigen::LLT<Eigen::MatrixXd> llt;
  if (!factor_compliance(K, J_u, llt)) return out.status = Status::NumericalFailure;
  out.lambda = -llt.solve(Eigen::VectorXd(J_u * (u - q)));
  out.q = u + K.cwiseInverse().cwiseProduct(J_u.transpose() * out.lambda);
  return out.status = Status::Solved;
}

}  // namespace stiction::control
