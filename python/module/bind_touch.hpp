#pragma once

#include "bindings.hpp"
#include "scenario_file.hpp"
#include "stiction/execution/touch/touch_run.hpp"

namespace stiction::python {

/// A file, or the name of a built-in scenario; reads without the lock of the interpreter.
execution::TouchScenario load_touch_scenario(const ScenarioFile& scenario);
/// @param seed  nothing: that of the scenario
execution::TouchRunOptions touch_options(const execution::TouchScenario& scenario, std::optional<std::uint64_t> seed, double settle);

void bind_touch(nb::module_& m);
void bind_guarded(nb::module_& m);

}  // namespace stiction::python
