#include "stiction/planning/tree.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <limits>

namespace stiction::planning {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr int kStackDofs = 64;
/// An extension that left the object farther from the goal than this share of before is not taken on towards the goal: its direction is
/// used up, and chains of such nodes once swallowed the whole budget.
constexpr double kProgress = 0.95;

}  // namespace

void LocalModel::set(const Eigen::VectorXd& q_next, const Eigen::MatrixXd& B, int n_qu, int n_vu, double gamma) {
  c_u = q_next.head(n_qu);
  B_u = B.topRows(n_vu);
  Eigen::MatrixXd S = B_u * B_u.transpose();
  S.diagonal().array() += gamma;
  L_inv.setIdentity(n_vu, n_vu);
  S.llt().matrixL().solveInPlace(L_inv);
}

int Tree::add(Node node, const Eigen::VectorXd& q_goal) {
  const int n_v = space_->n_v();
  centres_.insert(centres_.end(), node.local.c_u.data(), node.local.c_u.data() + space_->n_q());
  for (int r = 0; r < n_v; ++r) {
    for (int c = 0; c <= r; ++c) factors_.push_back(node.local.L_inv(r, c));
  }
  nodes_.push_back(std::move(node));
  const int i = size() - 1;
  const Node& added = nodes_.back();
  const bool stalled =
      added.parent >= 0 && added.edge == SegmentKind::Contact && added.goal_ratio > kProgress * (*this)[added.parent].goal_ratio;
  goal_distance_.push_back(stalled ? kInfinity : distance(i, q_goal.data()));
  regrasps_.push_back(0);
  buried_.push_back(0);
  return i;
}

void Tree::bury(int i) {
  buried_[static_cast<std::size_t>(i)] = 1;
  goal_distance_[static_cast<std::size_t>(i)] = kInfinity;
}

double Tree::distance(int i, const double* q_u) const {
  const int n_v = space_->n_v();
  double fixed[kStackDofs];
  std::vector<double> heap;
  double* e = fixed;
  if (n_v > kStackDofs) {
    heap.resize(static_cast<std::size_t>(n_v));
    e = heap.data();
  }
  space_->error(centres_.data() + static_cast<std::ptrdiff_t>(i) * space_->n_q(), q_u, e);
  const double* L = factors_.data() + static_cast<std::ptrdiff_t>(i) * (n_v * (n_v + 1) / 2);
  double d = 0;
  for (int r = 0; r < n_v; ++r) {
    double y = 0;
    for (int c = 0; c <= r; ++c) y += *L++ * e[c];
    d += y * y;
  }
  return d;
}

int Tree::nearest(const Eigen::VectorXd& q_u) const {
  int best = -1;
  double best_distance = kInfinity;
  for (int i = 0; i < size(); ++i) {
    if (buried_[static_cast<std::size_t>(i)]) continue;
    const double d = distance(i, q_u.data());
    if (d < best_distance) {
      best_distance = d;
      best = i;
    }
  }
  return best;
}

int Tree::take_nearest_to_goal() {
  const auto it = std::min_element(goal_distance_.begin(), goal_distance_.end());
  if (it == goal_distance_.end() || *it == kInfinity) return -1;
  *it = kInfinity;
  return static_cast<int>(it - goal_distance_.begin());
}

int Tree::take_for_regrasp() {
  constexpr double kWear = 0.2;  // a node tried five times counts as twice as far from the goal
  int best = -1;
  double best_cost = kInfinity;
  for (int i = 0; i < size(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    if (buried_[k] || nodes_[k].unsupported || nodes_[k].edge == SegmentKind::Regrasp) continue;
    const double cost = (1 + nodes_[k].goal_ratio) * (1 + kWear * regrasps_[k]);
    if (cost < best_cost) {
      best_cost = cost;
      best = i;
    }
  }
  if (best >= 0) ++regrasps_[static_cast<std::size_t>(best)];
  return best;
}

std::vector<int> Tree::path_to(int i) const {
  std::vector<int> path;
  for (; i >= 0; i = (*this)[i].parent) path.push_back(i);
  std::reverse(path.begin(), path.end());
  return path;
}

}  // namespace stiction::planning
