#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>

#include "app.hpp"
#include "stiction/core/parallel.hpp"

namespace stiction::app {
namespace fs = std::filesystem;

void add_task(CLI::App& command, std::string& task) {
  command.add_option("task", task, "Name of a built-in task, or a task file (.yaml)")->required();
}

void add_plan(CLI::App& command, std::string& plan) { command.add_option("plan", plan, "Plan file, or its folder")->required(); }

void add_seed(CLI::App& command, std::optional<std::uint64_t>& seed, const std::string& meaning) {
  add_integer(command, "--seed", seed, meaning);
}

void add_threads(CLI::App& command, std::optional<int>& threads) {
  add_integer(command, "--threads", threads, "Number of threads, 0 for all cores; the result does not depend on it",
              {0, core::kMostThreads});
}

void add_timeout(CLI::App& command, double& timeout_s, const std::string& meaning) {
  add_number(command, "--timeout", timeout_s, meaning, Bound::Positive);
}

void add_goal(CLI::App& command, std::string& goal) {
  command
      .add_option(
          "--goal", goal,
          "Goal pose, instead of the goal of the task: \"x y z roll pitch yaw\" [m, rad] for a free object, else the coordinates of its "
          "joints; ~ leaves a coordinate open")
      ->expected(1);
}

void add_scheme(CLI::App& command, std::string& scheme) {
  command.add_option(
      "--scheme", scheme,
      "Scheme of the local models of the dynamics: exact, analytic, randomized-first or randomized-zeroth (default: as in the task)");
}

void add_speed(CLI::App& command, double& speed) {
  add_number(command, "--speed", speed,
             "Factor on the full speed that follows from the object and the motors; above 1 only pushes are faster", Bound::Positive);
}

void add_out(CLI::App& command, std::string& dir, const std::string& what) { command.add_option("-o,--out", dir, what); }

void add_json(CLI::App& command, bool& json) {
  command.add_flag("--json", json, "One JSON object on stdout; the text for people goes to stderr");
}

fs::path task_dir(const std::string& out, const std::string& task, std::uint64_t seed) {
  if (!out.empty()) return out;
  std::string name = task;  // of a file, which may say anything: the folder lies in the working folder all the same
  std::ranges::replace_if(
      name, [](unsigned char c) { return c == '/' || c < 0x20 || c == 0x7f; }, '_');
  return fmt::format("{}-seed{}", name, seed);
}

fs::path plan_dir(const std::string& out, const fs::path& plan) {
  if (!out.empty()) return out;
  const fs::path dir = fs::is_directory(plan) ? plan : plan.parent_path();
  return dir.empty() ? fs::path(".") : dir;
}

std::FILE* people(bool json) { return json ? stderr : stdout; }

void print_row(std::FILE* to, std::string_view name, const std::string& value) { say(to, "  {:22} {}\n", name, value); }

}  // namespace stiction::app
