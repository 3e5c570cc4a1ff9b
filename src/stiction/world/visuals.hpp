#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "stiction/world/model.hpp"

namespace stiction::world {

/// Triangle mesh for display. It need be neither closed nor convex, and may repeat a point for every triangle.
struct VisualMesh {
  Eigen::Matrix3Xf vertices;   ///< [m]
  Eigen::Matrix3Xi triangles;  ///< visible from the side from which their corners run counterclockwise
};

/// A coloured shape or mesh that shows a body.
struct Visual {
  int body = -1;
  Pose X_BV;
  std::variant<Shape, int> form;                              ///< a shape, or an index into Visuals::meshes
  Eigen::Vector4d color = Eigen::Vector4d(0.7, 0.7, 0.7, 1);  ///< red, green, blue, opacity in [0, 1]
};

struct Visuals {
  std::vector<std::shared_ptr<const VisualMesh>> meshes;  ///< each mesh once, even if several visuals use it
  std::vector<Visual> visuals;
  std::vector<std::string> notes;  ///< visuals that are left out, one sentence each, starting with the name of the robot
};

/// Reads the visuals of links and objects from the files of their robots: <visual> elements of a URDF, visible geoms of an MJCF (groups 0 to 2).
/// Their colours are those of their materials, and the mean colour of a texture. A body without visuals in a file has none; its geometries
/// can be shown instead. The call reads mesh files, and compiles an MJCF with meshes again. A file that cannot be read, or that has changed
/// since the model was made, is left out with a note.
/// Tests: tests/world/visuals_test.cpp
Visuals read_visuals(const Model& model);

}  // namespace stiction::world
