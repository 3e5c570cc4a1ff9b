#include "stiction/planning/race.hpp"

#include <algorithm>

namespace stiction::planning {

int Race::next() const {
  for (auto rung = rungs_.rbegin(); rung != rungs_.rend(); ++rung) {
    const auto better_half = rung->begin() + std::ssize(*rung) / 2;
    const auto found = std::find_if(rung->begin(), better_half, [](const Place& place) { return !place.went_on; });
    if (found != better_half) return found->tree;
  }
  return static_cast<int>(rung_of_.size());
}

long Race::budget(int tree) const {
  const bool fresh = tree == std::ssize(rung_of_);
  return first_ << (fresh ? 0 : rung_of_[static_cast<std::size_t>(tree)] + 1);
}

void Race::reached(int tree, double distance, bool stalled) {
  if (tree == std::ssize(rung_of_)) {
    rung_of_.push_back(0);
  } else {
    auto& below = rungs_[static_cast<std::size_t>(rung_of_[static_cast<std::size_t>(tree)]++)];
    std::find_if(below.begin(), below.end(), [&](const Place& place) { return place.tree == tree; })->went_on = true;
  }
  const auto height = static_cast<std::size_t>(rung_of_[static_cast<std::size_t>(tree)]);
  if (height == rungs_.size()) rungs_.emplace_back();
  auto& rung = rungs_[height];
  const auto farther = std::find_if(rung.begin(), rung.end(), [&](const Place& place) { return place.distance > distance; });
  rung.insert(farther, {tree, distance, stalled});
}

}  // namespace stiction::planning
