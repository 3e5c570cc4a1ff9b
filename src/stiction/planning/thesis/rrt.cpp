#include "stiction/planning/thesis/rrt.hpp"

#include <Eigen/Cholesky>
#include <optional>

#include "stiction/cone/bounded_least_squares.hpp"
#include "stiction/core/invalid_input.hpp"
#include "stiction/core/random.hpp"
#include "stiction/planning/nearest.hpp"
#include "stiction/planning/settle_start.hpp"

namespace stiction::planning::thesis {
namespace {

using core::Status;

/// Keeps the samples of local models apart from the draws of the search.
constexpr std::uint64_t kSampleSeed = 0x5ca1ab1e0ddba11;
/// Complementarity of disturbed steps [J·s]: as sharp as a barrier weight of 1e5/J, far below the resolution of a mean of 100 samples.
constexpr double kSampleComplementarity = 1e-6;
/// Shorter extensions count as none [joint units].
constexpr double kNoMove = 1e-9;

struct Node {
  int parent = -1;
  SegmentKind edge = SegmentKind::Contact;
  Eigen::VectorXd q, u;        ///< state, and the command that led to it
  dynamics::LocalModel local;  ///< local model around u = qᵃ
};

class Tree {
 public:
  Tree(const PlanningProblem& problem, const PlannerOptions& options, const core::RunControl& control, PlanResult& out)
      : setting_(problem, options),
        how_(*options.thesis),
        control_(control),
        out_(out),
        scratch_(problem.model, to_the_end_),
        locals_(problem.model),
        nearest_(setting_.goal.space()) {
    smoothed_ = setting_.exact;
    smoothed_.warm_start = false;
    if (how_.scheme == Scheme::RandomizedFirst || how_.scheme == Scheme::RandomizedZeroth)
      smoothed_.tol_complementarity = kSampleComplementarity;
  }

  /// Runs Algorithm 2.
  Status grow() {
    if (!plant_root()) return Status::NumericalFailure;
    for (long k = 0; k < setting_.options.max_iterations && !control_.stop(); ++k) {
      core::Random random(setting_.options.seed, static_cast<std::uint64_t>(k) + 1);
      const bool grasp = random.chance(how_.grasp_probability);
      const Eigen::VectorXd q_subgoal = sample_subgoal(random);
      int near = nearest_.nearest(q_subgoal.data());  // (3.8)
      out_.iterations = k + 1;
      std::optional<Node> node = grasp ? sample_contact(near, random) : extend(near, q_subgoal);
      if (node && add_node(std::move(*node), near) && how_.stop_at_goal && reaches_goal(size() - 1)) return Status::Solved;
      report();
    }
    return control_.status_when_stopped();
  }

  void finish() {
    out_.nodes = size();
    out_.steps = totals_.steps;
    out_.failed_steps = totals_.failed_steps;
    out_.linearisations = totals_.linearisations;
    out_.regrasps = totals_.regrasps;
    for (const Node& node : nodes_)
      out_.tree.push_back({node.parent, node.edge, world::object_pose(setting_.model, node.q, setting_.problem.goal.object)});
    if (best_ >= 0) write_path();
  }

 private:
  bool plant_root() {
    const auto settled = settle_start(setting_, {}, scratch_, totals_, out_);
    if (!settled) return false;
    Node root{-1, SegmentKind::Settle, settled->q, settled->u, {}};
    if (add_node(std::move(root), -1)) return true;
    out_.reason = "the start has no local model: its smoothed step is not solved";
    return false;
  }

  Eigen::VectorXd sample_subgoal(core::Random& random) {
    Eigen::VectorXd q_u = setting_.goal.q_goal();
    if (!random.chance(setting_.options.goal_bias)) setting_.goal.space().sample(setting_.options.sample_boxes, random, q_u);
    return q_u;
  }

