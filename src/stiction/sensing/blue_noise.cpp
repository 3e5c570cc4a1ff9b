#include "stiction/sensing/blue_noise.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <queue>
#include <utility>

namespace stiction::sensing {

using Eigen::Index;
using Eigen::Matrix3Xd;

namespace {

/// Pairs nearer than `reach`, by cells of that size, with their weights.
std::vector<std::vector<std::pair<int, double>>> find_neighbours(const Matrix3Xd& points, double reach) {
  using Cell = std::array<long, 3>;
  const auto cell_of = [&](Index i) {
    return Cell{std::lround(std::floor(points(0, i) / reach)), std::lround(std::floor(points(1, i) / reach)),
                std::lround(std::floor(points(2, i) / reach))};
  };
  std::map<Cell, std::vector<int>> cells;
  for (Index i = 0; i < points.cols(); ++i) cells[cell_of(i)].push_back(static_cast<int>(i));
  std::vector<std::vector<std::pair<int, double>>> out(static_cast<std::size_t>(points.cols()));
  for (Index i = 0; i < points.cols(); ++i) {
    const Cell home = cell_of(i);
    for (int k = 0; k < 27; ++k) {
      const auto found = cells.find({home[0] + k % 3 - 1, home[1] + k / 3 % 3 - 1, home[2] + k / 9 - 1});
      if (found == cells.end()) continue;
      for (const int j : found->second) {
        const double distance = (points.col(i) - points.col(j)).norm();
        if (j != static_cast<int>(i) && distance < reach)
          out[static_cast<std::size_t>(i)].emplace_back(j, std::pow(1 - distance / reach, 8));
      }
    }
  }
  return out;
}

}  // namespace

std::vector<int> eliminate_samples(const Matrix3Xd& points, int keep, double area) {
  const auto n = static_cast<int>(points.cols());
  std::vector<char> kept(static_cast<std::size_t>(n), 1);
  const auto neighbours = find_neighbours(points, 2 * std::sqrt(area / (2 * std::sqrt(3.0) * keep)));
  std::vector<double> weights;
  std::priority_queue<std::pair<double, int>> heaviest;  // an entry whose weight is out of date is passed over
  for (int i = 0; i < n; ++i) {
    double sum = 0;
    for (const auto& [j, weight] : neighbours[static_cast<std::size_t>(i)]) sum += weight;
    weights.push_back(sum);
    heaviest.emplace(sum, i);
  }
  for (int left = n; left > keep;) {
    const auto [weight, i] = heaviest.top();
    heaviest.pop();
    if (kept[static_cast<std::size_t>(i)] == 0 || weight != weights[static_cast<std::size_t>(i)]) continue;
    kept[static_cast<std::size_t>(i)] = 0;
    --left;
    for (const auto& [j, share] : neighbours[static_cast<std::size_t>(i)]) {
      if (kept[static_cast<std::size_t>(j)] == 0) continue;
      weights[static_cast<std::size_t>(j)] -= share;
      heaviest.emplace(weights[static_cast<std::size_t>(j)], j);
    }
  }
  std::vector<int> out;
  for (int i = 0; i < n; ++i)
    if (kept[static_cast<std::size_t>(i)] != 0) out.push_back(i);
  return out;
}

}  // namespace stiction::sensing
