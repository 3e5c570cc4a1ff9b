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
  std::uint64_t seed = 0;           ///< seed of all random draws: the same seed gives the same plan
  int threads = 0;                  ///< number of threads, 0 = all cores; the plan does not depend on it
  int max_iterations = 100000;      ///< budget of extensions, ≥ 1
  double goal_bias = 0.6;           ///< probability that the subgoal is the goal (Alg. 2)
  double tolerance_fraction = 0.9;  ///< share of the goal's tolerances that a plan must meet, at whole and at half sub-steps, in (0, 1]
  std::vector<world::SampleBox> sample_boxes;         ///< boxes from which subgoals are drawn; empty: default_sample_boxes
  std::optional<dynamics::FrictionLaw> friction_law;  ///< nullopt: Anitescu's law in a planar scene or with `thesis`, else Coulomb's
  double friction = 1;                                ///< factor on every friction coefficient μ of the scene, in (0, 1]
  bool margins = false;                               ///< pushes must also hold with displaced objects, tilted gravity and less friction
  bool anytime = false;                    ///< after the first plan, search for cheaper ones until the deadline or the end of the budget
  std::optional<thesis::Settings> thesis;  ///< Algorithm 2 as printed, for the tables and figures of the thesis
  /// Bit mask of the mechanisms that are left out (1 << Mechanism). For ablations only (bench/search.py).
  unsigned without = 0;

  bool uses(Mechanism mechanism) const { return (without >> static_cast<unsigned>(mechanism) & 1U) == 0; }
  /// Options of every exact step of the plan.
  dynamics::StepOptions step_options(const world::Model& model) const;
  /// @throws core::InvalidInput naming the field
  void validate(const world::Model& model) const;
};

struct PlanningProblem {
  std::shared_ptr<const world::Model> model;
  Eigen::VectorXd q_start;  ///< start configuration (n_q)
  Goal goal;
  /// Goal configuration of the objects (n_qu). Empty: computed from goal.X_WG, if the object is free or its joint is attached to the world.
  Eigen::VectorXd q_goal;
  double start_may_move = std::numeric_limits<double>::infinity();  ///< limit on object motion at the start [tolerances of the goal]
  /// @throws core::InvalidInput for sizes, tolerances, and a goal inside a fixed body or outside the range of the object's joint
  void validate() const;
};

/// A node of the tree as a result shows it.
struct TreeNode {
  int parent = -1;  ///< index in PlanResult::tree; −1 for the root
  SegmentKind edge = SegmentKind::Contact;
  world::Pose X_WB;  ///< pose of the goal's object
};

/// A node of Algorithm 2 as printed, as it entered the tree.
struct NodeRecord {
  int parent = -1;
  SegmentKind edge = SegmentKind::Contact;  ///< kind of the edge that leads to the node
  long iteration = 0;                       ///< number of extensions when the node entered the tree
  Eigen::VectorXd q;                        ///< (n_q)
  Eigen::VectorXd c_u;                      ///< smoothed next configuration of the objects (n_qu)
  Eigen::MatrixXd B_u;                      ///< rows of B that belong to the objects (n_vu × n_a)
};

/// Regrasps that were rejected at one node of a tree.
struct RefusedMoves {
  Eigen::VectorXd q;     ///< configuration of the node (n_q)
  RegraspCounts counts;  ///< number of regrasps by outcome
};

/// A plan that is cheaper than all plans found before.
struct Improvement {
  double cost = 0;  ///< path cost [s], see PathCost
  long iterations = 0;
  double wall_s = 0;
};

