#pragma once

#include <ctime>

namespace stiction::core {

/// Processor time of all threads of this process, or of this thread with CLOCK_THREAD_CPUTIME_ID [s]. Other work on the machine does not
/// lengthen it.
inline double processor_time(clockid_t clock = CLOCK_PROCESS_CPUTIME_ID) {
  timespec now{};
  clock_gettime(clock, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

}  // namespace stiction::core
