#include "stiction/trajopt/cost.hpp"

#include <Eigen/LU>
#include <string>

#include "stiction/core/invalid_input.hpp"
#include "stiction/dynamics/so3.hpp"

namespace stiction::trajopt {
namespace {

using Eigen::VectorXd;
using world::Model;

void require_weights(const char* field, const VectorXd& weights, Eigen::Index size) {
  if (weights.size() != 1) core::require_size(field, weights.size(), size);
  for (Eigen::Index i = 0; i < weights.size(); ++i) {
    core::require_nonnegative(std::string(field) + "[" + std::to_string(i) + "]", weights[i]);
  }
}

VectorXd expand(const VectorXd& weights, Eigen::Index size) {
  return weights.size() == size ? weights : VectorXd::Constant(size, weights[0]);
}

}  // namespace

void Weights::validate(const Model& model) const {
  require_weights("weights.Q", Q, model.n_v());
  require_weights("weights.Qd", Qd, model.n_v());
  require_weights("weights.R", R, model.n_a());
}

Weights Weights::expanded(const Model& model) const { return {expand(Q, model.n_v()), expand(Qd, model.n_v()), expand(R, model.n_a())}; }

CostTerms calc_cost(const Model& model, const Weights& weights, std::span<const VectorXd> reference, std::span<const VectorXd> q,
                    std::span<const VectorXd> u, VectorRef u_before) {
  CostTerms out;
  VectorXd e(model.n_v());
  const std::size_t T = u.size();
  for (std::size_t t = 0; t <= T; ++t) {
    world::local(model, reference[t], q[t], e);
    const VectorXd parts = e.cwiseAbs2().cwiseProduct(t < T ? weights.Q : weights.Qd);
    (t < T ? out.objects : out.objects_final) += parts.head(model.n_vu()).sum();
    (t < T ? out.robots : out.robots_final) += parts.tail(model.n_a()).sum();
  }
  for (std::size_t t = 0; t < T; ++t) {
    const VectorXd change = t == 0 ? VectorXd(u[0] - u_before) : VectorXd(u[t] - u[t - 1]);
    out.input += change.cwiseAbs2().dot(weights.R);
  }
  return out;
}

void expand_state_cost(const Model& model, VectorRef w, VectorRef q_d, VectorRef q, VectorXd& gradient, Eigen::MatrixXd& hessian) {
  gradient.resize(model.n_v());
  world::local(model, q_d, q, gradient);
  hessian = (2 * w).asDiagonal();
  const VectorXd e = gradient;
  gradient = 2 * w.cwiseProduct(e);
  dynamics::for_each_free_rotation(model, [&](int row) {
    // log(exp(e) exp(δ)) ≈ e + J_r(e)⁻¹ δ
    const Eigen::Matrix3d J = dynamics::right_jacobian(e.segment<3>(row)).inverse();
    const Eigen::Matrix3d JtW = 2 * J.transpose() * w.segment<3>(row).asDiagonal();
    gradient.segment<3>(row) = JtW * e.segment<3>(row);
    hessian.block<3, 3>(row, row) = JtW * J;
  });
}

}  // namespace stiction::trajopt
