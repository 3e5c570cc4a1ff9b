#include "app.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <system_error>

#include "stiction/tasks/task.hpp"

namespace stiction::app {
namespace {

namespace fs = std::filesystem;

std::atomic<bool> interrupted_flag{false};
static_assert(std::atomic<bool>::is_always_lock_free);  // so that a signal handler may set it
bool tells_json = false;                                ///< set before the handlers are

void on_signal(int) { interrupted_flag.store(true, std::memory_order_relaxed); }

/// A handler may not use the buffers of stdout and stderr.
void write_now(int descriptor, std::string_view text) { (void)!::write(descriptor, text.data(), text.size()); }

/// While there is no result to keep.
void end_at_signal(int) {
  write_now(STDERR_FILENO, "stiction: interrupted\n");
  if (tells_json) write_now(STDOUT_FILENO, "{\"status\":\"Cancelled\",\"message\":\"interrupted\"}\n");
  ::_exit(kInterrupted);
}

void handle_signals(void (*handler)(int)) {
  struct sigaction action {};
  action.sa_handler = handler;
  sigemptyset(&action.sa_mask);
  action.sa_flags = static_cast<int>(SA_RESETHAND);  // a second Ctrl-C ends the program at once
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  struct sigaction before {};
  sigaction(SIGHUP, nullptr, &before);
  if (before.sa_handler != SIG_IGN) sigaction(SIGHUP, &action, nullptr);  // else of a program started with nohup
}

/// The first of the folders that holds the package; empty where none does.
fs::path first_with(const fs::path& package, std::initializer_list<fs::path> folders) {
  for (const fs::path& folder : folders) {
    if (!folder.is_absolute()) continue;  // of nothing that is known
    std::error_code error;
    if (fs::is_regular_file(folder / package / "__init__.py", error)) return fs::canonical(folder);
  }
  return {};
}

}  // namespace

ExitCode exit_code(core::Status status, bool page_failed, bool passes) {
  if (status == core::Status::Cancelled) return kInterrupted;
  if (status == core::Status::MaxIterations) return kNotSolved;
  if (page_failed) return kInternalError;
  return passes ? kDone : kCheckFailed;
}

fs::path program_dir() {
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  return error ? fs::path() : program.parent_path();
}

std::vector<fs::path> data_dirs() {
  std::vector<fs::path> out;
  const auto add = [&out](const fs::path& dir) {
    std::error_code error;
    const fs::path canonical = fs::canonical(dir, error);
    if (!error && fs::is_directory(canonical) && std::find(out.begin(), out.end(), canonical) == out.end()) out.push_back(canonical);
  };
  if (const fs::path here = program_dir(); !here.empty()) {
    add(here / "../../tasks");
    add(here / "../share/stiction/tasks");
  }
  for (const auto& dir : tasks::default_data_dirs()) add(dir);
  return out;
}

// Each of a build in <clone>/build/<preset>, of an installation, of a wheel (whose program is in site-packages/stiction/bin), of the sources.
fs::path python_dir() {
  const fs::path here = program_dir();
  return first_with("stiction_view", {here / "../../python", here / "../share/stiction/python", fs::path(STICTION_SOURCE_DIR) / "python"});
}

fs::path module_dir() {
  const fs::path here = program_dir();
  return first_with("stiction", {here / "python", here / "../share/stiction/python", here / "../.."});
}

fs::path experiments_dir() {
  const fs::path here = program_dir();
  return first_with("experiments", {here / "../..", here / "../share/stiction", STICTION_SOURCE_DIR});
}

std::string python_interpreter() {
  if (const char* given = std::getenv("STICTION_PYTHON"); given != nullptr && *given != '\0') return given;
  for (const fs::path& python : {program_dir() / "../../.venv/bin/python", fs::path(STICTION_BUILT_WITH_PYTHON)}) {
    std::error_code error;
    if (!python.empty() && fs::exists(python, error)) return python.lexically_normal().string();
  }
  return "python3";
}

const std::atomic<bool>& interrupted() { return interrupted_flag; }

void begin_signals(bool json) {
  tells_json = json;
  handle_signals(end_at_signal);
}

void catch_signals() { handle_signals(on_signal); }

core::RunControl make_run_control(std::optional<double> budget_s) {
  core::RunControl control;
  control.cancel = &interrupted();
  if (budget_s) {
    control.deadline = core::RunControl::Clock::now() + std::chrono::duration_cast<core::RunControl::Clock::duration>(
                                                            std::chrono::duration<double>(std::min(*budget_s, 1e8)));
  }
  return control;
}

void print_notes(const tasks::Task& task) {
  for (const std::string& note : task.model->notes()) say(stderr, "note: {}\n", note);
  for (const std::string& note : task.notes) say(stderr, "note: {}\n", note);
}

ProgressLine::ProgressLine() : terminal_(::isatty(STDERR_FILENO) == 1) {}
ProgressLine::~ProgressLine() { clear(); }

void ProgressLine::show(std::string_view text) {
  if (!terminal_) return;
  const auto now = core::RunControl::Clock::now();
  if (shown_ && now - last_ < std::chrono::milliseconds(100)) return;
  last_ = now;
  shown_ = true;
  say(stderr, "\r\x1b[K{}", text);
  std::fflush(stderr);
}

void ProgressLine::show(const core::Progress& p) {
  if (!terminal_) return;
  const double left_s = p.fraction > 0 ? p.elapsed_s * std::max(0.0, 1 / p.fraction - 1) : 0;
  const double rate = p.elapsed_s > 0 ? static_cast<double>(p.iteration) / p.elapsed_s : 0;
  show(fmt::format("{:5.1f} s, {:.0f} s left   {} extensions, {:.0f} per second   {} nodes   {:.3g} tolerances from the goal{}",
                   p.elapsed_s, std::ceil(left_s), p.iteration, rate, p.size, p.best,
                   p.cost ? fmt::format("   best plan {:.1f} s", *p.cost) : ""));
}

void ProgressLine::clear() {
  if (!shown_) return;
  say(stderr, "\r\x1b[K");
  std::fflush(stderr);
  shown_ = false;
}

}  // namespace stiction::app
