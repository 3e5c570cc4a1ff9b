#pragma once

#include <memory>
#include <string>

#include "stiction/world/model.hpp"
#include "support/paths.hpp"

namespace stiction::control::test {

/// A KUKA iiwa 7 with the joint stiffness of the thesis.
inline std::shared_ptr<const world::Model> make_arm() {
  world::Scene scene;
  scene.name = "arm";
  world::RobotSpec robot;
  robot.name = "arm";
  robot.urdf = stiction::test::source_dir() / "models" / "iiwa7_balls.urdf";
  const double stiffness[] = {800, 600, 600, 600, 400, 200, 200};
  for (int j = 0; j < 7; ++j) robot.stiffness.emplace_back("joint_" + std::to_string(j + 1), stiffness[j]);
  scene.robots.push_back(robot);
  return world::Model::make(scene);
}

inline int find_body(const world::Model& model, const std::string& name) {
  for (std::size_t b = 0; b < model.bodies().size(); ++b)
    if (model.bodies()[b].name == name) return static_cast<int>(b);
  return -1;
}

inline Eigen::VectorXd posture() { return (Eigen::VectorXd(7) << 0, 0.6, 0, -1.4, 0, 1.1, 0).finished(); }

}  // namespace stiction::control::test
