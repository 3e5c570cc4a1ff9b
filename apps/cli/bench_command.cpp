#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cerrno>
#include <cstdio>
#include <cstring>

#include "app.hpp"

namespace stiction::app {
namespace {

namespace fs = std::filesystem;

/// Goes on as `stiction-bench`: signals, output and exit code are those of that program.
[[noreturn]] void become_bench(std::vector<std::string> words) {
  const fs::path program = program_dir() / "stiction-bench";
  std::error_code error;
  if (!fs::is_regular_file(program, error))
    throw InstallationFault(
        fmt::format("bench: cannot find the program {}, which is missing in a wheel; `make bench` in a clone of the repository "
                    "builds and starts it",
                    program.string()));
  words.insert(words.begin(), program.string());
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  std::fflush(nullptr);
  ::execv(argv[0], argv.data());
  throw InstallationFault(fmt::format("bench: {} cannot be started: {}", program.string(), std::strerror(errno)));
}

}  // namespace

Run declare_bench(CLI::App& command) {
  command.set_help_flag();
  command.prefix_command();  // every word is for stiction-bench
  return [&command]() -> int { become_bench(command.remaining()); };
}

}  // namespace stiction::app
