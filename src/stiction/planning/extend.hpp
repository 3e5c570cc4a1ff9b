#pragma once

#include "stiction/planning/node_models.hpp"

namespace stiction::planning {

/// Algorithm 3: a push from a node towards a subgoal.
class Extend {
 public:
  Extend(const Setting& setting, const NodeModels& models);

  /// Computes the command of Alg. 3 within joint limits, and simulates it with the exact dynamics.
  /// @param u  the command that is tried; empty if no command was worth it, or if a similar one was tried from this node before
  bool try_edge(const Node& near, Expansion& x, ThreadScratch& scratch, Eigen::VectorXd& u, Node& out) const;
  /// Simulates a push from a node towards a command, as far as the limits of sub-steps, contacts and press allow.
  /// @returns false: no sub-step is left
  bool push(const Node& from, const Eigen::VectorXd& u, ThreadScratch& scratch, Totals& totals, Node& to) const;
  /// δu* of (P.2), limited in length. With `forces`, the smoothed step that gave the local model, (P.7) holds as well.
  /// @param counted  1 per coordinate that the subgoal is about, 0 per coordinate that may have any value (n_vu)
  Eigen::VectorXd extension(const LocalModel& local, const Eigen::VectorXd& q_a, const Eigen::VectorXd& e, const Eigen::VectorXd& counted,
                            const dynamics::StepResult* forces, cone::ConeLeastSquares& least_squares) const;

 private:
  /// False if a push moves and turns next to nothing: such a node only slows the search down.
  bool moves(const Node& from, const Node& to) const;
  /// Adds the constraint that λ + D_λ_u δu is in its friction cone, for every contact of the robot with an object nearer than kForceReach.
  void add_force_cones(const dynamics::StepResult& step, cone::ConeLeastSquares& least_squares) const;

  const Setting& setting_;
  const NodeModels& models_;
  Eigen::VectorXd units_;    // joint units
  Eigen::VectorXd weights_;  ///< W of (P.2) (n_vu)
  double damping_ = 0;       ///< ρ of (P.2)
};

}  // namespace stiction::planning
