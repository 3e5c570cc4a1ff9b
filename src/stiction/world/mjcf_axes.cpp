#include "stiction/world/mjcf_axes.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace stiction::world {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

Vector3d vector3(const mjtNum* p) { return {p[0], p[1], p[2]}; }

}  // namespace

Pose MjcfAxis::at(double value) const {
  if (turns) return {Eigen::AngleAxisd(value, direction).toRotationMatrix(), Vector3d::Zero()};
  return {Matrix3d::Identity(), value * direction};
}

std::vector<MjcfAxis> MjcfAxes::of(int body) const {
  std::vector<MjcfAxis> out;
  for (const int j : roles_.joints_of(body)) {
    if (is_ball(j)) {
      static constexpr std::string_view kNames[] = {"z", "y", "x"};
      for (int part = 0; part < 3; ++part) {
        out.push_back({.joint = j,
                       .dof = m_->jnt_dofadr[j] + 2 - part,
                       .name = fmt::format("{}_{}", joint_name(j), kNames[part]),
                       .direction = Vector3d::Unit(2 - part),
                       .anchor = vector3(m_->jnt_pos + 3 * j),
                       .part = part});
      }
      continue;
    }
    const bool turns = m_->jnt_type[j] == mjJNT_HINGE;
    out.push_back({.joint = j,
                   .dof = m_->jnt_dofadr[j],
                   .name = joint_name(j),
                   .turns = turns,
                   .limited = m_->jnt_limited[j] != 0,
                   .direction = vector3(m_->jnt_axis + 3 * j),
                   .anchor = turns ? vector3(m_->jnt_pos + 3 * j) : Vector3d::Zero(),
                   .reference = reference(j)});
  }
  return out;
}

double MjcfAxes::value(const MjcfAxis& axis, const mjtNum* qpos) const {
  const mjtNum* q = qpos + m_->jnt_qposadr[axis.joint];
  if (axis.part < 0) return q[0];
  const Matrix3d R = Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized().toRotationMatrix();
  constexpr double kUpright = 1e-7;  // below this cosine of y, z and x turn about the same axis, and x is set to 0
  const double cosine = std::hypot(R(0, 0), R(1, 0)), y = std::atan2(-R(2, 0), cosine);
  if (axis.part == 1) return y;
  if (cosine < kUpright) return axis.part == 0 ? std::atan2(-R(0, 1), R(1, 1)) : 0;
  return axis.part == 0 ? std::atan2(R(1, 0), R(0, 0)) : std::atan2(R(2, 1), R(2, 2));
}

}  // namespace stiction::world
