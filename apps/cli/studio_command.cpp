#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdlib>
#include <filesystem>

#include "app.hpp"

namespace stiction::app {
namespace {

namespace fs = std::filesystem;

struct StudioArguments {
  std::string shown;
  std::string host = "127.0.0.1";
  int port = 8080;
};

/// The page is Python's; this starts it with the packages and the module that belong to this program.
int run_studio(const StudioArguments& arguments) {
  const fs::path packages = python_dir(), module = module_dir();
  if (packages.empty()) throw InstallationFault("studio: no package stiction_view beside the program");
  if (module.empty()) throw InstallationFault("studio: no Python module 'stiction' beside the program; `make build` makes it");
  std::vector<std::string> words = {python_interpreter(), "-m",     "stiction_view.studio",        "--host",
                                    arguments.host,       "--port", std::to_string(arguments.port)};
  if (!arguments.shown.empty()) words.insert(words.end(), {"--", arguments.shown});
  std::vector<char*> argv;
  for (auto& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  ::setenv("PYTHONPATH", (packages.string() + ":" + module.string()).c_str(), 1);
  ::execvp(argv[0], argv.data());  // signals and exit codes are then those of the page
  throw InstallationFault(fmt::format("studio: '{}' cannot be started; `make setup` makes a Python interpreter", words[0]));
}

}  // namespace

Run declare_studio(CLI::App& command) {
  const auto arguments = std::make_shared<StudioArguments>();
  StudioArguments& a = *arguments;
  command.add_option("shown", a.shown, "Task or scenario (name or file), or a folder of them; left out: the built-in ones");
  command.add_option("--host", a.host, "Address that is listened on; 0.0.0.0 lets every machine of the network in")->capture_default_str();
  command.add_option("--port", a.port, "Its port; 0 for any that is free")->capture_default_str()->check(CLI::Range(0, 65535));
  return [arguments] { return run_studio(*arguments); };
}

}  // namespace stiction::app
