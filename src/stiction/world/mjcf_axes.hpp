#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "stiction/world/mjcf_view.hpp"
#include "stiction/world/scene.hpp"

namespace stiction::world {

/// One axis of a joint of an MJCF: the joint turns about it or slides along it.
struct MjcfAxis {
  int joint = -1, dof = -1;
  std::string name;
  bool turns = true, limited = false;
  Eigen::Vector3d direction = Eigen::Vector3d::UnitZ(), anchor = Eigen::Vector3d::Zero();  ///< in the frame of the body
  double reference = 0;  ///< joint value at the pose of the file; MuJoCo measures the motion from there
  int part = -1;         ///< for a ball joint: 0, 1, 2 for its rotations about z, y and x; else −1

  Pose at(double value) const;
};

/// The axes of the joints of a compiled MJCF.
class MjcfAxes : private MjcfView {
 public:
  explicit MjcfAxes(const MjcfView& view) : MjcfView(view) {}

  /// Axes of the joints that move a body. A ball joint is approximated by three hinges, about z, then y, then x.
  std::vector<MjcfAxis> of(int body) const;
  /// Value of the axis's coordinate. @param qpos  configuration of MuJoCo
  double value(const MjcfAxis& axis, const mjtNum* qpos) const;
};

}  // namespace stiction::world
