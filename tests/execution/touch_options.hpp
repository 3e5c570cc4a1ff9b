#pragma once

#include <cstdint>

#include "stiction/execution/touch/touch_run.hpp"

namespace stiction::execution::test {

inline TouchRunOptions with_seed(std::uint64_t seed) {
  TouchRunOptions out;
  out.seed = seed;
  return out;
}

}  // namespace stiction::execution::test
