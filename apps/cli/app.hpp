#pragma once

#include <atomic>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "numbers.hpp"
#include "output.hpp"
#include "stiction/core/run_control.hpp"
#include "stiction/core/status.hpp"

namespace CLI {
class App;
}

namespace stiction::execution {
struct Trajectory;
}
namespace stiction::tasks {
struct Finding;
struct Task;
}  // namespace stiction::tasks
namespace stiction::world {
class Model;
}

namespace stiction::app {

/// Exit codes of the program, with one meaning in every command.
enum ExitCode : int {
  kDone = 0,
  kCheckFailed = 1,     ///< what was given was judged and does not pass: check, simulate, lint; a deviation in reproduce
  kBadInput = 2,        ///< the caller's mistake, and nothing else
  kNotSolved = 3,       ///< the budget or the search ended first; the best result is kept
  kInternalError = 70,  ///< a fault of the program or of its installation
  kInterrupted = 130
};

/// Of a command that judges what it ran. MaxIterations: its time was used up.
ExitCode exit_code(core::Status status, bool page_failed, bool passes);

/// Something of the installation is missing or broken; not a mistake of the caller.
class InstallationFault : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// What a command does once the command line was read. @returns an exit code
using Run = std::function<int()>;

/// Each declares the options of one command and returns what to run.
Run declare_tasks(CLI::App& command);
Run declare_lint(CLI::App& command);
Run declare_plan(CLI::App& command);
Run declare_optimize(CLI::App& command);
Run declare_check(CLI::App& command);
Run declare_simulate(CLI::App& command);
Run declare_refine(CLI::App& command);
Run declare_solve(CLI::App& command);
Run declare_sense(CLI::App& command);
Run declare_view(CLI::App& command);
Run declare_studio(CLI::App& command);
Run declare_control(CLI::App& command);
Run declare_bench(CLI::App& command);
Run declare_reproduce(CLI::App& command);

/// Options that mean the same wherever they stand.
void add_task(CLI::App& command, std::string& task);
void add_plan(CLI::App& command, std::string& plan);
void add_seed(CLI::App& command, std::optional<std::uint64_t>& seed, const std::string& meaning);
void add_threads(CLI::App& command, std::optional<int>& threads);
void add_timeout(CLI::App& command, double& timeout_s, const std::string& meaning = "Wall-clock budget [s]");
void add_goal(CLI::App& command, std::string& goal);
void add_scheme(CLI::App& command, std::string& scheme);
void add_speed(CLI::App& command, double& speed);
void add_out(CLI::App& command, std::string& dir, const std::string& what);
void add_json(CLI::App& command, bool& json);

/// Folder of what a command makes of a task: ./TASK-seedN unless -o says otherwise.
std::filesystem::path task_dir(const std::string& out, const std::string& task, std::uint64_t seed);
/// Folder of what a command makes of a plan: that of the plan file unless -o says otherwise.
std::filesystem::path plan_dir(const std::string& out, const std::filesystem::path& plan);

/// Where the text for people goes: stdout, which belongs to the JSON object where there is one.
std::FILE* people(bool json);
/// One named row of a summary.
void print_row(std::FILE* to, std::string_view name, const std::string& value);

/// Folder of the program that runs; empty where the system does not tell.
std::filesystem::path program_dir();

/// Folders with built-in tasks: beside the program (of a build or of an installation), then the one compiled in.
std::vector<std::filesystem::path> data_dirs();

/// Folder of the Python packages, that of the built module `stiction`, that of the package `experiments`, each empty where there is none,
/// and the interpreter that has their dependencies.
std::filesystem::path python_dir();
std::filesystem::path module_dir();
std::filesystem::path experiments_dir();
std::string python_interpreter();

/// SIGINT, SIGTERM and SIGHUP end the program with the code kInterrupted: at once, until catch_signals() says that there is a result to keep.
/// A program that was started with nohup goes on at SIGHUP. @param json  whether stdout gets an object that says so
void begin_signals(bool json);
/// From now on the first of these signals only sets interrupted(); a second one ends the program.
void catch_signals();
const std::atomic<bool>& interrupted();
/// Stops at a signal, and after the budget where there is one [s].
core::RunControl make_run_control(std::optional<double> budget_s = std::nullopt);

/// What the task and its model took otherwise than their files say, a line each on stderr.
void print_notes(const tasks::Task& task);

/// One line on stderr that is rewritten at most ten times a second; nothing when stderr is not a terminal.
class ProgressLine {
 public:
  ProgressLine();
  ~ProgressLine();
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;
  void show(const core::Progress& progress);
  void show(std::string_view text);
  void clear();

 private:
  bool terminal_;
  bool shown_ = false;
  core::RunControl::Clock::time_point last_;
};

/// What lint found, a line each on stderr.
void print_warnings(const std::vector<tasks::Finding>& findings);

/// Times [s], commands and torques of the springs K_a(u − q) in the order of the joints, one knot per line.
void write_trajectory(const std::filesystem::path& file, const world::Model& model, const execution::Trajectory& trajectory);

/// Names of the experiments: the files figure_*, table_* and errata_* of the package, figure_2_13.py as "figure-2.13".
std::vector<std::string> list_experiments();

/// Runs a program with PYTHONPATH set and its stdout on our stderr; waits for it.
/// @returns its exit code, 128 + signal, or 127 when it could not be started
int run_program(const std::vector<std::string>& words, const std::string& python_path);

/// Runs the page maker on a plan file, and the file of its simulation if there is one; its output goes to stderr.
/// @returns its exit code  @throws InstallationFault: no page maker, no interpreter
int run_page_maker(const std::filesystem::path& plan, const std::filesystem::path& html, const std::filesystem::path& simulation = {});

/// The page of a plan file or its folder, and of its simulation if there is one, and a row of the summary that names it.
/// @param kept  what is in its file all the same
/// @returns whether it was written; if not, stderr says why  @throws InstallationFault as run_page_maker
bool make_page(const std::filesystem::path& plan, const std::filesystem::path& html, std::FILE* to, std::string_view kept,
               const std::filesystem::path& simulation = {});

/// Before the work, not after it: the page can be written, its folder is made. Empty: no page.
/// @throws core::InvalidInput: it cannot
void require_page(const std::filesystem::path& html);

/// Writes the page of a document that only the page maker reads, and a row of the summary that names it.
/// @returns whether it was written; if not, stderr says why  @throws InstallationFault as run_page_maker
bool write_page(const std::string& document, const std::filesystem::path& html, std::FILE* to);

}  // namespace stiction::app
