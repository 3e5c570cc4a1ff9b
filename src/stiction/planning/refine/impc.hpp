#pragma once

#include "stiction/planning/refine/best_run.hpp"

namespace stiction::planning::refinement {

/// iMPC (Alg. 1) starts from the commands of a push that ends away from its target. What comes out replaces them if it ends nearer.
/// @param scratch  of the thread that runs the trial
/// @param spent    by the trial so far, as the bound in impc.cpp measures it; counts up
/// @param work     counts up
/// @returns true: `run` was replaced
bool correct_by_impc(const Start& start, const Eigen::VectorXd& q_target, Scratch& scratch, int threads, double& spent, Run& run,
                     Work& work);

}  // namespace stiction::planning::refinement
