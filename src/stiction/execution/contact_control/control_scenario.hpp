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

/// Where the reference is at a time: joint positions (n_a), or the displacement of the tool from its pose at the start in W [m] and its rotation
/// vector [rad] (6).
struct ReferenceKnot {
  double time = 0;  ///< [s]
  Eigen::VectorXd value;
};

/// What a controller is told of contacts.
enum class ContactSource {
  True,       ///< those of the simulation, as if a skin measured them
  Estimated,  ///< what joint torques show: a momentum observer, then `ContactEstimator`
};

/// A robot whose reference goes through things that it does not know, as a YAML file says (tasks/control_scenario_file.hpp).
struct ControlScenario {
  std::string name, description;
  std::filesystem::path file;
  std::shared_ptr<const world::Model> model;
  Eigen::VectorXd start;             ///< joints (n_a)
  Eigen::VectorXd objects{};         ///< where objects of the scene are at the start (n_qu); empty: as Model::neutral() has them
  int tool = -1;                     ///< link that is tracked; −1: joints are
  world::Pose X_BT;                  ///< of the tool in its link
  std::vector<ReferenceKnot> knots;  ///< at rest in each, between them at s²(3 − 2s); the first at time 0
  HandPush hand;                     ///< that presses on the robot
  double duration = 0;               ///< [s], at least the last knot's time
  double period = 0.005;             ///< of the controller [s]
  control::ControllerOptions controller;
  simulation::PlantOptions plant;
  simulation::ImpedanceOptions impedance;
  ContactSource contacts = ContactSource::True;
  simulation::ObserverOptions observer;
  ContactEstimatorOptions estimator;        ///< what it is told by others: make_estimator_options()
  std::optional<double> plausible_force{};  ///< F of (C.12) [N], > 0; nullopt: twice lambda_max
  double demand = 4;  ///< R: forces that the reference asks for at most, in bounds, from which the damping (C.14) follows, > 0
  double delay = 0;   ///< of contacts or of torques and the joints at which they were measured, rounded to ticks [s], ≥ 0
};

/// Another bound of every contact force; a third of it counts as a contact at most. @throws core::InvalidInput: not positive
void set_lambda_max(ControlScenario& scenario, double lambda_max);

/// The estimator's options with noise and lag of the observer, and with what follows from the bounds of the controller: the force from which contacts count, and F.
ContactEstimatorOptions make_estimator_options(const ControlScenario& scenario);

/// Objects and joints at the start (n_q).
Eigen::VectorXd calc_start(const ControlScenario& scenario);

/// The reference at a time: value of the knots there, held after the last one.
void calc_reference(const ControlScenario& scenario, double time, Eigen::VectorXd& out);

}  // namespace stiction::execution
