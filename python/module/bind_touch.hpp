#pragma once

#include "bindings.hpp"
#include "scenario_file.hpp"
#include "stiction/execution/touch/guarded_run.hpp"
#include "stiction/execution/touch/touch_run.hpp"

namespace stiction::python {

/// A file, or the name of a built-in scenario; reads without the lock of the interpreter.
execution::TouchScenario load_touch_scenario(const ScenarioFile& scenario);
/// @param seed  nothing: that of the scenario
execution::TouchRunOptions touch_options(const execution::TouchScenario& scenario, std::optional<std::uint64_t> seed, double settle);

/// A contact that ended a move, with the name of its link.
struct FeltContact {
  std::string link;
  execution::FeltContact values;
};

struct GuardedMoveResult {
  execution::MoveResult values;
  std::vector<FeltContact> felt;
  std::string corrected;  ///< fixed body; empty: none
};

struct GuardedResult {
  execution::GuardedRunResult result;
  std::vector<GuardedMoveResult> moves;
};

/// Names what was felt, once the moves are over.
void name_moves(const execution::TouchScenario& scenario, GuardedResult& out);

void bind_touch(nb::module_& m);
void bind_guarded(nb::module_& m);

}  // namespace stiction::python
