#include "stiction/planning/tree.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "stiction/planning/thresholds.hpp"

namespace stiction::planning {
void LocalModel::set(const Eigen::VectorXd& q_next, const Eigen::MatrixXd& B, int n_qu, const Eigen::VectorXd& gamma,
                     const Eigen::VectorXd& joint_units) {
  c_u = q_next.head(n_qu);
  B_u = B.topRows(gamma.size());
  if (joint_units.size() == 0) {
    S = B_u * B_u.transpose();
  } else {
    S = B_u * joint_units.cwiseAbs2().asDiagonal() * B_u.transpose();
  }
  S.diagonal() += gamma;
  L_inv.setIdentity(gamma.size(), gamma.size());
  S.llt().matrixL().solveInPlace(L_inv);
}

void set_edge(const std::vector<dynamics::Knot>& knots, const world::Model& model, Node& node) {
  const auto n = static_cast<Eigen::Index>(knots.size());
  node.commands.resize(model.n_a(), n);
  node.states.resize(model.n_q(), n);
  for (Eigen::Index k = 0; k < n; ++k) {
    node.commands.col(k) = knots[static_cast<std::size_t>(k)].u;
    node.states.col(k) = knots[static_cast<std::size_t>(k)].q;
  }
  if (n == 0) return;
  node.q = knots.back().q;
  node.u = knots.back().u;
}

int Tree::add(Node node, const Eigen::VectorXd& q_goal, bool visited) {
  const int i = size();
  const Eigen::VectorXd q_u = node.q.head(q_goal.size());
  nearest_.add(node.local.c_u, node.local.S, node.local.L_inv);
  effort_.push_back(std::sqrt(nearest_.distance(i, q_goal.data(), of_goal_)) / threshold::kLength);
  by_metric_.add(q_u, effort_.back(), visited);
  pushes_.add(q_u, node.goal_distance, false);
  regrasps_.add(q_u, node.goal_distance, false);
  places_.add(q_u, weights_);
  if (node.edge == SegmentKind::Regrasp) places_.remove(i);
  nodes_.push_back(std::move(node));
  Node& added = nodes_.back();
  added.local.S.resize(0, 0);  // nearest_ stores them
  added.local.L_inv.resize(0, 0);
  if (best_ < 0 || added.goal_ratio < (*this)[best_].goal_ratio) best_ = i;
  return i;
}

void Tree::set_replay(int i, EdgeReplay replay, double goal_ratio, double goal_distance) {
  Node& node = nodes_[static_cast<std::size_t>(i)];
  node.replay = std::move(replay);
  node.goal_ratio = goal_ratio;
  node.goal_distance = goal_distance;
  if (i == best_) find_best();
}

void Tree::find_best() {
  best_ = -1;
  for (int k = 0; k < size(); ++k) {
    if (!pruned(k) && (best_ < 0 || (*this)[k].goal_ratio < (*this)[best_].goal_ratio)) best_ = k;
  }
}

void Tree::prune(int i) {
  nearest_.remove(i);
  places_.remove(i);
  if (i == best_) find_best();
}

int Tree::take_by_metric() {
  return by_metric_.take([this](int i) { return !pruned(i); }, [this](int i) { return effort_[static_cast<std::size_t>(i)]; });
}

int Tree::take_by_place(bool grasp) {
  const auto distance = [this](int i) { return (*this)[i].goal_distance; };
  if (!grasp) return pushes_.take([this](int i) { return !pruned(i); }, distance);
  return regrasps_.take([this](int i) { return !pruned(i) && (*this)[i].edge != SegmentKind::Regrasp; }, distance);
}

std::vector<int> Tree::path_to(int i) const {
  std::vector<int> path;
  for (; i >= 0; i = (*this)[i].parent) path.push_back(i);
  std::reverse(path.begin(), path.end());
  return path;
}

}  // namespace stiction::planning
