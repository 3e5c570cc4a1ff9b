#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "stiction/world/model.hpp"

namespace stiction::trajopt {

using VectorRef = Eigen::Ref<const Eigen::VectorXd>;

/// Diagonal weights of (T.1) in tangent coordinates [1/m² or 1/rad²], ≥ 0. Each field has one number for all coordinates, or one per
/// coordinate.
struct Weights {
  Eigen::VectorXd Q = Eigen::VectorXd::Constant(1, 1.0);     ///< weight of q_t, t = 0 … T − 1 (n_v)
  Eigen::VectorXd Qd = Eigen::VectorXd::Constant(1, 100.0);  ///< weight of q_T (n_v)
  Eigen::VectorXd R = Eigen::VectorXd::Constant(1, 1.0);     ///< weight of the change of command u_t − u_{t−1} (n_a)
  void validate(const world::Model& model) const;            ///< @throws core::InvalidInput naming the field
  Weights expanded(const world::Model& model) const;         ///< copy in which every field has one number per coordinate
};

/// Parts of the cost (T.1).
struct CostTerms {
  double objects = 0;                   ///< Σ_{t<T} ‖q_t ⊖ q_t^d‖²_Q over the coordinates of the objects
  double objects_final = 0;             ///< ‖q_T ⊖ q_T^d‖²_Qd over the coordinates of the objects
  double robots = 0, robots_final = 0;  ///< the same two terms over the coordinates of the robots
  double input = 0;                     ///< Σ ‖u_t − u_{t−1}‖²_R
  double total() const { return objects + objects_final + robots + robots_final + input; }
};

/// Cost (T.1) of a trajectory.
/// @param weights  as from Weights::expanded()  @param reference  T + 1 configurations
/// @param q  T + 1 configurations  @param u  T commands  @param u_before  u_{−1}
CostTerms calc_cost(const world::Model& model, const Weights& weights, std::span<const Eigen::VectorXd> reference,
                    std::span<const Eigen::VectorXd> q, std::span<const Eigen::VectorXd> u, VectorRef u_before);

/// Gauss–Newton expansion of ‖(q ⊕ δ) ⊖ q_d‖²_w ≈ const + gradientᵀδ + ½ δᵀ hessian δ (T.2). @param w (n_v)
void expand_state_cost(const world::Model& model, VectorRef w, VectorRef q_d, VectorRef q, Eigen::VectorXd& gradient,
                       Eigen::MatrixXd& hessian);

}  // namespace stiction::trajopt
