#pragma once

#include <string>

#include "stiction/execution/touch/touch_run.hpp"

namespace stiction::app {

/// What the page of `stiction touch` is made of: that of `stiction control` in the simulated world, with touches, balls of the map and routes.
std::string touch_document(const execution::TouchScenario& scenario, const execution::TouchRunResult& result);

}  // namespace stiction::app
