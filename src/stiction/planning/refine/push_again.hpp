#pragma once

#include "stiction/planning/refine/problem.hpp"

namespace stiction::planning::refinement {

/// The commands of a push in small steps until its objects rest, with feedback on where its objects are against where the plan has them: the command moves by
///   δ = argmin ‖W (B_u δ − e)‖² + γ ‖δ‖²,   δ within limits,                                                                     (E.6)
/// with B_u of the smoothed local model, e what the objects lack and W = 1/tolerance.
/// @param q_target  where the objects should end; on the way there they should be where the plan has them
/// @param feedback  without it δ = 0
/// @returns false: it comes to nothing
bool follow_push(const Problem& problem, const Cursor& start, const Push& push, const Eigen::VectorXd& q_target, bool feedback,
                 Scratch& scratch, Work& work, Run& run);

}  // namespace stiction::planning::refinement
