#pragma once

#include "stiction/execution/closed_loop/simulated_plant.hpp"
#include "stiction/execution/touch/guarded_run.hpp"
#include "stiction/tasks/task.hpp"

namespace stiction::tasks {

/// Guarded moves before a run. They go on in the world in which the run goes on: SimulatedPlant(out.world, out.q, world) stands as they left it.
/// Fixed bodies of the task are then where they were felt. With a body go the objects that stand on it, as the scenario says, and so does a goal of theirs: it is
/// meant relative to what they stand on.
/// @param scenario  of load_touch_scenario(file, task)  @param world  its friction and masses are those of the moves as well  @param options  seed and control
/// Without moves nothing is felt, and the run goes by what is not right. The task then starts from where things are.
/// @returns as run_guarded(); the task is corrected by all that was felt, also where the moves were not `reached`
/// @throws core::InvalidInput: as run_guarded()
/// Tests: tests/tasks/touch_first_test.cpp
[[nodiscard]] core::Status touch_first(execution::TouchScenario scenario, const execution::WorldOptions& world,
                                       const execution::TouchRunOptions& options, Task& task, execution::GuardedRunResult& out);

}  // namespace stiction::tasks
