#pragma once

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <filesystem>
#include <limits>
#include <string>

#include "stiction/core/random.hpp"
#include "stiction/world/model.hpp"
#include "stiction/world/read.hpp"
#include "stiction/world/shapes.hpp"
#include "support/paths.hpp"

namespace stiction::world::test {

using stiction::test::source_dir;

inline constexpr double kInfinity = std::numeric_limits<double>::infinity();

inline std::shared_ptr<const Model> load_task(const std::string& task) {
  const std::filesystem::path packages[] = {stiction::test::package_dir()};
  return Model::make(load_scene(source_dir() / "tasks" / (task + ".yaml"), packages));
}

inline Eigen::VectorXd random_vector(core::Random& random, Eigen::Index n, double scale) {
  Eigen::VectorXd v(n);
  for (Eigen::Index i = 0; i < n; ++i) v[i] = scale * random.normal();
  return v;
}

inline Pose random_pose(core::Random& random) {
  const Eigen::Vector4d w = random_vector(random, 4, 1).normalized();
  return {Eigen::Quaterniond(w[0], w[1], w[2], w[3]).toRotationMatrix(), random_vector(random, 3, 1)};
}

/// Moves every coordinate of neutral() at random.
inline Eigen::VectorXd random_configuration(const Model& model, core::Random& random, double scale = 1) {
  Eigen::VectorXd q = model.neutral();
  retract(model, q, random_vector(random, model.n_v(), scale), q);
  return q;
}

inline ObjectSpec make_object(std::string name, ObjectJoint joint, const Pose& X_WP = {}) {
  ObjectSpec object;
  object.name = std::move(name);
  object.joint = joint;
  object.X_WP = X_WP;
  object.mass = 2;
  object.inertia << 0.3, 0.02, 0.01, 0.02, 0.4, -0.03, 0.01, -0.03, 0.5;
  object.geometries.push_back({.name = "ball", .shape = Sphere{0.1}, .X_BG = {}, .friction = 1});
  return object;
}

/// One object of every kind at random places, and a robot with every kind of joint.
inline Scene make_zoo(std::uint64_t seed = 0) {
  core::Random random(seed, 77);
  Scene scene;
  scene.name = "zoo";
  scene.gravity = Eigen::Vector3d(0.5, -1, -9);
  const std::pair<const char*, ObjectJoint> kinds[] = {{"xy", ObjectJoint::PlanarXY}, {"free", ObjectJoint::Free},
                                                       {"yz", ObjectJoint::PlanarYZ}, {"xz", ObjectJoint::PlanarXZ},
                                                       {"hinge", ObjectJoint::Hinge}, {"slider", ObjectJoint::Slider}};
  for (const auto& [name, joint] : kinds) {
    ObjectSpec object = make_object(name, joint, joint == ObjectJoint::Free ? Pose{} : random_pose(random));
    object.axis = random_vector(random, 3, 1).normalized();
    if (joint != ObjectJoint::Free) object.p_BCom = random_vector(random, 3, 0.2);
    scene.objects.push_back(object);
  }
  RobotSpec robot;
  robot.name = "odd";
  robot.urdf = source_dir() / "tests/world/data/odd_robot.urdf";
  robot.X_WBase = random_pose(random);
  for (const char* joint : {"slide", "turn", "a_left", "b_left", "a_right"}) robot.stiffness.emplace_back(joint, 10);
  scene.robots.push_back(robot);
  scene.fixed.push_back(
      {.name = "floor", .X_WB = {}, .geometries = {{.name = "ground", .shape = HalfSpace{}, .X_BG = {}, .friction = 0.5}}});
  return scene;
}

/// make_zoo with a slider on the hinge and a hinge on that slider.
inline Scene make_linked() {
  Scene scene = make_zoo();
  core::Random random(5, 78);
  for (const auto& [name, parent, joint] :
       {std::tuple{"drawer", "hinge", ObjectJoint::Slider}, std::tuple{"knob", "drawer", ObjectJoint::Hinge}}) {
    ObjectSpec object = make_object(name, joint, random_pose(random));
    object.parent = parent;
    object.axis = random_vector(random, 3, 1).normalized();
    object.p_BCom = random_vector(random, 3, 0.2);
    scene.objects.push_back(object);
  }
  return scene;
}

}  // namespace stiction::world::test
