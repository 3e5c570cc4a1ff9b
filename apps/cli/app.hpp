#pragma once

#include <atomic>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "stiction/core/run_control.hpp"
#include "stiction/planning/speed_limits.hpp"

namespace stiction::planning {
struct Trajectory;
}

namespace stiction::app {

/// Exit codes of the program.
enum ExitCode : int {
  kDone = 0,
  kCheckFailed = 1,
  kBadInput = 2,
  kNotSolved = 3,
  kInterrupted = 130
};

/// Folders with built-in tasks: beside the program (of a build or of an installation), then the one compiled in.
std::vector<std::filesystem::path> data_dirs();

/// Folder of the Python packages, that of the built module `stiction`, that of the package `experiments`, each empty where there is none,
/// and the interpreter that has their dependencies.
std::filesystem::path python_dir();
std::filesystem::path module_dir();
std::filesystem::path experiments_dir();
std::string python_interpreter();

/// Set by SIGINT and SIGTERM once catch_signals() was called.
const std::atomic<bool>& interrupted();
void catch_signals();
/// Stops at a signal, and after the budget where there is one [s].
core::RunControl make_run_control(std::optional<double> budget_s = std::nullopt);

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

/// Options of each command, filled by the command line.
struct PlanArguments {
  std::string task;
  std::uint64_t seed = 0;
  bool seed_given = false;
  std::string goal;
  double timeout_s = 20;
  int threads = 0;
  bool threads_given = false;
  std::string out_dir;
  std::string scheme;  ///< empty: that of the task
  bool anytime = false;
  bool html = false;
  bool json = false;
};
struct OptimizeArguments {
  std::string task;
  std::string scheme;  ///< empty: that of the task
  std::string solver;  ///< the same
  bool forces = false;
  std::uint64_t seed = 0;
  bool seed_given = false;
  int iterations = 0;  ///< 0: those of the task
  double timeout_s = 60;
  int threads = 0;
  bool threads_given = false;
  std::string out_dir;
  bool json = false;
};
struct CheckArguments {
  std::string plan;
  bool json = false;
};
struct SimulateArguments {
  std::string plan;
  std::string out_dir;
  double speed = 1;                                        ///< times the default speeds
  double pause_s = 4;                                      ///< between pieces
  double load_time_s = planning::SpeedLimits{}.load_time;  ///< of joint springs
  int substeps = 0;                                        ///< predict each edge in this many steps; 0: as the plan does
  double rest_time_s = planning::kRestTime;
  double friction_scale = 1;
  bool velocity_reference = true;  ///< of the commands, for the damping of the joint springs
  bool whole_only = false;         ///< pushes are not run by themselves as well
  int threads = 0;
  bool html = false;
  bool json = false;
};
struct RefineArguments {
  std::string plan;
  std::string out_dir;
  double timeout_s = 20;
  double speed = 1;  ///< times the default speeds, for trajectory.csv
  bool html = false;
  bool json = false;
};
struct SolveArguments {
  std::string task;
  std::uint64_t seed = 0;  ///< of the first try; the next ones count up
  bool seed_given = false;
  std::string goal;
  int tries = 20;
  double timeout_s = 120;                ///< of all tries
  std::vector<double> friction = {1.0};  ///< the goal has to be reached with every μ times each of these
  double speed = 1;                      ///< times the default speeds
  int threads = 0;
  bool threads_given = false;
  std::string out_dir;
  bool json = false;
};
struct ViewArguments {
  std::string plan;
  std::string html;
};
struct ReproduceArguments {
  std::string name;
  std::string out_dir = "reproduction";
  std::string docs;
  bool quick = false;
  bool json = false;
};
struct BenchArguments {
  std::string filter;
  int repeat = 5;
  bool json = false;
};

int run_tasks(bool json);
int run_plan(const PlanArguments& arguments);
int run_optimize(const OptimizeArguments& arguments);
int run_check(const CheckArguments& arguments);
int run_simulate(const SimulateArguments& arguments);
int run_refine(const RefineArguments& arguments);
int run_solve(const SolveArguments& arguments);
int run_view(const ViewArguments& arguments);
int run_bench(const BenchArguments& arguments);
int run_reproduce(const ReproduceArguments& arguments);

/// Numbers of a command line, nothing for ~. @throws core::InvalidInput naming the option
std::vector<std::optional<double>> parse_numbers(std::string_view option, const std::string& text);

/// The default speeds times a factor.
planning::SpeedLimits speed_limits(double factor);

/// Times [s] and commands in the order of the joints, one knot per line.
void write_trajectory(const std::filesystem::path& file, const std::vector<std::string>& joints, const planning::Trajectory& trajectory);

/// Names of the experiments: the files figure_*, table_* and errata_* of the package, figure_2_13.py as "figure-2.13".
std::vector<std::string> list_experiments();

/// Runs a program with PYTHONPATH set and its stdout on our stderr; waits for it.
/// @returns its exit code, 128 + signal, or 127 when it could not be started
int run_program(const std::vector<std::string>& words, const std::string& python_path);

/// Runs the page maker on a plan file, and the file of its simulation if there is one; its output goes to stderr.
/// @returns its exit code, 127 when it could not be started
int run_page_maker(const std::filesystem::path& plan, const std::filesystem::path& html, const std::filesystem::path& simulation = {});

}  // namespace stiction::app
