#pragma once

#include <vector>

#include "stiction/planning/refine/problem.hpp"

namespace stiction::planning::refinement {

/// One way to refine a plan.
struct Trial {
  const char* name;
  const std::vector<Push>* pushes;
  bool rest;  ///< pushes end at rest; those in small steps where that does
  int cuts;   ///< sub-steps for each of the plan's
  bool after_break =
      false;  ///< only where the one before ended with a push that does not hold, and took little: one that is lost is lost again
};

/// Every sub-step of the plan in so many of the same length.
struct StepSizes {
  StepSizes(const Problem& problem, int parts);

  int cuts;                     ///< parts of a step of the plan
  bool coarse;                  ///< longer than asked for: the last resort, where pushes end as planned and iMPC only makes things worse
  dynamics::StepOptions exact;  ///< every knot follows from the one before it alone
  dynamics::SubstepLimits substep, free_substep;  ///< … and where the branches that move touch nothing, in commands as far as in the plan
  Eigen::VectorXd limits;                         ///< of the change of the command in a sub-step (n_a) [rad or m]
};

}  // namespace stiction::planning::refinement
