#include "python_command.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdlib>

namespace stiction::app {
namespace {

/// The interpreter takes the place of this program: signals, output and exit code are its own.
int become_python(const std::string& command, const std::vector<std::string>& rest) {
  const std::filesystem::path module = module_dir();
  if (module.empty()) throw InstallationFault(command + ": no Python module 'stiction' beside the program; `make build` makes it");
  std::vector<std::string> words = {python_interpreter(), "-m", "stiction", command};
  words.insert(words.end(), rest.begin(), rest.end());
  std::vector<char*> argv;
  for (auto& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  ::setenv("PYTHONPATH", module.c_str(), 1);
  std::fflush(nullptr);
  ::execvp(argv[0], argv.data());
  throw InstallationFault(fmt::format("{}: '{}' cannot be started; `make setup` makes a Python interpreter", command, words[0]));
}

}  // namespace

Run declare_python(CLI::App& command) {
  command.set_help_flag();
  command.prefix_command();  // every word is for the package
  return [&command] { return become_python(command.get_name(), command.remaining()); };
}

}  // namespace stiction::app
