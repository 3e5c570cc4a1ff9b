#include "stiction/planning/tree.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace stiction::planning {
namespace {

/// An extension that left the object farther from the goal than this share of before is not taken on towards the goal: its direction is
/// used up, and chains of such nodes once swallowed the whole budget.
constexpr double kProgress = 0.95;
/// Objects nearer than this share of their distance from the goal, and of a tolerance, to those of a cell are in it.
constexpr double kCell = 0.1;

}  // namespace

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

namespace {

/// A point with the metric Σ wᵢ eᵢ².
void add_weighted(NearestPoints& points, const Eigen::VectorXd& c, const Eigen::VectorXd& w) {
  points.add(c, w.cwiseInverse().asDiagonal().toDenseMatrix(), w.cwiseSqrt().asDiagonal().toDenseMatrix());
}

}  // namespace

int Tree::add(Node node, const Eigen::VectorXd& q_goal, bool taken) {
  const int i = size();
  if (global_weights_.size() == 0) {
    nearest_.add(node.local.c_u, node.local.S, node.local.L_inv);
  } else {
    add_weighted(nearest_, node.q.head(q_goal.size()), global_weights_);
  }
  add_weighted(places_, node.q.head(q_goal.size()), place_weights_);
  if (node.edge == SegmentKind::Regrasp) places_.remove(i);  // another grasp starts where this one did
  nodes_.push_back(std::move(node));
  Node& added = nodes_.back();
  added.local.S.resize(0, 0);  // nearest_ has them
  added.local.L_inv.resize(0, 0);
  const bool stalled =
      added.parent >= 0 && added.edge == SegmentKind::Contact && added.goal_distance > kProgress * (*this)[added.parent].goal_distance;
  if (!stalled && !taken) to_goal_.push({nearest_.distance(i, q_goal.data()), i});
  const int cell = cell_of(added);
  if (added.edge != SegmentKind::Regrasp) to_regrasp_.add(i, cell, added.goal_distance);
  to_push_.add(i, cell, added.goal_distance);
  return i;
}

int Tree::cell_of(const Node& node) {
  const int cell = cells_.nearest(node.q.data());
  if (cell >= 0 && std::sqrt(cells_.distance(cell, node.q.data())) < kCell * (1 + node.goal_distance)) return cell;
  add_weighted(cells_, node.q.head(node.local.c_u.size()), place_weights_);
  return cells_.size() - 1;
}

void Tree::prune(int i) {
  nearest_.remove(i);
  places_.remove(i);
}

int Tree::prune_subtree(int i) {
  std::vector<char> behind(nodes_.size(), 0);
  behind[static_cast<std::size_t>(i)] = 1;
  int n = 0;
  for (int k = i; k < size(); ++k) {  // parents come before their children
    const int parent = (*this)[k].parent;
    if (k > i && (parent < 0 || behind[static_cast<std::size_t>(parent)] == 0)) continue;
    behind[static_cast<std::size_t>(k)] = 1;
    n += !nearest_.removed(k);
    prune(k);
  }
  return n;
}

int Tree::take_nearest_to_goal() {
  while (!to_goal_.empty()) {
    const int i = to_goal_.top().node;
    to_goal_.pop();
    if (!nearest_.removed(i)) return i;
  }
  return -1;
}

int Tree::take_for_regrasp() {
  return to_regrasp_.take([this](int i) { return !nearest_.removed(i) && !(*this)[i].cannot_release; },
                          [this](int i) { return (*this)[i].goal_distance; });
}

int Tree::take_for_push() {
  return to_push_.take([this](int i) { return !nearest_.removed(i); }, [this](int i) { return (*this)[i].goal_distance; });
}

std::vector<int> Tree::path_to(int i) const {
  std::vector<int> path;
  for (; i >= 0; i = (*this)[i].parent) path.push_back(i);
  std::reverse(path.begin(), path.end());
  return path;
}

}  // namespace stiction::planning
