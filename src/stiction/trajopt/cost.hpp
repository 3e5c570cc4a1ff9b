#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "stiction/world/model.hpp"

namespace stiction::trajopt {

using VectorRef = Eigen::Ref<const Eigen::VectorXd>;

/// Diagonal weights of (T.1), in tangent coordinates: per m² and rad². Each has one number for all, or one per coordinate; ≥ 0.
struct Weights {
  Eigen::VectorXd Q = Eigen::VectorXd::Constant(1, 1.0);     ///< of q_t, t = 0 … T − 1 (n_v)
  Eigen::VectorXd Qd = Eigen::VectorXd::Constant(1, 100.0);  ///< of q_T (n_v)
  Eigen::VectorXd R = Eigen::VectorXd::Constant(1, 1.0);     ///< of the change of the command u_t − u_{t−1} (n_a)
  void validate(const world::Model& model) const;            ///< @throws core::InvalidInput naming the field
  Weights expanded(const world::Model& model) const;         ///< all with one number per coordinate
};

/// Parts of (T.1).
struct CostTerms {
  double objects = 0;        ///< Σ_{t<T} ‖q_t ⊖ q_t^d‖²_Q over the coordinates of the objects
  double objects_final = 0;  ///< ‖q_T ⊖ q_T^d‖²_Qd over the same
  double robots = 0, robots_final = 0;
  double input = 0;  ///< Σ ‖u_t − u_{t−1}‖²_R
  double total() const { return objects + objects_final + robots + robots_final + input; }
};

/// (T.1) of a trajectory. @param weights expanded  @param q T + 1 configurations  @param u T commands
/// @param reference T + 1 configurations  @param u_before u_{−1}
CostTerms calc_cost(const world::Model& model, const Weights& weights, std::span<const Eigen::VectorXd> reference,
                    std::span<const Eigen::VectorXd> q, std::span<const Eigen::VectorXd> u, VectorRef u_before);

/// Gauss–Newton expansion of ‖(q ⊕ δ) ⊖ q_d‖²_w ≈ const + gradientᵀδ + ½ δᵀ hessian δ (T.2). @param w (n_v)
void expand_state_cost(const world::Model& model, VectorRef w, VectorRef q_d, VectorRef q, Eigen::VectorXd& gradient,
                       Eigen::MatrixXd& hessian);

}  // namespace stiction::trajopt
