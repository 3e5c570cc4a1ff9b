#include "python_start.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>

namespace stiction::app {
namespace {

namespace fs = std::filesystem;

fs::path viewer_of(const std::string& command) {
  const fs::path found = python_dir();
  if (found.empty()) throw InstallationFault(command + ": no package stiction_view beside the program");
  return found;
}

fs::path module_of(const std::string& command) {
  const fs::path found = module_dir();
  if (found.empty()) throw InstallationFault(command + ": no Python module 'stiction' beside the program; `make build` makes it");
  return found;
}

/// PYTHONPATH.
std::string path_of(const std::string& command, Packages packages) {
  switch (packages) {
    case Packages::Viewer:
      return viewer_of(command).string();
    case Packages::Module:
      return module_of(command).string();
    case Packages::ViewerAndModule:
      return viewer_of(command).string() + ":" + module_of(command).string();
    case Packages::Experiments:
      return experiments_dir().string() + ":" + module_of(command).string();
  }
  return {};
}

/// As `python -m`, without the working folder among the places of modules. A package that is missing, or too new for the interpreter, is a
/// message, also where it is the first to be loaded. A signal ends the program at once while packages are loaded: modules in C++ cannot be
/// interrupted in the middle of their start.
constexpr const char* kStart = R"(import sys  # is built in: a file of the user's cannot take its place
if sys.path and sys.path[0] == "":
    del sys.path[0]
import json, os, signal
command, sys.argv[:] = sys.argv[1], sys.argv[2:]
def end(code, status, message):
    try:
        os.write(2, ("stiction: %s\n" % message).encode("utf-8", "backslashreplace"))
        if "--json" in sys.argv:
            os.write(1, (json.dumps({"status": status, "message": message}) + "\n").encode())
    except OSError:
        pass
    os._exit(code)
signals = [signal.SIGINT, signal.SIGTERM, signal.SIGHUP]
for number in signals:
    if number != signal.SIGHUP or signal.getsignal(number) != signal.SIG_IGN:
        signal.signal(number, lambda *_: end(130, "Cancelled", "interrupted"))
signal.pthread_sigmask(signal.SIG_UNBLOCK, signals)
try:
    import runpy
    runpy.run_module(sys.argv[0], run_name="__main__", alter_sys=True)
except (ImportError, SyntaxError) as error:
    end(70, "Error", "%s: the Python of %s cannot run it: %s; STICTION_PYTHON names another interpreter" % (command, sys.executable, error))
)";

/// From here until kStart takes them, SIGINT, SIGTERM and SIGHUP wait.
void hold_signals() {
  sigset_t held;
  sigemptyset(&held);
  for (const int number : {SIGINT, SIGTERM, SIGHUP}) sigaddset(&held, number);
  sigprocmask(SIG_BLOCK, &held, nullptr);
}

std::vector<std::string> with_interpreter(const std::string& command, const std::vector<std::string>& words) {
  std::vector<std::string> out = {python_interpreter(), "-c", kStart, command};
  out.insert(out.end(), words.begin(), words.end());
  return out;
}

[[noreturn]] void cannot_start(const std::string& command, const std::string& interpreter) {
  throw InstallationFault(fmt::format("{}: '{}' cannot be started; `make setup` makes a Python interpreter", command, interpreter));
}

}  // namespace

int run_python(const std::string& command, Packages packages, const std::vector<std::string>& words) {
  const auto all = with_interpreter(command, words);
  const int code = run_program(all, path_of(command, packages));
  if (code == 127) cannot_start(command, all[0]);
  return code;
}

void become_python(const std::string& command, Packages packages, const std::vector<std::string>& words) {
  auto all = with_interpreter(command, words);
  const std::string path = path_of(command, packages);
  std::vector<char*> argv;
  for (auto& word : all) argv.push_back(word.data());
  argv.push_back(nullptr);
  ::setenv("PYTHONPATH", path.c_str(), 1);
  ::setenv("PYTHONSAFEPATH", "1", 1);  // no module of the working folder, nor in processes that it starts
  std::signal(SIGINT, SIG_DFL);  // a script starts programs in the background with SIGINT ignored, and the interpreter would leave it so
  std::fflush(nullptr);
  hold_signals();
  ::execvp(argv[0], argv.data());
  cannot_start(command, all[0]);
}

}  // namespace stiction::app
