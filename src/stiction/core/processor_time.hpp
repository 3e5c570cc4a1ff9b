#pragma once

#include <ctime>

namespace stiction::core {

/// Of all threads of this process [s]: what other work on the machine does not lengthen.
inline double processor_time() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

}  // namespace stiction::core
