#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cerrno>
#include <cstdlib>

#include "app.hpp"
#include "stiction/core/invalid_input.hpp"
#include "stiction/tasks/plan_file.hpp"

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

int run_page_maker(const fs::path& plan, const fs::path& html, const fs::path& simulation) {
  const fs::path packages = python_dir();
  if (packages.empty()) throw InstallationFault("page: no package stiction_view beside the program");
  std::vector<std::string> words = {python_interpreter(), "-m", "stiction_view", plan.string()};
  if (!html.empty()) words.insert(words.end(), {"--html", html.string()});
  if (!simulation.empty()) words.insert(words.end(), {"--simulation", simulation.string()});
  const int code = run_program(words, packages.string());
  if (code == 127) throw InstallationFault(fmt::format("page: '{}' cannot be started; `make setup` makes a Python interpreter", words[0]));
  return code;
}

namespace {

struct ViewArguments {
  std::string plan;
  std::string html;
};

int run_view(const ViewArguments& arguments) {
  fs::path file = arguments.plan;
  if (fs::is_directory(file)) file /= "plan.json";
  (void)tasks::read_plan(file);  // one clear message before anything is started
  const int code = run_page_maker(file, arguments.html);
  if (code == 128 + 2 || code == 128 + 15) return kInterrupted;
  return code == 0 ? kDone : kInternalError;
}

}  // namespace

Run declare_view(CLI::App& command) {
  const auto arguments = std::make_shared<ViewArguments>();
  ViewArguments& a = *arguments;
  add_plan(command, a.plan);
  command.add_option("--html", a.html, "Write one self-contained page instead of starting a server");
  return [arguments] { return run_view(*arguments); };
}

}  // namespace stiction::app
