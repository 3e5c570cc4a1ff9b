#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "app.hpp"
#include "guard.hpp"
#include "import_command.hpp"
#include "python_command.hpp"
#include "run_command.hpp"
#include "stiction/core/version.hpp"
#include "stiction/world/yaml.hpp"
#include "touch_command.hpp"

namespace {

using namespace stiction;

struct Command {
  const char* name;
  const char* summary;
  app::Run (*declare)(CLI::App&);
};

constexpr Command kCommands[] = {
    {"tasks", "Lists the built-in tasks with their sizes", app::declare_tasks},
    {"import", "Writes a task for the scene of an MJCF, URDF or SDF file, with its robot and objects, a start, and a goal to edit",
     app::declare_import},
    {"lint", "Names likely mistakes of a task without planning it: overlaps, wrong units, objects and goals that nothing holds or reaches",
     app::declare_lint},
    {"plan", "Plans a task and writes the plan file", app::declare_plan},
    {"optimize", "Optimises a trajectory for a task (iMPC) and writes it as a plan", app::declare_optimize},
    {"check", "Simulates a plan again in half steps, and accepts it or names the limit that it exceeds", app::declare_check},
    {"simulate", "Executes a plan open loop in MuJoCo, and compares the motion with the planned motion", app::declare_simulate},
    {"refine", "Makes a plan shorter, with more clearance in its regrasps; writes a new plan and timed commands", app::declare_refine},
    {"solve", "Plans, refines and simulates with one seed after another, until a plan reaches its goal in MuJoCo", app::declare_solve},
    {"run", "Moves an object to its goal in closed loop in MuJoCo at real speed, and plans again when a plan fails", app::declare_run},
    {"sense", "Finds where a robot is touched, from joint angles and external joint torques", app::declare_sense},
    {"view", "Shows a plan, or a task before it is planned, in the browser", app::declare_view},
    {"export", "Writes the motion of a plan over time for other programs: CSV, NumPy, JSON, MCAP with ROS 2 messages, LeRobot",
     app::declare_python},
    {"stream", "Shows a plan, or a closed-loop run as it happens, in Foxglove or rerun: poses, meshes, joints, commands, contacts",
     app::declare_python},
    {"sweep", "Plans, checks and simulates many times, on all cores or a cluster, and writes a table with one row per run",
     app::declare_python},
    {"benchmark", "Plans, checks and runs tasks in scenes of other packages with the same settings for all; writes a table and a page",
     app::declare_python},
    {"grasps",
     "Writes states in which the robot holds the object at rest, and the share of friction that each state can lose; they serve as start "
     "states for learning",
     app::declare_python},
    {"repair", "Turns a demonstration, which may violate contact, into a plan that obeys the contact model, and says which motions changed",
     app::declare_python},
    {"report", "Packs task, seed, version and logs into a zip file for a problem report, without paths and names", app::declare_python},
    {"studio", "Opens the studio, in which you pose, plan, play, compare and export in the browser", app::declare_studio},
    {"control", "Moves an arm along a reference motion with bounded contact forces; contacts are given, or estimated from joint torques",
     app::declare_control},
    {"touch",
     "Moves an arm to its goal past obstacles that it must feel from joint torques, or until it touches a surface, with bounded forces",
     app::declare_touch},
    {"bench", "Measures the times of steps, trees and solvers on this machine, beside the published times", app::declare_bench},
    {"reproduce", "Computes figures and tables of the thesis, and compares them with the published numbers", app::declare_reproduce},
};

constexpr const char* kExitCodes =
    "Exit codes of all commands:\n"
    "  0    done\n"
    "  1    the result does not pass its test (lint, check, simulate, control, touch, reproduce)\n"
    "  2    the input has a mistake\n"
    "  3    not done within the budget (plan, solve and optimize keep the best result); or the plan missed its goal already when it was "
    "planned\n"
    "  70   error of the program or its installation\n"
    "  130  interrupted; the best result is kept";

/// @throws CLI::ValidationError: the first word is no command; CLI11 would say that one is missing
void require_command(int argc, char** argv) {
  if (argc < 2 || argv[1][0] == '-') return;
  std::vector<std::string> names;
  for (const Command& command : kCommands) {
    if (std::string_view(command.name) == argv[1]) return;
    names.emplace_back(command.name);
  }
  throw CLI::ValidationError("command", fmt::format("got '{}', expected one of {}", argv[1], world::list_with_hint(argv[1], names)));
}

/// @throws CLI::ValidationError: a word is empty, as an unset variable of a shell; it would be taken for an option that is not given
void require_words(int argc, char** argv) {
  for (int i = 1; i < argc; ++i) {
    const std::string_view word = argv[i];
    const bool is_empty_option = word.starts_with("--") && word.ends_with("=");
    const bool is_note = word.starts_with("--note") || std::string_view(argv[i - 1]) == "--note";
    if ((word.empty() || is_empty_option) && !is_note)
      throw CLI::ValidationError(is_empty_option ? argv[i] : argv[i - 1], "got an empty word after it, expected a value or nothing");
  }
}

/// @throws CLI::ValidationError: '-' for an output, which other programs take for stdout. Only `import` writes there
void require_named_outputs(int argc, char** argv) {
  if (argc < 2 || std::string_view(argv[1]) == "import") return;
  for (int i = 2; i < argc; ++i) {
    const std::string_view word = argv[i], before = argv[i - 1];
    const bool is_output = before == "-o" || before == "--out" || before == "--html";
    if ((word == "-" && is_output) || word == "-o-" || word == "--out=-" || word == "--html=-")
      throw CLI::ValidationError(
          std::string(is_output       ? before
                      : word == "-o-" ? "-o"
                                      : word.substr(0, word.find('='))),
          "got '-', expected the name of a file or folder: no result is written to stdout; --json writes a summary there");
  }
}

}  // namespace

int main(int argc, char** argv) {
  return app::guard("stiction", argc, argv, [&]() -> int {
    CLI::App cli("Plans robot motion through contact.", "stiction");
    cli.set_version_flag("--version", std::string("stiction ") + std::string(core::version()));
    cli.require_subcommand(1);
    cli.footer(kExitCodes);
    std::vector<std::pair<CLI::App*, app::Run>> commands;
    for (const Command& command : kCommands) {
      CLI::App* subcommand = cli.add_subcommand(command.name, command.summary);
      commands.emplace_back(subcommand, command.declare(*subcommand));
    }
    try {
      require_command(argc, argv);
      require_words(argc, argv);
      require_named_outputs(argc, argv);
      cli.parse(argc, argv);
    } catch (const CLI::Success& e) {
      return cli.exit(e);
    }
    for (const auto& [subcommand, run] : commands) {
      if (*subcommand) return run();
    }
    return app::kInternalError;
  });
}
