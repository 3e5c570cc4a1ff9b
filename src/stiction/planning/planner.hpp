#pragma once

#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "stiction/core/run_control.hpp"
#include "stiction/planning/mechanisms.hpp"
#include "stiction/planning/plan.hpp"
#include "stiction/planning/profile.hpp"
#include "stiction/planning/thesis/settings.hpp"
#include "stiction/planning/totals.hpp"
#include "stiction/world/object_space.hpp"

namespace stiction::planning {

struct PlannerOptions {
  std::uint64_t seed = 0;       ///< the same seed gives the same plan
  int threads = 0;              ///< 0 = all cores; the plan does not depend on it
  int max_iterations = 100000;  ///< extensions, ≥ 1
  double goal_bias = 0.6;       ///< probability that the subgoal is the goal (Alg. 2)
  double tolerance_fraction =
      0.9;  ///< a goal counts as reached at this share of its tolerances, at the sub-step and at half of it, in (0, 1]
  std::vector<world::SampleBox> sample_boxes;         ///< where subgoals are drawn; none: default_sample_boxes
  std::optional<dynamics::FrictionLaw> friction_law;  ///< of every exact step; nullopt: Coulomb's law, in a planar scene Anitescu's
  double friction = 1;                                ///< every μ of the plan is that of the scene times this, in (0, 1]
  bool margins = false;                               ///< pushes hold with the objects off, gravity aside and less friction
  bool anytime = false;  ///< go on after the first solution, for cheaper ones, until the deadline or the budget is used up
  std::optional<thesis::Settings> thesis;  ///< Algorithm 2 as printed, for the tables and figures of the thesis
  /// Mechanisms that are left out, for ablations only (bench/search.py); each is 1 << Mechanism.
  unsigned without = 0;

