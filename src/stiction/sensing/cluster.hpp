#pragma once

#include <vector>

#include "stiction/sensing/descent.hpp"

namespace stiction::sensing {

/// Scratch of cluster_points.
struct ClusterWorkspace {
  std::vector<int> label, order, open;
  std::vector<ContactPoint> sorted;
};

/// Clusters points by single linkage: points of one link that are joined by a chain of steps shorter than `merge` sample spacings form a
/// cluster. Afterwards `points` are ordered by cluster, clusters by their best residual, points within a cluster by residual. @param ends
/// one past the last point of each cluster
void cluster_points(const Sensor& sensor, double merge, std::vector<ContactPoint>& points, ClusterWorkspace& work, std::vector<int>& ends);

}  // namespace stiction::sensing
