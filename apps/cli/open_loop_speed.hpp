#pragma once

#include <string>

namespace CLI {
class App;
}

namespace stiction::app {

/// The option --speed of commands that are carried out without feedback.
void add_open_loop_speed(CLI::App& command, double& speed);

/// "0.1 of the full speed".
std::string describe_speed(double speed);

}  // namespace stiction::app
