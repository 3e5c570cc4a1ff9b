#include "stiction/world/nearest_line.hpp"

#include <algorithm>
#include <limits>
#include <vector>

namespace stiction::world {

NearestLine nearest_line(const std::function<double(double)>& f, std::pair<double, double> x_range, std::pair<double, double> y_range) {
  constexpr int kPoints = 65;
  std::vector<std::pair<double, double>> all, points;
  for (int k = 0; k < kPoints; ++k) {
    const double x = x_range.first + (x_range.second - x_range.first) * k / (kPoints - 1), y = f(x);
    all.emplace_back(x, y);
    if (y >= y_range.first && y <= y_range.second) points.emplace_back(x, y);
  }
  if (points.size() < 2) points = all;
  // The narrowest strip that contains all points has a side along an edge of their convex hull, so through two points.
  NearestLine best{.error = std::numeric_limits<double>::infinity()};
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (std::size_t j = i + 1; j < points.size(); ++j) {
      const double slope = (points[j].second - points[i].second) / (points[j].first - points[i].first);
      const auto [low, high] = std::minmax_element(points.begin(), points.end(), [&](const auto& a, const auto& b) {
        return a.second - slope * a.first < b.second - slope * b.first;
      });
      const double least = low->second - slope * low->first, most = high->second - slope * high->first;
      if ((most - least) / 2 < best.error) best = {slope, (least + most) / 2, (most - least) / 2};
    }
  }
  return best;
}

}  // namespace stiction::world
