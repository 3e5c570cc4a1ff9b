#pragma once

#include <span>

#include "stiction/planning/refine/crew.hpp"
#include "stiction/planning/refine/problem.hpp"

namespace stiction::planning::refinement {

/// Where the commands lead at half the sub-step, and the worst that was met on the way.
struct HalfSteps {
  Eigen::VectorXd q, u;
  Worst worst;
  bool started = false;  ///< what is given may penetrate
};

/// Follows the commands of segments at half the sub-step of `options`, every step from its state alone.
/// @returns false: a step was not solved, something worse than allowed was met, or the run is to stop; `at` is there
bool go_on_in_half_steps(const Problem& problem, std::span<const Segment> segments, const dynamics::StepOptions& options,
                         const Worst& allowed, const core::RunControl& control, Scratch& scratch, HalfSteps& at, Work& work);

}  // namespace stiction::planning::refinement
