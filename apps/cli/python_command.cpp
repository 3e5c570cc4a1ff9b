#include "python_command.hpp"

#include <CLI/CLI.hpp>

#include "python_start.hpp"

namespace stiction::app {

Run declare_python(CLI::App& command) {
  command.set_help_flag();
  command.prefix_command();  // every word is for the package
  return [&command]() -> int {
    std::vector<std::string> words = {"stiction", command.get_name()};
    for (const auto& word : command.remaining()) words.push_back(word);
    become_python(command.get_name(), Packages::Module, words);
  };
}

}  // namespace stiction::app
