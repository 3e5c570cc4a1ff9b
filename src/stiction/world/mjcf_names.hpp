#pragma once

#include <mujoco/mujoco.h>

#include <string>
#include <vector>

namespace stiction::world {

/// Makes a name of a file usable as a part of other names: without '/', '*' and blanks.
std::string usable(std::string name);

/// Names of the bodies and joints of a compiled MJCF, which are parts of other names. Each name is unique. A name that is usable stays as it is;
/// others are changed, and bodies and joints without a name get one.
class MjcfNames {
 public:
  explicit MjcfNames(const mjModel& m);

  const std::string& body(int body) const { return bodies_[static_cast<std::size_t>(body)]; }
  const std::string& joint(int joint) const { return joints_[static_cast<std::size_t>(joint)]; }

 private:
  std::vector<std::string> bodies_, joints_{};
};

}  // namespace stiction::world
