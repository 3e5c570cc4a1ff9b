#pragma once

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <filesystem>
#include <string>

#include "stiction/core/random.hpp"
#include "stiction/dynamics/rollout.hpp"
#include "stiction/world/model.hpp"

namespace stiction::dynamics::test {

inline std::filesystem::path source_dir() { return STICTION_SOURCE_DIR; }

inline std::shared_ptr<const world::Model> load_task(const std::string& task) {
  return world::Model::make(world::load_scene(source_dir() / "tasks" / (task + ".yaml")));
}

/// The ball of radius 0.1 m on springs of 100 N/m along y and z.
inline world::RobotSpec pusher(double friction = 1.0) {
  world::RobotSpec robot;
  robot.name = "hand";
  robot.urdf = source_dir() / "models" / "planar_pusher.urdf";
  const auto model = load_task("planar_pushing");
  for (const auto& dof : model->dofs()) {
    if (dof.owner_kind == world::BodyKind::Robot) robot.stiffness.emplace_back(dof.name.substr(dof.name.rfind('/') + 1), 100.0);
  }
  robot.friction = friction;
  return robot;
}

inline world::FixedSpec half_space(const Eigen::Vector3d& normal, const Eigen::Vector3d& point, double friction) {
  world::FixedSpec fixed;
  fixed.name = "ground";
  fixed.X_WB.R = Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), normal).toRotationMatrix();
  fixed.X_WB.p = point;
  fixed.geometries.push_back({.name = "plane", .shape = world::HalfSpace{}, .X_BG = {}, .friction = friction});
  return fixed;
}

inline world::ObjectSpec ball(world::ObjectJoint joint, double mass, double radius, double friction) {
  world::ObjectSpec object;
  object.name = "ball";
  object.joint = joint;
  object.mass = mass;
  object.inertia = 0.4 * mass * radius * radius * Eigen::Matrix3d::Identity();
  object.geometries.push_back({.name = "ball", .shape = world::Sphere{radius}, .X_BG = {}, .friction = friction});
  return object;
}

inline world::Scene empty_scene() {
  world::Scene scene;
  scene.name = "test";
  scene.gravity.setZero();
  scene.contact_distance = 10;
  return scene;
}

}  // namespace stiction::dynamics::test
