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

void Frontier::add(const Eigen::VectorXd& q_u, double distance, double metric, bool visited) {
  const int node = static_cast<int>(cell_.size());
  cell_.push_back(cell_of(q_u, distance));
  visits_.push_back(0);
  if (visited) visit(node);
  queue_.push({cost(node, distance), metric, node});
}

int Frontier::cell_of(const Eigen::VectorXd& q_u, double distance) {
  const int cell = cells_.nearest(q_u.data());
  if (cell >= 0 && std::sqrt(cells_.distance(cell, q_u.data())) < threshold::kCell * (1 + distance)) return cell;
  cells_.add(q_u, weights_.cwiseInverse().asDiagonal().toDenseMatrix(), weights_.cwiseSqrt().asDiagonal().toDenseMatrix());
  cell_visits_.push_back(0);
  return cells_.size() - 1;
}

void Frontier::visit(int node) {
  ++visits_[at(node)];
  ++cell_visits_[at(cell_[at(node)])];
  ++all_visits_;
}

int Frontier::take(const std::function<bool(int)>& gone, const std::function<bool(int)>& usable, const std::function<double(int)>& distance) {
  std::vector<Choice> passed_over;
  int taken = -1;
  while (taken < 0 && !queue_.empty()) {
    Choice choice = queue_.top();
    queue_.pop();
    if (gone(choice.node)) continue;
    if (!usable(choice.node)) {
      passed_over.push_back(choice);
      continue;
    }
    const double d = distance(choice.node), now = cost(choice.node, d);
    if (now > choice.cost && !queue_.empty() && now > queue_.top().cost) {
      choice.cost = now;
      queue_.push(choice);
      continue;
    }
    taken = choice.node;
    visit(taken);
    choice.cost = cost(taken, d);
    queue_.push(choice);
  }
  for (const Choice& choice : passed_over) queue_.push(choice);
  return taken;
}

}  // namespace stiction::planning