  bool uses(Mechanism mechanism) const { return (without >> static_cast<unsigned>(mechanism) & 1U) == 0; }
  /// Of every exact step of the plan.
  dynamics::StepOptions step_options(const world::Model& model) const;
  /// @throws core::InvalidInput naming the field
  void validate(const world::Model& model) const;
};

struct PlanningProblem {
  std::shared_ptr<const world::Model> model;
  Eigen::VectorXd q_start;  ///< (n_q)
  Goal goal;
  Eigen::VectorXd
      q_goal;  ///< configuration of the objects at the goal (n_qu); empty: it follows from goal.X_WG, if the object moves freely
               ///< or relative to the world
  double start_may_move = std::numeric_limits<double>::infinity();  ///< objects, until they rest at the start [tolerances of the goal]
  /// @throws core::InvalidInput: sizes, tolerances, a goal inside a fixed body or outside the range of the object's joint
  void validate() const;
};

/// A node of the tree as a user sees it.
struct TreeNode {
  int parent = -1;  ///< index in PlanResult::tree; −1 for the root
  SegmentKind edge = SegmentKind::Contact;
  world::Pose X_WB;  ///< of the goal's object
};

/// A node as it entered the tree.
struct NodeRecord {
  int parent = -1;
  SegmentKind edge = SegmentKind::Contact;  ///< that leads to it
  long iteration = 0;                       ///< extensions up to the end of its round
  Eigen::VectorXd q;                        ///< (n_q)
  Eigen::VectorXd c_u;                      ///< smoothed next configuration of the objects (n_qu)
  Eigen::MatrixXd B_u;                      ///< their rows of B (n_vu × n_a)
};

/// Moves to new contacts from one node of a tree, of which some were refused.
struct RefusedMoves {
  Eigen::VectorXd q;  ///< of the node (n_q)
  RegraspCounts counts;
};

/// A solution that was better than those before.
struct Improvement {
  double cost = 0;  ///< [s] PathCost
  long iterations = 0;
  double wall_s = 0;
};

struct PlanResult {
  core::Status status = core::Status::NumericalFailure;  ///< Solved | MaxIterations (deadline or budget) | Cancelled | …
  Plan plan;                                             ///< best so far, also when not Solved
  std::uint64_t seed = 0;
  long iterations = 0;
  long nodes = 0;
  long steps = 0;           ///< exact steps computed
  long linearisations = 0;  ///< smoothed steps with B
  long failed_steps = 0;    ///< steps whose solve did not end in Solved
  long distrusted = 0;      ///< edges given up because half the sub-step gave something else
  RegraspCounts regrasps;
  /// Where moves to new contacts were refused until there was a plan; of Algorithm 2 as printed nothing.
  std::vector<RefusedMoves> refused;
  Profile profile;                        ///< processor time by activity; of Algorithm 2 as printed nothing
  double cost = 0;                        ///< of the plan, by PathCost [s]
  std::vector<Improvement> improvements;  ///< solutions in the order found; their cost falls
  std::vector<NodeRecord> records;        ///< all nodes of Algorithm 2 as printed (PlannerOptions::thesis), the root first
  double wall_s = 0;
  std::vector<TreeNode> tree;    ///< all nodes, in the order of their making
  std::string reason;            ///< why not Solved, where there is more to say than that the budget was used up
  bool start_slips = false;      ///< by more than the problem lets it: nothing was searched
  double start_moved = 0;        ///< how far objects moved before they rested, the larger of [m] and [rad]; > 1e-3: the start is no rest
  double start_penetration = 0;  ///< [m] deepest penetration of the given start, ≥ 0
  bool start_projected = false;  ///< the start was moved to the constraints first (Settle segment)
};

/// Plans a path of the object to the goal with a tree through contact (Algorithms 2 and 3 with real regrasps). Anytime: trees are grown one
/// after the other, each from its own substream and without nodes that cost more to come to than the best path found before.
/// @returns Solved: the goal is within tolerance, also when the commands are simulated at half the sub-step;
///          anytime, also when the deadline or the budget ended the search for better ones;
///          MaxIterations: deadline, or iteration budget, or no branch of the robots can touch an object (`result.reason`); Cancelled;
///          NumericalFailure: the objects do not come to rest at the start. `result.plan` is the best path found in any case.
/// @throws  InvalidInput, also for a goal inside a fixed body or outside the range of the object's joint
core::Status plan(const PlanningProblem& problem, const PlannerOptions& options, const core::RunControl& control, PlanResult& result);

/// plan() from a start at which the robots are commanded elsewhere than where they are, as they were measured: their springs keep their strain, and a grip its
/// force. Overlaps are moved apart, and commands beyond the motors taken back, before the search begins (settle_start.hpp).
/// @param u_start  commands at the start (n_a) [rad or m]; empty: joints are commanded where they are
/// @returns as plan(); NumericalFailure: the start does not come to rest, `result.reason` says why
/// @throws  core::InvalidInput, as plan()
core::Status plan_from(const PlanningProblem& problem, const Eigen::VectorXd& u_start, const PlannerOptions& options,
                       const core::RunControl& control, PlanResult& result);

/// Nodes that a tree gained since it was last told of.
struct Growth {
  int tree = 0;              ///< of the run, counted from 0: trees grow side by side, and one that stalls makes room for the next
  int first = 0;             ///< number of the first of these nodes in their tree
  std::vector<int> parents;  ///< numbers of nodes in the tree, -1 of the root
  Eigen::MatrixXd q;         ///< (n_q × nodes) [m, rad]
  Eigen::MatrixXd u;         ///< commands at q (n_a × nodes) [m or rad]
  int best = -1;             ///< node of the tree that is nearest the goal
  double best_ratio = 0;     ///< how far that one is, in tolerances
};
using GrowthSink = std::function<void(const Growth&)>;
/// Told of the first plan that solves the problem and, anytime, of every cheaper one, as it is found: `result` as it would be if the run ended now, but for
/// its totals.
using PlanSink = std::function<void(const PlanResult& result)>;

/// plan_from(), told between rounds how its trees grow, by the thread that called it. Trees that look for a cheaper path (anytime) are not told of.
/// Every node of the tree whose path is the plan is told of once; the plan is that of plan_from(), to the last bit.
/// @param found    called by the same thread; may be empty
/// @param u_start  commands at the start (n_a) [rad or m]; empty: joints are commanded where they are
/// @throws core::InvalidInput, as plan_from()
core::Status plan_watched(const PlanningProblem& problem, const Eigen::VectorXd& u_start, const PlannerOptions& options,
                          const core::RunControl& control, const GrowthSink& grown, PlanResult& result, const PlanSink& found = {});

}  // namespace stiction::planning
