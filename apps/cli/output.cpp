#include "output.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <iostream>
#include <system_error>

namespace stiction::app {
namespace {

int first_error = 0;  ///< of writing to stdout; 0: none

void note_error(int error) {
  if (first_error == 0) first_error = error != 0 ? error : EIO;
}

}  // namespace

void open_output() {
  std::signal(SIGPIPE, SIG_IGN);
  for (const int descriptor : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (::fcntl(descriptor, F_GETFD) != -1) continue;
    (void)!::open("/dev/null", descriptor == STDERR_FILENO ? O_WRONLY : O_RDONLY);  // the lowest that is free; writing to stdout fails then
  }
}

void say_text(std::FILE* to, std::string_view text) {
  errno = 0;
  if (std::fwrite(text.data(), 1, text.size(), to) != text.size() && to == stdout) note_error(errno);
}

void flush_text(std::FILE* to) {
  errno = 0;
  if (std::fflush(to) != 0 && to == stdout) note_error(errno);
}

bool close_output() {
  errno = 0;
  std::cout.flush();
  if (!std::cout) note_error(errno);
  flush_text(stdout);
  if (first_error == 0) return true;
  say(stderr, "stiction: stdout: cannot be written ({}); files of the command are whole\n", std::generic_category().message(first_error));
  return false;
}

}  // namespace stiction::app
