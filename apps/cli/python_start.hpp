#pragma once

#include "app.hpp"

namespace stiction::app {

/// Python packages that a command needs beside those of its interpreter.
enum class Packages {
  Viewer,           ///< stiction_view
  Module,           ///< stiction
  ViewerAndModule,  ///< both
  Experiments       ///< experiments, and stiction
};

/// A module and its words, as `python -m` runs them; its output goes to stderr.
/// @returns its exit code  @throws InstallationFault: a package or the interpreter is missing
int run_python(const std::string& command, Packages packages, const std::vector<std::string>& words);

/// The same in the place of this program: signals, output and exit code are the interpreter's.
[[noreturn]] void become_python(const std::string& command, Packages packages, const std::vector<std::string>& words);

}  // namespace stiction::app
