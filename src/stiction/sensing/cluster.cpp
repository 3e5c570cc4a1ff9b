#include "stiction/sensing/cluster.hpp"

#include <algorithm>
#include <numeric>
#include <tuple>

namespace stiction::sensing {

void cluster_points(const Sensor& sensor, double merge, std::vector<ContactPoint>& points, ClusterWorkspace& work, std::vector<int>& ends) {
  const auto n = static_cast<int>(points.size());
  const auto at = [](int i) { return static_cast<std::size_t>(i); };
  // By residual first, so that labels count clusters from the best on, whatever order the points came in.
  work.order.resize(points.size());
  std::iota(work.order.begin(), work.order.end(), 0);
  std::sort(work.order.begin(), work.order.end(),
            [&](int a, int b) { return std::tuple(points[at(a)].residual, a) < std::tuple(points[at(b)].residual, b); });
  work.label.assign(points.size(), -1);
  int clusters = 0;
  for (int seed = 0; seed < n; ++seed) {
    if (work.label[at(seed)] >= 0) continue;
    work.label[at(seed)] = clusters;
    work.open.assign(1, seed);
    while (!work.open.empty()) {
      const ContactPoint& p = points[at(work.order[at(work.open.back())])];
      work.open.pop_back();
      const double radius = merge * sensor.links()[at(p.link)].spacing;
      for (int i = seed + 1; i < n; ++i) {
        const ContactPoint& other = points[at(work.order[at(i)])];
        if (work.label[at(i)] >= 0 || other.link != p.link || (other.p_L - p.p_L).squaredNorm() > radius * radius) continue;
        work.label[at(i)] = clusters;
        work.open.push_back(i);
      }
    }
    ++clusters;
  }
  work.sorted.clear();
  ends.clear();
  for (int c = 0; c < clusters; ++c) {
    for (int i = 0; i < n; ++i)
      if (work.label[at(i)] == c) work.sorted.push_back(points[at(work.order[at(i)])]);
    ends.push_back(static_cast<int>(work.sorted.size()));
  }
  points.swap(work.sorted);
}

}  // namespace stiction::sensing
