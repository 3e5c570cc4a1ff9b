#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "stiction/world/visuals.hpp"

namespace stiction::world {

struct ColoredMesh {
  std::shared_ptr<const VisualMesh> mesh;
  std::optional<Eigen::Vector4d> color{};  ///< colour of its material in the file
};

/// Loads the triangles of a mesh file for display, one part per material. Formats: STL, OBJ with the MTL file beside it, DAE, and all others that
/// Assimp reads.
/// @throws core::InvalidInput with the file name
std::vector<ColoredMesh> load_visual_mesh(const std::filesystem::path& file, const Eigen::Vector3d& scale);

}  // namespace stiction::world
