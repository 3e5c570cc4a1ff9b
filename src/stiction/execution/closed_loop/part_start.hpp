#pragma once

#include <Eigen/Core>

#include "stiction/dynamics/step.hpp"

namespace stiction::execution {

/// Start for a simulated world, without deep overlaps.
struct PartedStart {
  Eigen::VectorXd q;   ///< configuration (n_q) in which nothing overlaps by more than share::kContact of its length
  double overlap = 0;  ///< deepest overlap of the given start [m]; 0: the start is unchanged
  int pair = -1;       ///< pair with the deepest overlap
  double moved = 0;    ///< largest displacement of an object [m or rad]
};

/// Moves objects that overlap at a start apart, as the planner does: by exact steps with the joints held, until nothing overlaps by more than a tenth of the
/// contact tolerance. Contacts of the simulation are springs, so an overlap stores energy and would throw objects apart. A start without overlap stays
/// unchanged. If the objects cannot be separated, the result is the farthest separation that was reached.
/// @param q  configuration (n_q)  @param options  options of the planner's steps
/// Tests: tests/execution/part_start_test.cpp
PartedStart part_start(const std::shared_ptr<const world::Model>& model, const Eigen::VectorXd& q, dynamics::StepOptions options);

}  // namespace stiction::execution
