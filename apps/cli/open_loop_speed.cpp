#include "open_loop_speed.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "numbers.hpp"

namespace stiction::app {

void add_open_loop_speed(CLI::App& command, double& speed) {
  add_number(command, "--speed", speed,
             "Factor on the full speed that follows from the object and the motors; above 1 only pushes are faster. Without feedback, most "
             "plans reach their goal at 0.1, and few at 1",
             Bound::Positive);
}

std::string describe_speed(double speed) { return fmt::format("{:g} of the full speed", speed); }

}  // namespace stiction::app
