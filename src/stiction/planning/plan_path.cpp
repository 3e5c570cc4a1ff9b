#include "stiction/planning/plan_path.hpp"

#include "stiction/planning/simulate.hpp"

namespace stiction::planning {

Plan PathWriter::to_plan(const Tree& tree, const std::vector<int>& path, bool forces, ThreadScratch& scratch, Totals& totals) const {
  Plan plan = empty_plan(tree);
  for (const int i : path) {
    if (tree[i].commands.cols() > 0) plan.segments.push_back(describe_edge(tree, tree[i], forces, scratch, totals));
  }
  cut_motionless_tail(plan);
  const Eigen::VectorXd& q_end = plan.segments.empty() ? plan.q_start : plan.segments.back().knots.back().q;
  plan.error = goal_error(setting_.model, q_end, setting_.problem.goal);
  return plan;
}

Plan PathWriter::empty_plan(const Tree& tree) const {
  Plan plan;
  plan.q_start = setting_.problem.q_start;
  plan.u_start = tree[0].u;
  plan.goal = setting_.problem.goal;
  plan.step = setting_.exact;
  plan.substep = setting_.thresholds.substep;
  return plan;
}

Segment PathWriter::describe_edge(const Tree& tree, const Node& node, bool forces, ThreadScratch& scratch, Totals& totals) const {
  Segment segment{node.edge, {}, node.unstable};
  for (Eigen::Index k = 0; k < node.commands.cols(); ++k)
    segment.knots.push_back({.u = node.commands.col(k), .q = node.states.col(k), .contacts = {}});
  if (!forces) return segment;
  scratch.steps.forget();
  add_forces(setting_.model, setting_.exact, node.parent < 0 ? setting_.problem.q_start : tree[node.parent].q, segment, scratch, totals);
  return segment;
}

void PathWriter::cut_motionless_tail(Plan& plan) const {
  if (plan.segments.empty()) return;
  const Allowance& rest = setting_.thresholds.rest;
  const Eigen::VectorXd q_end = plan.segments.back().knots.back().q;
  while (!plan.segments.empty()) {
    auto& knots = plan.segments.back().knots;
    while (knots.size() > 1) {
      if (setting_.goal.share(knots[knots.size() - 2].q, q_end, rest.position, rest.angle) > 1) break;
      knots.pop_back();
    }
    if (knots.size() > 1 || plan.segments.back().kind != SegmentKind::Regrasp) break;
    plan.segments.pop_back();
  }
}

double cost_to(const world::Model& model, const Node& parent, const Node& node) {
  const PathCost price;
  double cost = parent.cost + (node.edge == SegmentKind::Regrasp ? price.regrasp : 0.0);
  Eigen::VectorXd u = parent.u;
  for (Eigen::Index k = 0; k < node.commands.cols(); ++k) {
    cost += command_time(model, u, node.commands.col(k), price);
    u = node.commands.col(k);
  }
  return cost;
}

}  // namespace stiction::planning
