#pragma once

#include <Eigen/Core>
#include <functional>
#include <span>
#include <vector>

#include "stiction/planning/setting.hpp"

namespace stiction::planning {

/// All forces of a sub-step lie in friction cones with every μ times this. It is then the solution with those cones too: it stays feasible, since v_n ≥ μ‖v_t‖
/// only gets weaker, and complementary.
bool fits_cones(const dynamics::Knot& knot, double friction_scale);

/// How objects come through a part of a regrasp.
enum class Outcome {
  Held,
  Moved,
  Failed  ///< a step was not solved
};

/// The objects do the same with every μ at options.regrasp_friction of it, up to options.regrasp_tol_*. Steps that fit the smaller cones are the same, so that
/// the first ones that do are not simulated again.
/// @param q, knots  a regrasp from q (n_q), simulated with `full`
Outcome holds_slippery(const Setting& setting, Eigen::VectorXd q, std::span<const dynamics::Knot> knots, const dynamics::StepOptions& full,
                       SimulationScratch& scratch, Work& work);

/// Every branch that goes elsewhere in a regrasp, 0.1 rad or L, touches nothing from when it first is 0.01 L away from everything to when it last is, as the
/// checker demands. A path keeps its clearance; springs that give way do not follow it exactly.
bool is_free_on_its_way(const world::Model& model, const world::RobotChains& chains, const std::vector<dynamics::Knot>& knots,
                        contact::GeometryWorkspace& work);

/// Branches that let go of the objects.
struct Release {
  world::ChainMask moved = 0;  ///< 0: no branch of the robots can touch an object
  bool loose = false;          ///< the objects need not stay with gravity aside meanwhile
};

/// A regrasp that was simulated and holds.
struct Regrasp : Work {
  std::vector<dynamics::Knot> knots;  ///< at full friction
  bool stuck = false;                 ///< the drawn branches cannot let go of the object at this node: no sample can help
  bool loose = false;                 ///< meanwhile an object would not stay with gravity aside
};

/// What a posture that was drawn is good for.
struct Promise {
  double distance;          ///< of the objects from their subgoal after the extension, lower is better
  Eigen::VectorXd command;  ///< of that extension (n_a)
};

/// How postures that were drawn are told apart. Empty functions: they are taken as they come.
struct GraspJudge {
  std::function<Promise(const Eigen::VectorXd& q)> promise;                                   ///< by a local model
  std::function<double(const Eigen::VectorXd& q, const Eigen::VectorXd& command)> simulated;  ///< what comes of it
};

/// Objects that move by less than this in a step of the plan rest [L of the robots] and [rad]; a command is held for so many of them at most.
inline constexpr double kRestingMove = 1e-4, kRestingTurn = 1e-5;
inline constexpr int kMostHeld = 20;
/// While branches are away from an object, it stays with gravity this far aside, from four sides [rad]: pulled by a tenth of its weight, as by the inertia of what moves under it.
inline constexpr double kAside = 0.1;

/// Tries one regrasp at (q, u): the branches of `release` let go and back off, a contact sample is drawn where the object comes to rest, and
/// they move there and hold until the object rests in the new grip; all simulated with the exact dynamics, at full friction and at
/// options.regrasp_friction of it. The object must stay within options.release_tol_* while it is let go and within options.regrasp_tol_* of
/// where it came to rest from then on. Branches that do not move keep their grip; where the object does not stay with that, everything
/// lets go first.
/// @param judge   of options.grasp_candidates postures the one that promises most and has a path is taken; options.grasp_trials of those that
///                promise most are simulated before, and the others come after them
/// @param counts  the outcome is counted by cause
bool try_regrasp(const Setting& setting, const Eigen::VectorXd& q, const Eigen::VectorXd& u, const Release& release,
                 const GraspJudge& judge, core::Random& random, SimulationScratch& scratch, Regrasp& out, RegraspCounts& counts);

}  // namespace stiction::planning
