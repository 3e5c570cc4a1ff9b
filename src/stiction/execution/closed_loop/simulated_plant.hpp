#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include "stiction/core/random.hpp"
#include "stiction/execution/closed_loop/driver.hpp"
#include "stiction/simulation/stepped_plant.hpp"

namespace stiction::execution {

/// A force on an object for a limited time. Forces that act at the same time add up.
struct OutsidePush {
  int object = 0;
  double begin = 0, duration = 0;                     ///< begin and duration [s], ≥ 0
  Eigen::Vector3d force_W = Eigen::Vector3d::Zero();  ///< force at the centre of mass [N]
};

/// Differences between the simulated world and the model of the planner.
struct WorldOptions {
  double friction = 1;     ///< factor of every μ, ≥ 0
  double mass = 1;         ///< factor of the mass and inertia of every object, > 0
  double pose_noise = 0;   ///< standard deviation of each coordinate of a measured object position [m], ≥ 0
  double angle_noise = 0;  ///< standard deviation of the measured rotation about each axis [rad], ≥ 0
  double pose_delay = 0;   ///< delay of the measured object poses [s], ≥ 0
  std::uint64_t seed = 0;  ///< seed of the noise
  std::vector<OutsidePush> pushes{};
  void validate(const world::Model& model) const;  ///< @throws core::InvalidInput naming the field
};

/// Makes a simulated world in which motors saturate, joint springs are damped against the speed of their commands, and objects on joints come to rest.
std::shared_ptr<const simulation::Plant> make_world(const std::shared_ptr<const world::Model>& model, const WorldOptions& options);

/// MuJoCo simulation behind the Driver interface.
class SimulatedPlant final : public Driver {
 public:
  /// Starts at rest in q (n_q), with the joints commanded to their positions. @throws core::InvalidInput
  SimulatedPlant(const std::shared_ptr<const world::Model>& model, VectorRef q, const WorldOptions& options = {});

  bool read(Measurement& out) override;
  bool command(VectorRef u, double period) override;
  std::string message() const override { return plant_.message(); }

  /// Sets a force that acts from now on, in addition to the pushes of the options, and replaces the one set before. Body −1 or a zero force ends it. It may be
  /// called between two commands, to simulate an unexpected hand at the object. @throws core::InvalidInput: no such body, force not finite
  void hold_push(const simulation::Push& push);

  const simulation::SteppedPlant& world() const { return plant_; }  ///< true state, without noise and delay
  /// Largest normal force of any pair on a free object so far, at the ends of periods, as a multiple of its weight; empty without a free object.
  std::optional<double> largest_press() const { return press_; }
  Eigen::VectorXd take_torques() { return plant_.take_torques(); }  ///< see SteppedPlant::take_torques

 private:
  void apply_pushes(double period);
  void raise_press();

  std::shared_ptr<const world::Model> model_;
  WorldOptions options_;
  simulation::SteppedPlant plant_;
  struct Seen {
    double time;
    Eigen::VectorXd q;
  };
  std::deque<Seen> past_;  ///< past states, as far back as the delay
  simulation::Push held_;
  std::vector<simulation::Push> acting_;
  core::Random random_;
  Eigen::VectorXd weight_;  ///< per geometry: weight of its free object [N], infinite for other geometries
  std::optional<double> press_;
};

}  // namespace stiction::execution