  /// Algorithm 3: the least-squares command (3.6) within joint limits, scaled to its fixed length, and one exact step.
  std::optional<Node> extend(int near, const Eigen::VectorXd& q_subgoal) {
    const world::Model& model = setting_.model;
    const Node& from = nodes_[static_cast<std::size_t>(near)];
    const Eigen::VectorXd q_a = from.q.tail(model.n_a()), lower = (model.lower() - q_a).cwiseMin(0.0),
                          upper = (model.upper() - q_a).cwiseMax(0.0);
    const Eigen::VectorXd e = setting_.goal.difference(from.local.c.head(model.n_qu()), q_subgoal);
    Eigen::VectorXd delta_u;
    cone::solve_bounded_least_squares(from.local.B.topRows(model.n_vu()), e, how_.gamma, lower, upper, delta_u);
    if (delta_u.norm() < kNoMove) return std::nullopt;
    delta_u *= how_.length / delta_u.norm();
    Node node{near, SegmentKind::Contact, {}, (q_a + delta_u).cwiseMax(model.lower()).cwiseMin(model.upper()), {}};
    int steps = 0;
    scratch_.steps.forget();
    const Status status = dynamics::step_within_efforts(model, from.q, node.u, setting_.exact, scratch_.steps, scratch_.step_result, steps);
    if (!totals_.add(steps, status) || setting_.press.share(scratch_.step_result.contacts, how_.h) > kMostPress) return std::nullopt;
    node.q = scratch_.step_result.q_next;
    return node;
  }

  /// 3.4.3: the robot jumps to a posture in contact. A jump after a jump starts where the first one started.
  std::optional<Node> sample_contact(int& near, core::Random& random) {
    if (nodes_[static_cast<std::size_t>(near)].edge == SegmentKind::Regrasp) near = nodes_[static_cast<std::size_t>(near)].parent;
    const Node& from = nodes_[static_cast<std::size_t>(near)];
    ++totals_.regrasps.tried;
    const auto sample =
        contact::sample_contact(setting_.model, setting_.chains, how_.sampler, contact::draw_grasp(setting_.chains, how_.sampler, random),
                                from.q, random, scratch_.geometry);
    if (!sample) {
      ++totals_.regrasps.no_sample;
      return std::nullopt;
    }
    ++totals_.regrasps.accepted;
    Node node{near, SegmentKind::Regrasp, from.q, sample->q_a, {}};
    node.q.tail(setting_.model.n_a()) = sample->q_a;
    return node;
  }

  /// Adds a node with its local model (2.4.1) and its metric (3.5). @returns false: it has no local model
  bool add_node(Node node, int parent) {
    const world::Model& model = setting_.model;
    node.parent = parent;
    ++totals_.linearisations;
    const Eigen::VectorXd q_a = node.q.tail(model.n_a());
    const auto scheme = how_.local_model_scheme(setting_.options.seed, static_cast<std::uint64_t>(out_.iterations));
    if (dynamics::calc_local_model(model, {node.q, q_a}, scheme, smoothed_, false, locals_, node.local) != Status::Solved) {
      ++totals_.failed_steps;
      return false;
    }
    const Eigen::VectorXd c_u = node.local.c.head(model.n_qu());
    const Eigen::MatrixXd B_u = node.local.B.topRows(model.n_vu());
    Eigen::MatrixXd S = B_u * B_u.transpose();
    S.diagonal().array() += how_.gamma;
    if (how_.metric) S = global_metric().cwiseInverse().asDiagonal().toDenseMatrix();
    Eigen::MatrixXd L_inv = Eigen::MatrixXd::Identity(S.rows(), S.cols());
    S.llt().matrixL().solveInPlace(L_inv);
    nearest_.add(how_.metric ? Eigen::VectorXd(node.q.head(model.n_qu())) : c_u, S, L_inv);
    out_.records.push_back({node.parent, node.edge, out_.iterations, node.q, c_u, B_u});
    nodes_.push_back(std::move(node));
    const double ratio = setting_.goal.ratio(nodes_.back().q);
    if (best_ < 0 || ratio < best_ratio_) {
      best_ = size() - 1;
      best_ratio_ = ratio;
    }
    return true;
  }

