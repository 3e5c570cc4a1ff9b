#pragma once

#include <mujoco/mujoco.h>

#include <filesystem>

namespace stiction::world {

/// Checks the numbers of a compiled MJCF that a scene uses. MuJoCo reads "nan" and "inf", and negative friction and damping, without a word.
/// Ranges may be infinite.
/// @param file  name of the file in the message
/// @throws core::InvalidInput that names all of them. Tests: tests/world/mjcf_numbers_test.cpp
void require_numbers(const mjModel& model, const std::filesystem::path& file);

}  // namespace stiction::world
