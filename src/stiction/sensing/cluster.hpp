#pragma once

#include <vector>

#include "stiction/sensing/descent.hpp"

namespace stiction::sensing {

/// Scratch of cluster_points.
struct ClusterWorkspace {
  std::vector<int> label, order, open;
  std::vector<ContactPoint> sorted;
};

/// Single linkage: points of one link that a chain of steps shorter than `merge` spacings joins have one label. Afterwards `points` are
/// ordered by cluster, clusters by their best residual, points within by theirs. @param ends  one past the last point of each cluster
void cluster_points(const Sensor& sensor, double merge, std::vector<ContactPoint>& points, ClusterWorkspace& work, std::vector<int>& ends);

}  // namespace stiction::sensing
