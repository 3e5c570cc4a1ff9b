#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "stiction/sensing/triangle_tree.hpp"
#include "stiction/world/model.hpp"

namespace stiction::sensing {

/// Tests which parts of a robot's links are visible from afar in at least one of several postures.
class Visibility {
 public:
  /// @param robot  index into model.robots()  @param trees  per body, in its frame; empty ones hide nothing  @param rays ≥ 1
  Visibility(const world::Model& model, int robot, const std::vector<TriangleTree>& trees, int rays, int postures, std::uint64_t seed);

  /// Whether a ray from the point, lifted off along the direction by `lift` [m], into the half space of the direction meets no link.
  bool is_seen(int body, const Eigen::Vector3d& p_L, const Eigen::Vector3d& direction_L, double lift) const;

  /// SHA-256 of all inputs of the answers: triangles of the links, their poses in the postures, rays.
  const std::string& key() const { return key_; }

 private:
  struct Occluder {
    const TriangleTree* tree;
    int body;
    Eigen::Vector3d p_LCenter;  ///< centre of its bounding sphere
    double radius;
  };
  std::vector<Occluder> occluders_;
  std::vector<world::Kinematics> postures_;
  Eigen::Matrix3Xd rays_;  ///< in the half space z > 0, the steepest first
  std::string key_;
};

}  // namespace stiction::sensing
