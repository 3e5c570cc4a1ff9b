#pragma once

#include "app.hpp"

namespace stiction::app {

Run declare_run(CLI::App& command);

}  // namespace stiction::app
