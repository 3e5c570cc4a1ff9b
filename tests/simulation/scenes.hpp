#pragma once

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <string>

#include "stiction/simulation/simulation.hpp"
#include "world/test_scenes.hpp"

namespace stiction::simulation::test {

using world::test::load_task;
using world::test::source_dir;

inline constexpr double kG = 9.81;

inline world::Scene empty_scene(const Eigen::Vector3d& gravity) {
  world::Scene scene;
  scene.name = "test";
  scene.gravity = gravity;
  return scene;
}

/// An object of the given shape with the inertia of uniform density.
inline world::ObjectSpec solid(world::ObjectJoint joint, const world::Shape& shape, double mass, double friction) {
  world::ObjectSpec object;
  object.name = "solid";
  object.joint = joint;
  object.mass = mass;
  object.geometries.push_back({.name = "shape", .shape = shape, .X_BG = {}, .friction = friction});
  const auto volume = world::calc_volume_properties(object.geometries);
  object.inertia = mass / volume.volume * volume.inertia;
  return object;
}

inline world::FixedSpec ground(double friction, const world::Pose& X_WB = {}) {
  world::FixedSpec fixed;
  fixed.name = "ground";
  fixed.X_WB = X_WB;
  fixed.geometries.push_back({.name = "plane", .shape = world::HalfSpace{}, .X_BG = {}, .friction = friction});
  return fixed;
}

/// The ball of radius 0.1 m on springs along y and z.
inline world::RobotSpec pusher(double stiffness, double friction = 1.0) {
  world::RobotSpec robot;
  robot.name = "hand";
  robot.urdf = source_dir() / "models" / "planar_pusher.urdf";
  robot.stiffness = {{"y", stiffness}, {"z", stiffness}};
  robot.friction = friction;
  return robot;
}

/// A plant with its workspace and result, driven by constant commands.
struct Rig {
  explicit Rig(const world::Scene& scene, const PlantOptions& options = {}) : Rig(world::Model::make(scene), options) {}
  explicit Rig(std::shared_ptr<const world::Model> made, const PlantOptions& options = {})
      : model(std::move(made)), plant(Plant::make(model, options)), work(plant) {}

  core::Status hold(const Eigen::VectorXd& q0, const Eigen::VectorXd& u, double duration, const Eigen::VectorXd* v0 = nullptr) {
    Eigen::MatrixXd commands(model->n_a(), 2);
    commands.colwise() = u;
    return simulate(*plant, {q0, Eigen::Vector2d(0, duration), commands, v0}, run, work, result);
  }

  Eigen::VectorXd q_end() const { return result.q.rightCols<1>(); }
  Eigen::VectorXd v_end() const { return result.v.rightCols<1>(); }

  /// Force of a pair at the end; zero where it does not touch.
  PairForce force(int pair = 0) const {
    for (const auto& f : result.forces.back()) {
      if (f.pair == pair) return f;
    }
    return {};
  }

  std::shared_ptr<const world::Model> model;
  std::shared_ptr<const Plant> plant;
  Workspace work;
  SimulationOptions run;
  SimulationResult result;
};

}  // namespace stiction::simulation::test
