#pragma once

#include "app.hpp"

namespace stiction::app {

Run declare_import(CLI::App& command);

}  // namespace stiction::app