  /// Diagonal of the metric that is the same at all nodes (n_vu).
  Eigen::VectorXd global_metric() const {
    Eigen::VectorXd weights(setting_.model.n_vu());
    for (int i = 0; i < setting_.model.n_vu(); ++i) {
      const bool revolute = setting_.model.dofs()[static_cast<std::size_t>(i)].kind == world::DofKind::Revolute;
      weights[i] = revolute ? how_.metric->angle : how_.metric->position;
    }
    return weights;
  }

  bool reaches_goal(int node) const {
    return setting_.goal.ratio(nodes_[static_cast<std::size_t>(node)].q) <= setting_.options.tolerance_fraction;
  }

  void report() {
    if (control_.on_progress)
      control_.on_progress({.iteration = out_.iterations,
                            .fraction = static_cast<double>(out_.iterations) / setting_.options.max_iterations,
                            .best = best_ratio_,
                            .size = size()});
  }

  void write_path() {
    std::vector<int> path;
    for (int i = best_; i >= 0; i = nodes_[static_cast<std::size_t>(i)].parent) path.push_back(i);
    Plan& plan = out_.plan;
    plan.q_start = setting_.problem.q_start;
    plan.u_start = nodes_[0].u;
    plan.goal = setting_.problem.goal;
    plan.step = setting_.exact;
    Eigen::VectorXd q = plan.q_start;
    for (auto i = path.rbegin(); i != path.rend(); ++i) {
      const Node& node = nodes_[static_cast<std::size_t>(*i)];
      if (node.parent < 0 && node.q == q) continue;
      Segment& segment = plan.segments.emplace_back();
      segment.kind = node.edge;
      segment.knots.push_back({.u = node.u, .q = node.q, .contacts = {}});
      if (node.edge == SegmentKind::Contact) add_forces(setting_.model, setting_.exact, q, segment, scratch_, totals_);
      q = node.q;
    }
    plan.error = goal_error(setting_.model, q, plan.goal);
    out_.cost = path_cost(setting_.model, plan, {});
  }

  int size() const { return static_cast<int>(nodes_.size()); }

  const Setting setting_;
  const Settings& how_;
  const core::RunControl& control_;
  PlanResult& out_;
  const core::RunControl to_the_end_;
  ThreadScratch scratch_;
  dynamics::LocalModelWorkspace locals_;
  dynamics::StepOptions smoothed_;
  NearestPoints nearest_;
  std::vector<Node> nodes_;
  Totals totals_;
  int best_ = -1;
  double best_ratio_ = 0;
};

}  // namespace

dynamics::LocalModelScheme Settings::local_model_scheme(std::uint64_t seed, std::uint64_t stream) const {
  if (scheme == Scheme::Exact) return dynamics::Exact{};
  if (scheme == Scheme::Analytic) return smoothing;
  dynamics::Sampling sampling = randomized;
  sampling.seed = core::Random(seed ^ kSampleSeed, stream).bits();
  if (scheme == Scheme::RandomizedFirst) return dynamics::RandomizedFirstOrder{sampling};
  return dynamics::RandomizedZerothOrder{sampling};
}

void Settings::validate(const world::Model& model) const {
  if (!(grasp_probability >= 0 && grasp_probability <= 1))
    core::throw_invalid("planner.thesis.grasp_probability", std::to_string(grasp_probability), "a probability in [0, 1]");
  core::require_positive("planner.thesis.length", length);
  core::require_positive("planner.thesis.gamma", gamma);
  core::require_positive("planner.thesis.h", h);
  core::require_positive("planner.thesis.smoothing.kappa", smoothing.kappa);
  dynamics::validate(model, local_model_scheme(0, 0), false);
  if (!metric) return;
  core::require_positive("planner.thesis.metric.global.position", metric->position);
  core::require_positive("planner.thesis.metric.global.angle", metric->angle);
}

void grow_tree(const PlanningProblem& problem, const PlannerOptions& options, const core::RunControl& control, PlanResult& out) {
  Tree tree(problem, options, control, out);
  out.status = tree.grow();
  tree.finish();
  out.seed = options.seed;
}

}  // namespace stiction::planning::thesis
