#pragma once

#include <Eigen/Core>
#include <vector>

#include "stiction/contact/contact.hpp"
#include "stiction/core/run_control.hpp"
#include "stiction/world/moving_links.hpp"

namespace stiction::contact {

/// Kinematics and distances of one thread, without dynamics.
struct GeometryWorkspace {
  explicit GeometryWorkspace(const world::Model& model) : kinematics_work(model), contact_work(model) {}

  world::KinematicsWorkspace kinematics_work;
  world::Kinematics kinematics;
  world::MovingLinks links;  // links that move in a search over a few joints
  Workspace contact_work;
  std::vector<Contact> contacts;
  std::vector<int> pairs;
  const core::RunControl* control = nullptr;  // control of the running search; after a stop, long computations end without a result
  bool stop() const { return control != nullptr && control->stop(); }
};

}  // namespace stiction::contact
