#pragma once

#include <string>
#include <type_traits>
#include <vector>

namespace stiction::world {

/// What MuJoCo said during a call.
struct MujocoReport {
  bool failed = false;  ///< it gave up: what the call worked on must not be used any more, only deleted
  std::string error;
  std::vector<std::string> warnings;
};

/// Calls `function(argument)`, which calls MuJoCo. MuJoCo's own handler ends the process on errors and prints warnings; here both come
/// back as text, per thread. Other users of MuJoCo in the same process keep their handler for calls outside this function.
///
/// An error leaves the call by longjmp: `function` must own nothing with a destructor while it is inside MuJoCo.
MujocoReport call_mujoco(void (*function)(void*), void* argument);

template <class F>
MujocoReport call_mujoco(F&& function) {
  using Function = std::remove_reference_t<F>;
  return call_mujoco([](void* f) { (*static_cast<Function*>(f))(); }, static_cast<void*>(&function));
}

}  // namespace stiction::world
