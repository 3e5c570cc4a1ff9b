#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include "stiction/core/random.hpp"
#include "stiction/execution/closed_loop/driver.hpp"
#include "stiction/simulation/stepped_plant.hpp"

namespace stiction::execution {

/// A force on an object for a while. Those that act at the same time add up.
struct OutsidePush {
  int object = 0;
  double begin = 0, duration = 0;                     ///< [s] ≥ 0
  Eigen::Vector3d force_W = Eigen::Vector3d::Zero();  ///< at the centre of mass [N]
};

/// In what the simulated world differs from what is known of it.
struct WorldOptions {
  double friction = 1;     ///< every μ times this, ≥ 0
  double mass = 1;         ///< mass and inertia of every object times this, > 0
  double pose_noise = 0;   ///< standard deviation of each coordinate of a measured object position [m], ≥ 0
  double angle_noise = 0;  ///< … and of a rotation about each axis [rad], ≥ 0
  double pose_delay = 0;   ///< objects are seen where they were this long ago [s], ≥ 0
  std::uint64_t seed = 0;  ///< of the noise
  std::vector<OutsidePush> pushes{};
  void validate(const world::Model& model) const;  ///< @throws core::InvalidInput naming the field
};

/// A simulated world in which motors saturate, joints are told the speed of their commands and objects on joints come to rest.
std::shared_ptr<const simulation::Plant> make_world(const std::shared_ptr<const world::Model>& model, const WorldOptions& options);

/// MuJoCo behind the interface of a driver.
class SimulatedPlant final : public Driver {
 public:
  /// At rest in q (n_q), joints commanded where they are. @throws core::InvalidInput
  SimulatedPlant(const std::shared_ptr<const world::Model>& model, VectorRef q, const WorldOptions& options = {});

  bool read(Measurement& out) override;
  bool command(VectorRef u, double period) override;
  std::string message() const override { return plant_.message(); }

  /// A force that acts from now on beside the pushes of the options, in place of the one before; body −1 or a force of zero ends it. Whoever commands the plant
  /// may call it between two commands, as a hand at the object does that nobody knew of before. @throws core::InvalidInput: no body, not finite
  void hold_push(const simulation::Push& push);

  const simulation::SteppedPlant& world() const { return plant_; }  ///< as it is, without noise and delay
  /// Of all pairs the largest normal force on a free object so far, at the ends of periods, as a multiple of its weight; nothing without such an object.
  std::optional<double> largest_press() const { return press_; }
  Eigen::VectorXd take_torques() { return plant_.take_torques(); }  ///< of SteppedPlant

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
  std::deque<Seen> past_;  ///< as far back as the delay
  simulation::Push held_;
  std::vector<simulation::Push> acting_;
  core::Random random_;
  Eigen::VectorXd weight_;  ///< per geometry: of its free object [N], infinite for others
  std::optional<double> press_;
};

}  // namespace stiction::execution
