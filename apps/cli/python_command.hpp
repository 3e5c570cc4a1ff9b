#pragma once

#include "app.hpp"

namespace stiction::app {

/// A command that the Python package carries out: it reads the words and explains itself.
Run declare_python(CLI::App& command);

}  // namespace stiction::app
