#pragma once

#include <string>
#include <type_traits>
#include <vector>

namespace stiction::world {

/// Errors and warnings of MuJoCo during a call.
struct MujocoReport {
  bool failed = false;  ///< MuJoCo raised an error: the data of the call must only be deleted, not used
  std::string error;
  std::vector<std::string> warnings;
};

/// Calls `function(argument)`, which calls MuJoCo, and returns errors and warnings as text, per thread. (MuJoCo's own handler ends the
/// process on errors and prints warnings.) Other users of MuJoCo in the same process keep their handler for calls outside this function.
///
/// An error leaves the call by longjmp: `function` must own nothing with a destructor while it is inside MuJoCo.
MujocoReport call_mujoco(void (*function)(void*), void* argument);

template <class F>
MujocoReport call_mujoco(F&& function) {
  using Function = std::remove_reference_t<F>;
  return call_mujoco([](void* f) { (*static_cast<Function*>(f))(); }, static_cast<void*>(&function));
}

}  // namespace stiction::world
