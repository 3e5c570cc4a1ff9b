#pragma once

#include <cstddef>

#include "stiction/tasks/plan_file.hpp"

namespace stiction::tasks {

/// Makes a plan of the segments [first, last) of a plan. It starts at the end of the segment before them, as a given start. The figures of
/// the search are kept; the search tree is kept only if the start is unchanged. status: if the slice includes the last segment, the status
/// of the plan; otherwise Solved if it ends within the tolerances of the goal, else MaxIterations. A slice that begins under load fails the
/// `start` check, because plans begin with the joints at their commands.
/// @throws core::InvalidInput: unless first < last ≤ segments
/// Tests: tests/tasks/plan_slice_test.cpp
PlanFile slice(const Task& task, const PlanFile& plan, std::size_t first, std::size_t last);

}  // namespace stiction::tasks
