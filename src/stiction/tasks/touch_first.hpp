#pragma once

#include "stiction/execution/closed_loop/simulated_plant.hpp"
#include "stiction/execution/touch/guarded_run.hpp"
#include "stiction/tasks/task.hpp"

namespace stiction::tasks {

/// Makes guarded moves before a run and corrects the task by the contacts that they feel. The run continues in the same simulated world:
/// SimulatedPlant(out.world, out.q, world) starts in the state that the moves left.
/// Fixed bodies of the task are moved to where they were felt. The objects that stand on such a body move with it, as the scenario says,
/// and so do their goals, because a goal is meant relative to its support.
/// Without moves nothing is felt: the run uses the uncorrected, wrong positions, and the task starts from the true ones.
/// @param scenario  scenario from load_touch_scenario(file, task)  @param world  its friction and masses also hold for the moves
/// @param options   seed and control
/// @returns as run_guarded(); the task is corrected by everything that was felt, even if the moves were not `reached`
/// @throws core::InvalidInput: as run_guarded()
/// Tests: tests/tasks/touch_first_test.cpp
[[nodiscard]] core::Status touch_first(execution::TouchScenario scenario, const execution::WorldOptions& world,
                                       const execution::TouchRunOptions& options, Task& task, execution::GuardedRunResult& out);

}  // namespace stiction::tasks
