#include "open_loop_speed.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>

namespace stiction::app {

void add_open_loop_speed(CLI::App& command, double& speed) {
  command
      .add_option("--speed", speed,
                  "Speed, times the full timing that follows from object and motors; above 1 only pushes are faster. Without feedback most "
                  "plans hold at 0.1, and few at 1")
      ->capture_default_str()
      ->check(CLI::PositiveNumber);
}

std::string describe_speed(double speed) { return fmt::format("{:g} of the full timing", speed); }

}  // namespace stiction::app
