#pragma once

#include <Eigen/Core>
#include <functional>
#include <span>
#include <vector>

#include "stiction/planning/contact_sampler.hpp"
#include "stiction/planning/planner.hpp"

namespace stiction::planning {

/// Joint-space path between two postures of the robot at a fixed object.
enum class PathOutcome {
  Found,
  StartBlocked,
  GoalBlocked,
  NotFound
};

struct PathOptions {
  double clearance = 2e-3;   ///< kept to everything between leaving the first contacts and reaching the last [m]
  double step = 0.3;         ///< length of a tree extension, largest joint [rad, L of the robots]
  int max_extensions = 150;  ///< of either tree towards random postures
  int shortcuts = 12;        ///< attempts
};

/// Collision-free path of the branches in `moving` from the robot posture in q to q_a_goal: out of contact (retreat), through free
/// space (bidirectional RRT, Kuffner & LaValle 2000, with shortcuts) and back into contact. The objects stay where q has them.
/// @param path  postures after the start, the last one is q_a_goal (n_a each)
PathOutcome find_path(const world::Model& model, const RobotChains& chains, ChainMask moving, const Eigen::VectorXd& q,
                      const Eigen::VectorXd& q_a_goal, const PathOptions& options, core::Random& random, GeometryWorkspace& work,
                      std::vector<Eigen::VectorXd>& path);

/// The same among objects of which each of `places` is one where they may be: nothing on the way touches them at any.
/// @param places  configurations, of which those of the objects count (n_q each), at least one
PathOutcome find_path(const world::Model& model, const RobotChains& chains, ChainMask moving, std::span<const Eigen::VectorXd> places,
                      const Eigen::VectorXd& q_a_start, const Eigen::VectorXd& q_a_goal, const PathOptions& options, core::Random& random,
                      GeometryWorkspace& work, std::vector<Eigen::VectorXd>& path);

/// All forces of a sub-step lie in friction cones with every μ times this. It is then the solution with those cones too: it stays feasible, since v_n ≥ μ‖v_t‖
/// only gets weaker, and complementary.
bool fits_cones(const dynamics::Knot& knot, double friction_scale);

/// Every branch that goes elsewhere in a regrasp, 0.1 rad or L, touches nothing from when it first is 0.01 L away from everything to when it last is, as the
/// checker demands. A path keeps its clearance; springs that give way do not follow it exactly.
bool is_free_on_its_way(const world::Model& model, const RobotChains& chains, const std::vector<dynamics::Knot>& knots,
                        GeometryWorkspace& work);

/// A regrasp that was simulated and holds.
struct Regrasp {
  std::vector<dynamics::Knot> knots;  ///< at full friction
  int steps = 0;                      ///< dynamics steps computed
  long failed_steps = 0;
  bool stuck = false;  ///< the drawn branches cannot let go of the object at this node: no sample can help
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

/// Tries one regrasp at (q, u): the branches of `draw` let go and back off, a contact sample is drawn where the object comes to rest, and
/// they move there and hold until the object rests in the new grip; all simulated with the exact dynamics, at full friction and at
/// options.regrasp_friction of it. The object must stay within options.release_tol_* while it is let go and within options.regrasp_tol_* of
/// where it came to rest from then on. Branches that do not move keep their grip; where the object does not stay with that, everything
/// lets go first.
/// @param judge   of options.grasp_candidates postures the one that promises most and has a path is taken; options.grasp_trials of those that
///                promise most are simulated before, and the others come after them
/// @param counts  the outcome is counted by cause
bool try_regrasp(const world::Model& model, const RobotChains& chains, const PlannerOptions& options, const Eigen::VectorXd& q,
                 const Eigen::VectorXd& u, const GraspDraw& draw, const GraspJudge& judge, core::Random& random,
                 GeometryWorkspace& geometry, dynamics::StepWorkspace& steps, Regrasp& out, RegraspCounts& counts);

}  // namespace stiction::planning