struct PlanResult {
  core::Status status = core::Status::NumericalFailure;  ///< Solved | MaxIterations (deadline or budget) | Cancelled | …
  Plan plan;                                             ///< best plan so far, also when not Solved
  std::uint64_t seed = 0;
  long iterations = 0;
  long nodes = 0;
  long steps = 0;           ///< number of exact steps computed
  long linearisations = 0;  ///< number of smoothed steps with B
  long failed_steps = 0;    ///< number of steps whose solve did not end in Solved
  long distrusted = 0;      ///< number of edges rejected because half the sub-step gave another result
  RegraspCounts regrasps;
  /// Nodes at which regrasps were rejected, until a plan was found. Empty for Algorithm 2 as printed.
  std::vector<RefusedMoves> refused;
  Profile profile;                        ///< processor time by activity; empty for Algorithm 2 as printed
  double cost = 0;                        ///< cost of `plan` [s], see PathCost
  std::vector<Improvement> improvements;  ///< plans in the order found; each costs less than the one before
  std::vector<NodeRecord> records;        ///< all nodes of Algorithm 2 as printed (PlannerOptions::thesis), the root first
  double wall_s = 0;
  std::vector<TreeNode> tree;    ///< all nodes, in the order in which they were made
  std::string reason;            ///< why the search failed, if there is more to say than that the budget was used up
  bool start_slips = false;      ///< objects move farther at the start than start_may_move; nothing was searched
  double start_moved = 0;        ///< motion of objects before they rested, the larger of [m] and [rad]; > 1e-3: no rest at the start
  double start_penetration = 0;  ///< deepest penetration at the given start, ≥ 0 [m]
  bool start_projected = false;  ///< the start was first moved until it met the constraints (Settle segment)
};

/// Plans a path of the object to the goal with trees through contact (Algorithms 2 and 3 with real regrasps). With `anytime`, further trees
/// are grown one after the other, each from its own random substream, without nodes that are as expensive to reach as the best path so far.
/// @returns Solved: the goal is within tolerance, also when the commands are simulated at half the sub-step. With `anytime`, the search for
///          cheaper plans may have ended by the deadline or by the budget. MaxIterations: the deadline or the iteration budget is used up,
///          or no branch of the robots can touch an object (`result.reason`). Cancelled. NumericalFailure: the objects do not come to rest
///          at the start. In each case `result.plan` is the best path found.
/// @throws  InvalidInput, also for a goal inside a fixed body or outside the range of the object's joint
core::Status plan(const PlanningProblem& problem, const PlannerOptions& options, const core::RunControl& control, PlanResult& result);

/// plan() from a start with given commands, such as measured ones: the springs keep their strain, and a grip keeps its force. Before the
/// search begins, overlapping bodies are moved apart, and commands beyond the motors are reduced (settle_start.hpp).
/// @param u_start  commands at the start (n_a) [rad or m]; empty: the positions of the joints
/// @returns as plan(); NumericalFailure: the start does not come to rest, and `result.reason` says why
/// @throws  core::InvalidInput, as plan()
core::Status plan_from(const PlanningProblem& problem, const Eigen::VectorXd& u_start, const PlannerOptions& options,
                       const core::RunControl& control, PlanResult& result);

/// Nodes that a tree gained since the last report of its growth.
struct Growth {
  int tree = 0;              ///< number of the tree in the run, from 0; trees grow side by side, and a new tree replaces one that stalls
  int first = 0;             ///< number of the first of these nodes in the tree
  std::vector<int> parents;  ///< node number of each parent in the tree, −1 for the root
  Eigen::MatrixXd q;         ///< configurations (n_q × nodes) [m, rad]
  Eigen::MatrixXd u;         ///< commands at q (n_a × nodes) [m or rad]
  int best = -1;             ///< number of the node that is nearest to the goal
  double best_ratio = 0;     ///< distance of that node from the goal, in tolerances
};
using GrowthSink = std::function<void(const Growth&)>;
/// Receives the first plan that solves the problem and, with `anytime`, every cheaper plan as soon as it is found. Except for its totals,
/// `result` is what plan() would return if the run ended now.
using PlanSink = std::function<void(const PlanResult& result)>;

/// plan_from() that also reports the growth of its trees, between rounds and on the calling thread. Trees that search for cheaper plans are
/// not reported. Every node of the tree that gives the plan is reported once. The plan is that of plan_from(), to the last bit.
/// @param found    called by the same thread; may be empty
/// @param u_start  commands at the start (n_a) [rad or m]; empty: the positions of the joints
/// @throws core::InvalidInput, as plan_from()
core::Status plan_watched(const PlanningProblem& problem, const Eigen::VectorXd& u_start, const PlannerOptions& options,
                          const core::RunControl& control, const GrowthSink& grown, PlanResult& result, const PlanSink& found = {});

}  // namespace stiction::planning
