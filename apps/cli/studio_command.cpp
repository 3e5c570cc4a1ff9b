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
      "Task or scenario (name or file), a whole scene (MJCF, URDF or SDF), or a folder of tasks; left out: the built-in ones");
  command.add_option("--host", a.host, "Address that is listened on; 0.0.0.0: whoever has the token, from any machine")
      ->capture_default_str();
  add_integer(command, "--port", a.port, "Its port; 0 for any that is free", {0, 65535});
  return [arguments] { return run_studio(*arguments); };
}

}  // namespace stiction::app
