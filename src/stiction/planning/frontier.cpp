#include "stiction/planning/frontier.hpp"

#include <algorithm>
#include <cmath>

#include "stiction/planning/thresholds.hpp"

namespace stiction::planning {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

}  // namespace

double Frontier::cost(int node, double distance) const {
  const double mean = std::max(1.0, static_cast<double>(all_visits_) / static_cast<double>(cell_visits_.size()));
  return (1 + distance) * (1 + threshold::kVisit * visits_[at(node)]) * (1 + threshold::kVisit * cell_visits_[at(cell_[at(node)])] / mean);
}

void Frontier::add(const Eigen::VectorXd& q_u, double distance, bool visited) {
  const int node = static_cast<int>(cell_.size());
  cell_.push_back(cell_of(q_u, distance));
  visits_.push_back(0);
  if (visited) visit(node);
  queue_.push({cost(node, distance), node});
}

int Frontier::cell_of(const Eigen::VectorXd& q_u, double distance) {
  const int cell = cells_.nearest(q_u.data());
  if (cell >= 0 && std::sqrt(cells_.distance(cell, q_u.data())) < threshold::kCell * (1 + distance)) return cell;
  cells_.add(q_u, weights_);
  cell_visits_.push_back(0);
  return cells_.size() - 1;
}

void Frontier::visit(int node) {
  ++visits_[at(node)];
  ++cell_visits_[at(cell_[at(node)])];
  ++all_visits_;
}

int Frontier::take(const std::function<bool(int)>& usable, const std::function<double(int)>& distance) {
  while (!queue_.empty()) {
    const auto [before, node] = queue_.top();
    queue_.pop();
    if (!usable(node)) continue;
    const double d = distance(node), now = cost(node, d);
    if (now > before && !queue_.empty() && now > queue_.top().cost) {
      queue_.push({now, node});
      continue;
    }
    visit(node);
    queue_.push({cost(node, d), node});
    return node;
  }
  return -1;
}

}  // namespace stiction::planning
