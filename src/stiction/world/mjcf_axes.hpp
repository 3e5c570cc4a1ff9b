#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "stiction/world/mjcf_view.hpp"
#include "stiction/world/scene.hpp"

namespace stiction::world {

/// An axis that a joint of an MJCF turns about or slides along.
struct MjcfAxis {
  int joint = -1;
  std::string name;
  bool turns = true, limited = false;
  Eigen::Vector3d direction = Eigen::Vector3d::UnitZ(), anchor = Eigen::Vector3d::Zero();  ///< in the body
  double reference = 0;  ///< the value at the pose of the file, from which MuJoCo measures
  int part = -1;         ///< of a ball: 0, 1, 2 for its turns about z, y and x

  Pose at(double value) const;
};

/// The axes of the joints of a compiled MJCF.
class MjcfAxes : private MjcfView {
 public:
  explicit MjcfAxes(const MjcfView& view) : MjcfView(view) {}

  /// Of the joints of a body that move it. A ball turns about z, then y, then x: as near as three hinges come to it.
  std::vector<MjcfAxis> of(int body) const;
  /// Of its coordinate. @param qpos  of MuJoCo
  double value(const MjcfAxis& axis, const mjtNum* qpos) const;
};

}  // namespace stiction::world
