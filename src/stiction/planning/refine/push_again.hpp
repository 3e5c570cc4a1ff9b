#pragma once

#include "stiction/planning/refine/problem.hpp"

namespace stiction::planning::refinement {

/// The commands of a push in small steps, with feedback on where its objects are against where the plan has them: the command moves by
///   δ = argmin ‖W (B_u δ − e)‖² + γ ‖δ‖²,   δ within limits,                                                                     (E.6)
/// with B_u of the smoothed local model, e what the objects lack and W = 1/tolerance.
/// @param q_target  where the objects should end; on the way there they should be where the plan has them
/// @param feedback  without it δ = 0
/// @returns false: it comes to nothing
bool follow_push(const Problem& problem, const Cursor& start, const Push& push, const Eigen::VectorXd& q_target, bool feedback,
                 Scratch& scratch, Work& work, Run& run);

/// Holds the last command until the objects rest: the regularisation holds objects back in every sub-step (S.3), in the world nothing does for long.
bool come_to_rest(const Problem& problem, Scratch& scratch, Work& work, Run& run);

/// iMPC (Alg. 1) starts from the commands of a push that ends away from its target. Its commands replace them if they end nearer.
/// @param spent  by iMPC so far, in units of kMostWork; counts up
/// @returns true: `run` was replaced
bool correct_by_impc(const Problem& problem, const Cursor& start, const Eigen::VectorXd& q_target, Scratch& scratch, double& spent,
                     Work& work, Run& run);

}  // namespace stiction::planning::refinement
