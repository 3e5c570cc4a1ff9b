#pragma once

#include <filesystem>
#include <string_view>

namespace stiction::world {

/// Checks the bytes of a mesh file before Assimp reads them: for contents that are no mesh, which its messages do not tell, and for contents that
/// it never finishes.
/// @throws core::InvalidInput "FILE: mesh: got …, expected …". Tests: tests/world/mesh_test.cpp
void require_mesh_contents(const std::filesystem::path& file, std::string_view bytes);

}  // namespace stiction::world
