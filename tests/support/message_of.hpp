#pragma once

#include <string>

#include "stiction/core/invalid_input.hpp"

namespace stiction::test {

/// What the call complains about, or "no exception".
template <class F>
std::string message_of(F&& call) {
  try {
    call();
  } catch (const core::InvalidInput& e) {
    return e.what();
  }
  return "no exception";
}

}  // namespace stiction::test
