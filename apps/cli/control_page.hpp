#pragma once

#include <string>
#include <string_view>

#include "stiction/execution/contact_control/control_run.hpp"

namespace stiction::app {

/// Unit of a thousandth of the tracking error: that of the tool, or of the joints.
std::string error_unit(const execution::ControlScenario& scenario);

/// What the page of `stiction control` is made of: every tick with its forces, errors and torques, and the poses of evenly chosen ticks.
std::string control_document(const execution::ControlScenario& scenario, const execution::ControlRunResult& result, std::string_view law);

}  // namespace stiction::app
