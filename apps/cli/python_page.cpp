#include "python_page.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdlib>

#include "app.hpp"

namespace stiction::app {

void become_page(const std::string& command, const std::string& module, const std::vector<std::string>& arguments) {
  const std::filesystem::path packages = python_dir(), extension = module_dir();
  if (packages.empty()) throw InstallationFault(command + ": no package stiction_view beside the program");
  if (extension.empty()) throw InstallationFault(command + ": no Python module 'stiction' beside the program; `make build` makes it");
  std::vector<std::string> words = {python_interpreter(), "-m", module};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  for (auto& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  ::setenv("PYTHONPATH", (packages.string() + ":" + extension.string()).c_str(), 1);
  ::execvp(argv[0], argv.data());
  throw InstallationFault(fmt::format("{}: '{}' cannot be started; `make setup` makes a Python interpreter", command, words[0]));
}

}  // namespace stiction::app
