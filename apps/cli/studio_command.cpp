#include <CLI/CLI.hpp>

#include "python_start.hpp"

namespace stiction::app {
namespace {

struct StudioArguments {
  std::string shown;
  std::string host = "127.0.0.1";
  int port = 8080;
};

int run_studio(const StudioArguments& arguments) {
  std::vector<std::string> words = {"stiction_view.studio", "--host", arguments.host, "--port", std::to_string(arguments.port)};
  if (!arguments.shown.empty()) words.insert(words.end(), {"--", arguments.shown});
  become_python("studio", Packages::ViewerAndModule, words);
}

}  // namespace

Run declare_studio(CLI::App& command) {
  const auto arguments = std::make_shared<StudioArguments>();
  StudioArguments& a = *arguments;
  command.add_option(
      "shown", a.shown,
      "Name or file of a task or scenario, file of a scene (MJCF, URDF or SDF), or folder of tasks (default: the built-in tasks)");
  command.add_option("--host", a.host, "Address of the server; with 0.0.0.0, everyone who has the token can connect from any machine")
      ->capture_default_str();
  add_integer(command, "--port", a.port, "Port of the server; 0 selects a free port", {0, 65535});
  return [arguments] { return run_studio(*arguments); };
}

}  // namespace stiction::app
