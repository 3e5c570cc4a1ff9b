#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdlib>

#include "app.hpp"
#include "python_start.hpp"
#include "stiction/core/invalid_input.hpp"
#include "stiction/tasks/lint.hpp"
#include "stiction/tasks/plan_file.hpp"
#include "stiction/tasks/task.hpp"
#include "stiction/tasks/unplanned.hpp"

namespace stiction::app {

namespace fs = std::filesystem;

int run_program(const std::vector<std::string>& words, const std::string& python_path) {
  std::vector<char*> argv;
  for (const auto& word : words) argv.push_back(const_cast<char*>(word.c_str()));
  argv.push_back(nullptr);

  std::vector<std::string> variables;
  for (char** entry = environ; *entry != nullptr; ++entry) {
    if (!std::string_view(*entry).starts_with("PYTHONPATH=")) variables.emplace_back(*entry);
  }
  variables.push_back("PYTHONPATH=" + python_path);
  variables.emplace_back("PYTHONSAFEPATH=1");  // no module of the working folder, nor in processes that it starts
  std::vector<char*> envp;
  for (auto& variable : variables) envp.push_back(variable.data());
  envp.push_back(nullptr);

  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, STDERR_FILENO, STDOUT_FILENO);
  pid_t child = 0;
  const int error = posix_spawnp(&child, argv[0], &actions, nullptr, argv.data(), envp.data());
  posix_spawn_file_actions_destroy(&actions);
  if (error != 0) return 127;
  int status = 0;
  while (waitpid(child, &status, 0) < 0) {
    if (errno != EINTR) return 127;
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

/// The module reads how bodies look; without it pages show what touches.
static Packages viewer_packages() { return module_dir().empty() ? Packages::Viewer : Packages::ViewerAndModule; }

int run_page_maker(const fs::path& plan, const fs::path& html, const fs::path& simulation) {
  std::vector<std::string> words = {"stiction_view", plan.string()};
  if (!html.empty()) words.insert(words.end(), {"--html", html.string()});
  if (!simulation.empty()) words.insert(words.end(), {"--simulation", simulation.string()});
  return run_python("page", viewer_packages(), words);
}

namespace {

/// A folder for a file that only the page maker reads.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::error_code error;
    const fs::path place = fs::temp_directory_path(error);
    std::string name = (place / "stiction-view-XXXXXX").string();
    if (error || mkdtemp(name.data()) == nullptr)
      throw InstallationFault(fmt::format("page: cannot make a folder in {}, which TMPDIR can name", error ? "TMPDIR" : place.string()));
    path_ = name;
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

}  // namespace

bool make_page(const fs::path& plan, const fs::path& html, std::FILE* to, std::string_view kept, const fs::path& simulation) {
  const bool made = run_page_maker(fs::is_directory(plan) ? plan / "plan.json" : plan, html, simulation) == 0;
  if (made) {
    print_row(to, "page", html.string());
  } else {
    say(stderr, "stiction: page: the page maker failed{}{}\n", kept.empty() ? "" : "; ", kept);
  }
  return made;
}

void require_page(const fs::path& html) {
  if (html.empty()) return;
  if (fs::is_directory(html)) core::throw_invalid("--html", "the folder '" + html.string() + "'", "a file to write");
  if (fs::exists(html) && !fs::is_regular_file(html))
    core::throw_invalid("--html", "the device or pipe '" + html.string() + "'", "a file to write");
  tasks::require_writable(html.has_parent_path() ? html.parent_path() : fs::path("."));
}

bool write_page(const std::string& document, const fs::path& html, std::FILE* to) {
  const TemporaryFolder folder;
  const fs::path file = folder.path() / "page.json";
  tasks::write_text(document + "\n", file);
  return make_page(file, html, to, {});
}

namespace {

struct ViewArguments {
  std::string shown;  ///< plan or task
  std::string html;
};

bool is_task(const std::string& name) {
  const auto names = tasks::list_tasks(data_dirs());
  return name.ends_with(".yaml") || name.ends_with(".yml") ||
         (!fs::exists(name) && std::find(names.begin(), names.end(), name) != names.end());
}

/// The page, or the server in the place of this program: whoever ends it ends the server. A temporary plan is removed by the server once it has read it.
int show(const fs::path& plan, const std::string& html, bool temporary) {
  if (html.empty()) {
    std::vector<std::string> words = {"stiction_view", plan.string()};
    if (temporary) words.push_back("--temporary");
    become_python("view", viewer_packages(), words);
  }
  const int code = run_page_maker(plan, html);
  if (code == 128 + SIGHUP || code == 128 + SIGINT || code == 128 + SIGTERM) return kInterrupted;
  if (code == kBadInput) return kBadInput;  // the message is there
  return code == 0 ? kDone : kInternalError;
}

int run_view(const ViewArguments& arguments) {
  require_page(arguments.html);
  if (is_task(arguments.shown)) {
    const tasks::Task task = tasks::load_task(arguments.shown, data_dirs());
    print_warnings(tasks::lint(task));
    catch_signals();  // the folder goes also when the program is ended now
    const TemporaryFolder folder;
    const fs::path file = folder.path() / "plan.json";
    tasks::write_plan(tasks::make_plan_file(task, task.options, tasks::make_unplanned(task), file), file);
    if (interrupted()) return kInterrupted;
    return show(file, arguments.html, /*temporary=*/true);
  }
  fs::path file = arguments.shown;
  if (fs::is_directory(file)) file /= "plan.json";
  (void)tasks::read_plan(file);  // one clear message before anything is started
  return show(file, arguments.html, /*temporary=*/false);
}

}  // namespace

Run declare_view(CLI::App& command) {
  const auto arguments = std::make_shared<ViewArguments>();
  ViewArguments& a = *arguments;
  command.add_option("shown", a.shown, "Plan file or its folder, or name or file of a task, which is shown before it is planned")
      ->required();
  command.add_option("--html", a.html, "HTML page to write, self-contained, instead of starting a server");
  return [arguments] { return run_view(*arguments); };
}

}  // namespace stiction::app
