#pragma once

#include "control/arm_scene.hpp"
#include "stiction/control/controller.hpp"
#include "stiction/world/point_jacobian.hpp"

namespace stiction::control::test {

inline constexpr double kTick = 0.005;

/// The arm, a force that pushes its last link back, and a reference that presses on.
struct Bench {
  explicit Bench(const ControllerOptions& options = {})
      : model(make_arm()), controller(model, options), link(find_body(*model, "arm/link_7")) {
    controller.configure(q);
    contacts.push_back({.id = 3, .body = link, .p_WC = Eigen::Vector3d(0.6, 0.03, 0.36), .force_W = Eigen::Vector3d(0, -12, 0)});
  }

  const ControllerCommand& update() {
    time += kTick;
    return controller.update({.time = time, .q = q, .q_ref = q_ref, .contacts = contacts, .speed_share = speed_share}, kTick);
  }

  std::shared_ptr<const world::Model> model;
  ContactController controller;
  int link;
  double time = 0, speed_share = 1;
  Eigen::VectorXd q = posture(), q_ref = posture();
  std::vector<ContactForce> contacts;
};

/// The contact of a Bench: row of J_u, softness, and how hard q_to would press it.
struct Row {
  explicit Row(const Bench& bench) {
    world::KinematicsWorkspace work(*bench.model);
    world::Kinematics kinematics;
    calc_kinematics(*bench.model, bench.q, work, kinematics);
    RowMatrix J(6, 7);
    world::calc_point_jacobian(*bench.model, kinematics, bench.link, bench.contacts[0].p_WC, J);
    J_u = -J.row(1);
    softness = (J_u.array().square() / bench.model->stiffness().array()).sum();
  }
  double calc_force(const Eigen::VectorXd& q_to, const Eigen::VectorXd& q) const { return -J_u.dot(q_to - q) / softness; }
  Eigen::VectorXd J_u;
  double softness;
};

}  // namespace stiction::control::test
