#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "app.hpp"
#include "guard.hpp"
#include "import_command.hpp"
#include "python_command.hpp"
#include "run_command.hpp"
#include "stiction/core/version.hpp"
#include "touch_command.hpp"

namespace {

using namespace stiction;

struct Command {
  const char* name;
  const char* summary;
  app::Run (*declare)(CLI::App&);
};

constexpr Command kCommands[] = {
    {"tasks", "Built-in tasks with their sizes", app::declare_tasks},
    {"import", "Writes a task for a scene that is in one MJCF, URDF or SDF file: its robot, its objects, a start and a goal to edit",
     app::declare_import},
    {"lint", "Looks at a task without planning it: overlaps, units, what holds and reaches the object", app::declare_lint},
    {"plan", "Plans a task and writes the plan file", app::declare_plan},
    {"optimize", "Optimises a trajectory for a task (iMPC) and writes it as a plan", app::declare_optimize},
    {"check", "Re-simulates a plan at half its sub-step and judges it", app::declare_check},
    {"simulate", "Runs a plan open loop in MuJoCo and compares it with what the plan says", app::declare_simulate},
    {"refine", "Shortens a plan and gives its regrasps room; writes a new plan and timed commands", app::declare_refine},
    {"solve", "Plans, refines and simulates, seed after seed, until a plan reaches its goal in MuJoCo", app::declare_solve},
    {"run", "Brings an object to its goal in MuJoCo at real speed: carries plans out, and plans anew where they fail", app::declare_run},
    {"sense", "Says where a robot is touched, from joint angles and external torques", app::declare_sense},
    {"view", "Shows a plan, or a task before it is planned, in the browser", app::declare_view},
    {"export", "Writes a plan over time for other programs: CSV, NumPy, JSON, MCAP of ROS 2 messages, LeRobot", app::declare_python},
    {"stream", "Sends a plan, or a closed-loop run as it happens, to Foxglove or rerun: poses, meshes, joints, commands, contacts",
     app::declare_python},
    {"sweep", "Plans, checks and simulates many times, on all cores or a cluster: a table with a row per run", app::declare_python},
    {"benchmark", "Plans, checks and runs tasks on scenes of other packages with one set of settings: a table and a page",
     app::declare_python},
    {"grasps", "Writes states in which the robot holds the object at rest, with how much friction each can lose: starts for learners",
     app::declare_python},
    {"repair", "Makes a demonstration, which may break contact laws, into a plan of the contact model, and says what had to change",
     app::declare_python},
    {"report", "Packs a problem for those who are to look at it: task, seed, version, log, without paths or names", app::declare_python},
    {"studio", "Opens tasks in the browser: pose, plan, scrub, compare, export", app::declare_studio},
    {"control", "Runs an arm with bounded contact forces against what its reference does not know", app::declare_control},
    {"touch", "Sends an arm to a goal among things that it has to feel: bounded forces, contacts from torques, plans around them",
     app::declare_touch},
    {"bench", "Figures of this machine beside the published ones", app::declare_bench},
    {"reproduce", "Computes figures and tables of the thesis, beside the published numbers", app::declare_reproduce},
};

constexpr const char* kExitCodes =
    "Exit codes, the same in every command: 0 done; 1 judged, and does not pass (lint, check, simulate, control, touch, reproduce); "
    "2 a mistake in what was given; 3 not done within the budget (the best result is kept); "
    "70 a fault of the program or its installation; 130 interrupted (the best result is kept).";

/// @throws CLI::ValidationError: the first word is no command; CLI11 would say that one is missing
void require_command(int argc, char** argv) {
  if (argc < 2 || argv[1][0] == '-') return;
  std::string names;
  for (const Command& command : kCommands) {
    if (std::string_view(command.name) == argv[1]) return;
    names += (names.empty() ? "" : ", ") + std::string(command.name);
  }
  throw CLI::ValidationError("command", fmt::format("got '{}', expected one of {}", argv[1], names));
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
