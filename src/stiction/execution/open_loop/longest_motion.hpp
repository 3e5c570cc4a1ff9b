#pragma once

#include "stiction/execution/open_loop/trajectory.hpp"

namespace stiction::execution {

/// Refuses motions whose times are no longer exact to a microsecond, or beyond what a time stamp holds.
/// @throws core::InvalidInput naming speed and pause: longer than 1e9 s
Trajectory require_duration(Trajectory trajectory);

}  // namespace stiction::execution
