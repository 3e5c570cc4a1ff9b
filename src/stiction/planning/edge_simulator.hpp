#pragma once

#include <limits>
#include <span>

#include "stiction/planning/expansion.hpp"

namespace stiction::planning {

/// What is met along commands, and how much of it is allowed.
struct Worst {
  double penetration = 0, force_gap = 0;  ///< in contact tolerances of their pairs
  double press = 0;                       ///< PressLimits::share

  bool within(const Worst& most) const { return penetration <= most.penetration && force_gap <= most.force_gap && press <= most.press; }
};
inline constexpr double kUnlimited = std::numeric_limits<double>::infinity();
inline constexpr Worst kAnything{kUnlimited, kUnlimited, kUnlimited};

/// Where commands lead at half the sub-step, and the worst that was met on the way.
struct HalfSteps {
  Eigen::VectorXd q, u;
  Worst worst{};
  bool started = false;  ///< what is given may penetrate
};

/// On to a command in two halves, as the checker goes, every step from its state alone: the one such loop of tree and refinement.
/// @param options  of whole sub-steps, without warm start
/// @returns false: a step was not solved, or something worse than allowed was met; `at` is there
bool go_on_in_half_steps(const PressLimits& press, const Eigen::VectorXd& u, const dynamics::StepOptions& options, const Worst& allowed,
                         SimulationScratch& scratch, HalfSteps& at, Work& work);
/// The same along all commands of segments. @returns false also where the run is to stop
bool go_on_in_half_steps(const PressLimits& press, std::span<const Segment> segments, const dynamics::StepOptions& options,
                         const Worst& allowed, const core::RunControl& control, SimulationScratch& scratch, HalfSteps& at, Work& work);
/// Looks at the end of the commands, where no step has looked yet.
bool ends_well(const world::Model& model, const Worst& allowed, contact::GeometryWorkspace& geometry, HalfSteps& at);

/// The contact forces of every sub-step of a segment that starts at q.
void add_forces(const world::Model& model, const dynamics::StepOptions& options, Eigen::VectorXd q, Segment& segment,
                SimulationScratch& scratch, Work& work);

/// Follows commands from a node with the exact dynamics.
class EdgeSimulator {
 public:
  explicit EdgeSimulator(const Setting& setting);

  const dynamics::StepOptions& exact() const { return exact_; }

  /// Exact dynamics from a node towards the command u: sub-steps up to where a contact would slip far at once, or one step as in the thesis.
  bool move(const Node& from, const Eigen::VectorXd& u, ThreadScratch& scratch, Totals& totals, Node& to) const;
  /// The states after the commands of an edge at half its sub-step (n_q × commands); fewer columns where it ended before.
  Eigen::MatrixXd follow_in_half_steps(Eigen::VectorXd q, Eigen::VectorXd u_last, const Eigen::MatrixXd& commands, bool limit_gap,
                                       ThreadScratch& scratch, Totals& totals) const;
  /// Nodes that came to nothing only slow the search down.
  bool moves(const Node& from, const Node& to) const;

 private:
  bool roll_out(const Node& from, const Eigen::VectorXd& u, ThreadScratch& scratch, Totals& totals, Node& to) const;
  /// As in the thesis.
  bool step_once(const Node& from, const Eigen::VectorXd& u, ThreadScratch& scratch, Totals& totals, Node& to) const;
  /// A fragile thing bears it.
  bool spares(std::span<const dynamics::ContactImpulse> contacts) const {
    return setting_.press.share(contacts, setting_.options.h) <= kMostPress;
  }

  const Setting& setting_;
  dynamics::StepOptions exact_, cold_;
};

/// Stores the sub-steps of an edge in its node.
void set_edge(const std::vector<dynamics::Knot>& knots, const world::Model& model, Node& node);

}  // namespace stiction::planning
