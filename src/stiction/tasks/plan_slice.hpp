#pragma once

#include <cstddef>

#include "stiction/tasks/plan_file.hpp"

namespace stiction::tasks {

/// Segments [first, last) of a plan as a plan of their own: it starts where the segment before them ends, as a given start. What the search said of itself stays;
/// its tree stays where the start does. status: that of the plan where they are its last ones, else Solved where they end within the tolerances of the goal, and
/// MaxIterations where not. A part that begins under load does not pass the checker's `start`: plans begin with their joints at their commands.
/// @throws core::InvalidInput: unless first < last ≤ segments
/// Tests: tests/tasks/plan_slice_test.cpp
PlanFile slice(const Task& task, const PlanFile& plan, std::size_t first, std::size_t last);

}  // namespace stiction::tasks
