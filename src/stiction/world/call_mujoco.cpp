#include "stiction/world/call_mujoco.hpp"

#include <mujoco/mujoco.h>

#include <csetjmp>
#include <mutex>

namespace stiction::world {

namespace {

/// One call_mujoco in progress.
struct Call {
  std::jmp_buf back;
  MujocoReport* report = nullptr;
};

thread_local Call* current = nullptr;
mjfLogHandler previous_handler = nullptr;

void handle(const mjLogMessage* message) {
  if (current == nullptr) {
    if (previous_handler != nullptr) previous_handler(message);
    return;
  }
  if (message->level == mjLOG_WARNING) current->report->warnings.emplace_back(message->subject);
  if (message->level != mjLOG_ERROR) return;
  current->report->failed = true;
  current->report->error = message->subject;
  std::longjmp(current->back, 1);
}

}  // namespace

MujocoReport call_mujoco(void (*function)(void*), void* argument) {
  static std::once_flag installed;
  std::call_once(installed, [] { previous_handler = mju_setLogHandler(handle); });
  MujocoReport report;
  Call call;
  call.report = &report;
  Call* const outer = current;
  current = &call;
  try {
    if (setjmp(call.back) == 0) function(argument);
  } catch (...) {
    current = outer;
    throw;
  }
  current = outer;
  return report;
}

}  // namespace stiction::world
