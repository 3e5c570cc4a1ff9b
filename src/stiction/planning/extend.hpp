#pragma once

#include "stiction/planning/node_models.hpp"

namespace stiction::planning {

/// Algorithm 3.
class Extend {
 public:
  Extend(const Setting& setting, const NodeModels& models);

  /// Alg. 3 with joint limits, rolled out exactly.
  /// @param u  the command that is tried; empty where none was worth it, or one like it was tried from this node before
  bool try_edge(const Node& near, Expansion& x, ThreadScratch& scratch, Eigen::VectorXd& u, Node& out) const;
  /// From a node towards a command with the exact dynamics, as far as limits of sub-steps, contacts and press allow.
  /// @returns false: nothing is left
  bool push(const Node& from, const Eigen::VectorXd& u, ThreadScratch& scratch, Totals& totals, Node& to) const;
  /// δu* of (P.2), cut or stretched to its length; with `forces`, the smoothed step that gave the local model, also (P.7).
  /// @param counted  1 per coordinate that it is about; those that are 0 may go anywhere (n_vu)
  Eigen::VectorXd extension(const LocalModel& local, const Eigen::VectorXd& q_a, const Eigen::VectorXd& e, const Eigen::VectorXd& counted,
                            const dynamics::StepResult* forces, cone::ConeLeastSquares& least_squares) const;

 private:
  /// A push that turns and moves next to nothing only slows the search down.
  bool moves(const Node& from, const Node& to) const;
  /// λ + D_λ_u δu in its friction cone, for every contact of the robot with an object that is nearer than kForceReach.
  void add_force_cones(const dynamics::StepResult& step, cone::ConeLeastSquares& least_squares) const;

  const Setting& setting_;
  const NodeModels& models_;
  Eigen::VectorXd units_;    // of the joints
  Eigen::VectorXd weights_;  ///< W of (P.2) (n_vu)
  double damping_ = 0;       ///< ρ of (P.2)
};

}  // namespace stiction::planning
