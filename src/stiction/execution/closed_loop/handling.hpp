#pragma once

#include <deque>
#include <optional>
#include <vector>

#include "stiction/execution/closed_loop/run.hpp"
#include "stiction/execution/closed_loop/simulated_plant.hpp"

namespace stiction::execution {

/// How gently a run handled its free objects, measured in the simulation.
struct Handling {
  std::optional<double> force;  ///< largest normal force of one pair on a free object, as a multiple of its weight; empty: no free object
  std::vector<double> slip_speeds;  ///< per piece, until the next piece began: how much faster than planned a free object was [m/s]
  double slip_speed() const;        ///< largest slip speed [m/s]; 0 if there is none
};

/// Measures Handling: looks at the simulation whenever the run looks at its objects.
class HandlingWatch {
 public:
  explicit HandlingWatch(const SimulatedPlant& plant) : plant_(plant), model_(plant.world().plant().model()) {}
  void take(const RunSample& sample);
  Handling result() const;

 private:
  double planned_speed(const RunSample& sample);

  const SimulatedPlant& plant_;
  const world::Model& model_;
  struct Planned {
    double time, speed;
    Eigen::VectorXd q;
  };
  std::deque<Planned> planned_;  ///< planned states of the last kTrail seconds, because objects trail their plans
  std::vector<double> slip_speeds_;
};

}  // namespace stiction::execution
