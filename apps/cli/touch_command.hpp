#pragma once

#include "app.hpp"

namespace stiction::app {

/// Declares the options of `stiction touch` and returns what to run.
Run declare_touch(CLI::App& command);

}  // namespace stiction::app
