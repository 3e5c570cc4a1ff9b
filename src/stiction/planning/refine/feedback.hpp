#pragma once

#include "stiction/planning/refine/best_run.hpp"

namespace stiction::planning::refinement {

/// A push with feedback on its objects, its end at rest or not, and what feedback does after it. The command moves by
///   δ = argmin ‖W (B_u δ − e)‖² + γ ‖δ‖²,   δ within limits,                                                                     (E.6)
/// with B_u of the smoothed local model, e what the objects lack and W = 1/tolerance; γ is run.gamma.
/// @param q_target  where the objects should end; on the way there they should be where the plan has them
/// @returns false: it comes to nothing
bool push_with_feedback(CommandFollower& follower, const Push& push, const Eigen::VectorXd& q_target, Run& run);

}  // namespace stiction::planning::refinement
