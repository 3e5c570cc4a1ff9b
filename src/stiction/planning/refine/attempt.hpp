#pragma once

#include "stiction/planning/refine/crew.hpp"
#include "stiction/planning/refine/problem.hpp"

namespace stiction::planning::refinement {

/// One way to refine a plan.
struct Trial {
  const char* name;
  const std::vector<Push>* pushes;
  bool rest;  ///< pushes end at rest; those in small steps where that does
  int cuts;   ///< sub-steps for each of the plan's
};

/// What came of a trial.
struct Attempt {
  bool worked = false;  ///< `refined` is a refined plan
  RefineResult refined;
  Work work;
};

/// Builds the plan anew, from push to push. At small steps every push is followed with feedback (E.6) and, where that misses, corrected by iMPC;
/// where it still misses, what is left is planned anew.
/// @param worker  thread of the crew that runs this, in its turn
Attempt attempt(const Problem& problem, const Trial& trial, Crew& crew, int worker, const Turn& turn);

}  // namespace stiction::planning::refinement
