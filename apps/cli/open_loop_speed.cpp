#include "open_loop_speed.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "numbers.hpp"

namespace stiction::app {

void add_open_loop_speed(CLI::App& command, double& speed) {
  add_number(command, "--speed", speed,
             "Speed, times the full timing that follows from object and motors; above 1 only pushes are faster. Without feedback most "
             "plans hold at 0.1, and few at 1",
             Bound::Positive);
}

std::string describe_speed(double speed) { return fmt::format("{:g} of the full timing", speed); }

}  // namespace stiction::app
