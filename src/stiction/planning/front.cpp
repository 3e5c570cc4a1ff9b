#include "stiction/planning/front.hpp"

#include <algorithm>

namespace stiction::planning {
namespace {

/// A node taken five times counts as twice as far from the goal, …
constexpr double kWear = 0.2;
/// … and so does one in a cell that is taken five times as often as the average one.
constexpr double kCellWear = 0.2;

std::size_t at(int i) { return static_cast<std::size_t>(i); }

void reach(std::vector<int>& counts, int i) { counts.resize(std::max(counts.size(), at(i) + 1), 0); }

}  // namespace

double Front::cost(int node, double distance) const {
  const double mean = std::max(1.0, static_cast<double>(choices_) / static_cast<double>(taken_in_.size()));
  return (1 + distance) * (1 + kWear * taken_[at(node)]) * (1 + kCellWear * taken_in_[at(cell_[at(node)])] / mean);
}

void Front::add(int node, int cell, double distance) {
  reach(cell_, node);
  reach(taken_, node);
  reach(taken_in_, cell);
  cell_[at(node)] = cell;
  queue_.push({cost(node, distance), node});
}

int Front::take(const std::function<bool(int)>& usable, const std::function<double(int)>& distance) {
  while (!queue_.empty()) {
    const auto [before, node] = queue_.top();
    queue_.pop();
    if (!usable(node)) continue;
    const double d = distance(node), now = cost(node, d);
    if (now > before && !queue_.empty() && now > queue_.top().cost) {
      queue_.push({now, node});
      continue;
    }
    ++taken_[at(node)];
    ++taken_in_[at(cell_[at(node)])];
    ++choices_;
    queue_.push({cost(node, d), node});
    return node;
  }
  return -1;
}

}  // namespace stiction::planning
