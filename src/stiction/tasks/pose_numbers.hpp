#pragma once

#include <Eigen/Geometry>

#include "stiction/tasks/plan_file.hpp"

namespace stiction::tasks {

/// Converts a pose, with the sign of the quaternion chosen so that w ≥ 0.
inline PoseNumbers to_numbers(const world::Pose& X) {
  Eigen::Quaterniond r(X.R);
  if (r.w() < 0) r.coeffs() *= -1;
  return {X.p[0], X.p[1], X.p[2], r.w(), r.x(), r.y(), r.z()};
}

inline world::Pose to_pose(const PoseNumbers& n) {
  return {Eigen::Quaterniond(n[3], n[4], n[5], n[6]).normalized().toRotationMatrix(), {n[0], n[1], n[2]}};
}

/// Names of the object joints in files, by enumerator.
inline constexpr std::array<std::string_view, 6> kObjectJointNames = {"free", "planar_xy", "planar_yz", "planar_xz", "hinge", "slider"};
inline constexpr std::array<std::string_view, 3> kBodyKindNames = {"fixed", "object", "robot"};
inline constexpr std::array<std::string_view, 3> kSegmentKindNames = {"settle", "contact", "regrasp"};

}  // namespace stiction::tasks
