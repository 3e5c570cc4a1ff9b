#pragma once

#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "stiction/contact/contact_sampler.hpp"
#include "stiction/core/run_control.hpp"
#include "stiction/dynamics/local_model.hpp"
#include "stiction/planning/plan.hpp"
#include "stiction/world/object_space.hpp"

namespace stiction::planning {

/// Ways to the local model of a node (2.4.1).
enum class Scheme {
  Exact,             ///< no smoothing: the first ablation of 3.5
  Analytic,          ///< `smoothing`
  RandomizedFirst,   ///< `randomized`, averaged derivatives (2.22)
  RandomizedZeroth,  ///< `randomized`, least squares (2.23)
};

/// Metric of Nearest.
struct LocalMetric {};  ///< (3.5): every node has its own
struct GlobalMetric {
  double position = 1;  ///< [1/m²] > 0
  double angle = 1;     ///< [1/rad²] > 0
};                      ///< Σ wᵢ eᵢ² with e = q_subgoal ⊖ qᵘ of the node, the same everywhere: the ablation Global of 3.5
using Metric = std::variant<LocalMetric, GlobalMetric>;

/// Length rule of Extend (Alg. 3).
struct FixedLength {
  double length = 0.3;
};  ///< ‖δu‖ is always this [rad or m]
struct CappedLength {
  double length = 0.3;
};  ///< at most this, with joints that slide measured by L of the robots (world::Scales::joint)
using LengthRule = std::variant<CappedLength, FixedLength>;

struct PlannerOptions {
  std::uint64_t seed = 0;
  int threads = 0;                 ///< 0 = all cores; the result does not depend on it
  int trees = 2;                   ///< that grow side by side, ≥ 1; the result does depend on it. One where it does not stop at the goal
  int batch = 8;                   ///< extensions under way at once, ≥ 1, the same number in each tree; the result does depend on it
  int max_iterations = 100000;     ///< extensions, ≥ 1
  bool stop_at_goal = true;        ///< false: always run max_iterations (timing)
  double goal_bias = 0.3;          ///< probability that the subgoal is the goal
  double grasp_probability = 0.3;  ///< probability that a node gets a contact sample instead of an extension
  double gamma = 1e-6;             ///< γ of the metric (3.5)
  LengthRule length = CappedLength{};
  Scheme scheme = Scheme::Analytic;  ///< of local models (3.3)
  dynamics::Analytic smoothing;
  dynamics::Sampling randomized;  ///< the seed is not used: every node has a substream of that of the plan
  Metric metric = LocalMetric{};
  double goal_sharpening = 10;  ///< κ grows (disturbances shrink) up to this factor as the object comes within as many tolerances of the
                                ///< goal, ≥ 1
  double h = 0.1;               ///< time step of every model [s]
  dynamics::Regularisation regularisation = dynamics::ByRule{};
  std::optional<dynamics::SubstepLimits> substep = dynamics::SubstepLimits{};  ///< nullopt: one single step per extension
  int grasp_candidates = 6;  ///< postures drawn for a regrasp, ≥ 1; the one that promises to bring the object nearest its subgoal is taken
  int grasp_trials = 0;      ///< … after so many of those that promise most were simulated: then by what came of it, ≥ 0
  bool real_regrasps = true;  ///< false: the robot jumps to its contact sample, as in the thesis's trees
  dynamics::FrictionLaw friction_law = dynamics::FrictionLaw::Anitescu;  ///< of every exact step of the plan
  double friction = 1.0;  ///< every μ of the plan is that of the scene times this: what slips in the world then slips in the plan as well
  double grip_force =
      0.0;  ///< extensions start with the springs as strained as they are, up to this at the reach of a joint (P.11) [N], ≥ 0
  /// Pushes end before the robot presses on itself or on what does not move with more than this [N], > 0.
  double brace_force = std::numeric_limits<double>::infinity();
  double regrasp_friction = 0.8;       ///< regrasps must hold with every μ times this
  double regrasp_clearance = 2e-3;     ///< that moving branches keep to everything between their contacts [m]
  double regrasp_tol_position = 2e-3;  ///< the object may move this much while branches move to their new contacts [m]
  double regrasp_tol_angle = 0.02;     ///< [rad]
  double release_tol_position = 5e-3;  ///< … and this much while they let go of it before: it settles on what is left [m]
  double release_tol_angle = 0.1;      ///< [rad]
  contact::GenericSampler sampler;
  std::vector<world::SampleBox> sample_boxes;  ///< none: default_sample_boxes
  double fidelity_edge = 0.15;  ///< a node is built on only if half the sub-step moves the object to the same place, up to this
                                ///< share of the goal's tolerances on its own edge …
  double fidelity_path = 0.8;   ///< … and up to this share on the whole path from the start
  double start_noise = 0;  ///< nodes that are built on are reached, and so is the goal, when pushes start with the objects off by up to
                           ///< this share of the goal's tolerances, ≥ 0 …
  /// … when gravity comes from this far aside, from another side in each of these four paths [rad], in [0, π/2): what a hand balances at a rim swings out …
  double edge_tilt = 0;
  double friction_noise = 0;  ///< … and when μ is less by this share at half of what touches (calc_friction_factors), in [0, 1)
  bool anytime = false;       ///< go on after the first solution, for cheaper ones, until the deadline or the budget of iterations
  PathCost cost;
  bool record_tree = false;                ///< keep every node in PlanResult::records
  double tolerance_fraction = 0.9;         ///< a goal counts as reached at this share of its tolerances, at the sub-step and at half of it
  std::optional<double> refined_fraction;  ///< … and for refined plans at this, in [tolerance_fraction, 1]; without it at the same
  /// Share of the tolerances at which refined plans, and what half the sub-steps of a plan come to, are at the goal.
  double share_when_refined() const { return refined_fraction.value_or(tolerance_fraction); }
  /// Single steps or jumps, as in the thesis: edges that nothing but the checker of that chapter looks at.
  bool thesis_edges() const { return !substep || !real_regrasps; }
  /// Pushes hold with objects a little off, gravity a little aside or less friction.
  bool margins() const { return start_noise > 0 || edge_tilt > 0 || friction_noise > 0; }
  void set_margins(bool on);  ///< start_noise, edge_tilt and friction_noise: the defaults, or none
  /// Of a node. @param stream  of the samples  @param sharpening  ≥ 1: κ times this, or disturbances divided by it
  dynamics::LocalModelScheme local_model_scheme(std::uint64_t stream, double sharpening = 1) const;
  dynamics::StepOptions step_options() const;  ///< of every exact step of the plan
  void validate(const world::Model& model) const;
};

struct PlanningProblem {
  std::shared_ptr<const world::Model> model;
  Eigen::VectorXd q_start;  ///< (n_q)
  Goal goal;
  Eigen::VectorXd
      q_goal;  ///< configuration of the objects at the goal (n_qu); empty: it follows from goal.X_WG, if the object moves freely
               ///< or relative to the world
  /// @throws core::InvalidInput: sizes, tolerances, a goal inside a fixed body or outside the range of the object's joint
  void validate() const;
};

/// How regrasp attempts ended.
struct RegraspCounts {
  long tried = 0, accepted = 0;
  long no_sample = 0;     ///< no posture in contact was found
  long no_path = 0;       ///< no collision-free path
  long object_moved = 0;  ///< the object did not stay where it was
  long failed_step = 0;   ///< a step was not solved
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
  double cost = 0;                        ///< of the plan, by PlannerOptions::cost [s]
  std::vector<Improvement> improvements;  ///< solutions in the order found; their cost falls
  std::vector<NodeRecord> records;        ///< all nodes, with PlannerOptions::record_tree, the root first
  double wall_s = 0;
  std::vector<TreeNode> tree;    ///< all nodes, in the order of their making
  std::string reason;            ///< why not Solved, where there is more to say than that the budget was used up
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
  int best = -1;             ///< node of the tree that is nearest the goal
  double best_ratio = 0;     ///< how far that one is, in tolerances
};
using GrowthSink = std::function<void(const Growth&)>;

/// plan_from(), told between rounds how its trees grow, by the thread that called it. Trees that look for a cheaper path (anytime) are not told of.
/// Every node of the tree whose path is the plan is told of once; the plan is that of plan_from(), to the last bit.
/// @param u_start  commands at the start (n_a) [rad or m]; empty: joints are commanded where they are
/// @throws core::InvalidInput, as plan_from()
core::Status plan_watched(const PlanningProblem& problem, const Eigen::VectorXd& u_start, const PlannerOptions& options,
                          const core::RunControl& control, const GrowthSink& grown, PlanResult& result);

}  // namespace stiction::planning
