#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "stiction/control/controller.hpp"
#include "stiction/execution/contact_control/contact_estimator.hpp"
#include "stiction/execution/contact_control/hand_push.hpp"
#include "stiction/simulation/impedance.hpp"
#include "stiction/simulation/momentum_observer.hpp"
#include "stiction/simulation/simulation.hpp"
#include "stiction/world/model.hpp"

namespace stiction::execution {

/// Reference at one time: joint positions (n_a), or for a tool (6) its displacement from the start pose in W [m] and its rotation vector [rad].
struct ReferenceKnot {
  double time = 0;  ///< [s]
  Eigen::VectorXd value;
};

/// Source of the contacts given to a controller.
enum class ContactSource {
  True,       ///< contacts of the simulation, as if a skin measured them
  Estimated,  ///< contacts from joint torques: a momentum observer, then `ContactEstimator`
};

/// A robot whose reference leads through obstacles unknown to it. Read from a YAML file (tasks/control_scenario_file.hpp).
struct ControlScenario {
  std::string name, description;
  std::filesystem::path file;
  std::shared_ptr<const world::Model> model;
  Eigen::VectorXd start;      ///< joints (n_a)
  Eigen::VectorXd objects{};  ///< objects at the start (n_qu); empty: as in Model::neutral()
  int tool = -1;              ///< link of the tracked tool; −1: joints are tracked
  world::Pose X_BT;           ///< pose of the tool in its link
  /// Knots of the reference, which rests in each knot and moves at s²(3 − 2s) between them; the first at time 0.
  std::vector<ReferenceKnot> knots;
  HandPush hand;          ///< hand that presses on the robot
  double duration = 0;    ///< duration [s], at least the last knot's time
  double period = 0.005;  ///< period of the controller [s]
  control::ControllerOptions controller;
  simulation::PlantOptions plant;
  simulation::ImpedanceOptions impedance;
  ContactSource contacts = ContactSource::True;
  simulation::ObserverOptions observer;
  ContactEstimatorOptions estimator;        ///< completed by make_estimator_options()
  std::optional<double> plausible_force{};  ///< F of (C.12) [N], > 0; empty: twice lambda_max
  double demand = 4;                        ///< R: largest force that the reference asks for, in bounds, > 0; sets the damping (C.14)
  double delay = 0;                         ///< delay of contacts, or of torques and their joints, rounded to ticks [s], ≥ 0
};

/// Sets the bound of every contact force. The force from which a contact counts becomes at most a third of the bound. @throws core::InvalidInput: not positive
void set_lambda_max(ControlScenario& scenario, double lambda_max);

/// Completes the estimator's options: noise and lag of the observer, and from the bounds of the controller the force from which contacts count, and F.
ContactEstimatorOptions make_estimator_options(const ControlScenario& scenario);

/// Configuration at the start (n_q).
Eigen::VectorXd calc_start(const ControlScenario& scenario);

/// Computes the reference at a time; after the last knot its value is held.
void calc_reference(const ControlScenario& scenario, double time, Eigen::VectorXd& out);

}  // namespace stiction::execution
