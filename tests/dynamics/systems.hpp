#pragma once

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <filesystem>
#include <memory>
#include <string>

#include "stiction/core/random.hpp"
#include "stiction/dynamics/rollout.hpp"
#include "stiction/dynamics/step.hpp"
#include "stiction/world/model.hpp"
#include "world/test_scenes.hpp"

namespace stiction::dynamics::test {

using world::test::load_task;
using world::test::source_dir;

inline constexpr double kGravity = 9.81;

/// A state of the task around the object with the fingers near it, so that several contacts act.
inline Eigen::VectorXd sample_task(const std::string& task, const world::Model& model, core::Random& random) {
  Eigen::VectorXd q = model.neutral();
  if (task == "allegro_ball") {
    Eigen::VectorXd anchor(16);
    anchor << 0.03501504, 0.75276565, 0.74146232, 0.83261002, -0.1438725, 0.74696812, 0.61908827, 0.70064279, -0.06922541, 0.78533142,
        0.82942863, 0.90415436, 0.63256269, 1.02378254, 0.64089555, 0.82444782;
    q.head<3>() << -0.081, 0.001, 0.071;
    q.tail(16) = anchor;
  } else if (task == "planar_hand") {
    q.head<3>() << 0, 0.35, 0.4;
    q.tail(4) << -0.85, -0.85, 0.85, 0.85;
  } else {
    q << 0.1, 0.5, 0.05, 0.2, -0.1;
  }
  Eigen::VectorXd delta(model.n_v());
  for (Eigen::Index i = 0; i < delta.size(); ++i) {
    const bool revolute = model.dofs()[static_cast<std::size_t>(i)].kind == world::DofKind::Revolute;
    delta[i] = (revolute ? 0.05 : 0.004) * random.normal();
  }
  world::retract(model, q, delta, q);
  q.tail(model.n_a()) = q.tail(model.n_a()).cwiseMax(model.lower()).cwiseMin(model.upper()).eval();
  return q;
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

/// Steps of a scene that have to be solved.
struct Stepper {
  explicit Stepper(const world::Scene& scene) : model(world::Model::make(scene)), work(model) {}
  StepResult operator()(const Eigen::VectorXd& q, const Eigen::VectorXd& u, const StepOptions& options = {},
                        const Eigen::VectorXd* tau = nullptr) {
    StepResult out;
    EXPECT_EQ(step(*model, {q, u, tau}, options, work, out), core::Status::Solved);
    return out;
  }
  std::shared_ptr<const world::Model> model;
  StepWorkspace work;
};

inline world::Scene empty_scene() {
  world::Scene scene;
  scene.name = "test";
  scene.gravity.setZero();
  scene.contact_distance = 10;
  return scene;
}

}  // namespace stiction::dynamics::test
