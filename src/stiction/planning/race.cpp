#include "stiction/planning/race.hpp"

#include <algorithm>

namespace stiction::planning {

int Race::next() {
  for (auto rung = rungs_.rbegin(); rung != rungs_.rend(); ++rung) {
    const auto better_half = rung->begin() + std::ssize(*rung) / 2;
    const auto found = std::find_if(rung->begin(), better_half, [](const Place& place) { return !place.went_on; });
    if (found == better_half) continue;
    found->went_on = true;
    return found->tree;
  }
  rung_of_.push_back(-1);
  return static_cast<int>(rung_of_.size()) - 1;
}

long Race::budget(int tree) const { return first_ << (rung_of_[static_cast<std::size_t>(tree)] + 1); }

void Race::reached(int tree, double distance, bool stalled) {
  const auto height = static_cast<std::size_t>(++rung_of_[static_cast<std::size_t>(tree)]);
  if (height == rungs_.size()) rungs_.emplace_back();
  auto& rung = rungs_[height];
  const auto farther = std::find_if(rung.begin(), rung.end(), [&](const Place& place) { return place.distance > distance; });
  rung.insert(farther, {tree, distance, stalled});
}

}  // namespace stiction::planning
