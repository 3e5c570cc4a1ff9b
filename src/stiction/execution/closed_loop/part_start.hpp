#pragma once

#include <Eigen/Core>

#include "stiction/dynamics/step.hpp"

namespace stiction::execution {

/// A start for a simulated world.
struct PartedStart {
  Eigen::VectorXd q;   ///< in which nothing overlaps by more than share::kContact of its length
  double overlap = 0;  ///< deepest overlap of the start that was given, where it was moved apart [m]; 0: it is as it was given
  int pair = -1;       ///< that overlapped by so much
  double moved = 0;    ///< by how much an object was moved, at most [m or rad]
};

/// Moves what overlaps at a start apart as the planner does, by steps of the exact dynamics with the joints held, until nothing overlaps by more
/// than a tenth of what counts as contact. A plant that began in the overlap would throw things out of each other: its contacts are springs, and
/// the overlap is energy. A start without overlap stays as it is, and one that does not come apart is as far apart as it came.
/// @param q  configuration (n_q)  @param options  of the planner's steps
/// Tests: tests/execution/part_start_test.cpp
PartedStart part_start(const std::shared_ptr<const world::Model>& model, const Eigen::VectorXd& q, dynamics::StepOptions options);

}  // namespace stiction::execution
