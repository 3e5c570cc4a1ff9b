#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "stiction/world/model.hpp"

namespace stiction::world {

/// Triangles that are looked at. They need be neither closed nor convex, and may repeat a point for every triangle.
struct VisualMesh {
  Eigen::Matrix3Xf vertices;   ///< [m]
  Eigen::Matrix3Xi triangles;  ///< seen from where their corners run counterclockwise
};

/// What is seen of a body.
struct Visual {
  int body = -1;
  Pose X_BV;
  std::variant<Shape, int> form;                              ///< a shape, or an index into Visuals::meshes
  Eigen::Vector4d color = Eigen::Vector4d(0.7, 0.7, 0.7, 1);  ///< red, green, blue, opacity in [0, 1]
};

struct Visuals {
  std::vector<std::shared_ptr<const VisualMesh>> meshes;  ///< each once, however many visuals have it
  std::vector<Visual> visuals;
  std::vector<std::string> notes;  ///< what is left out, one sentence each, with the name of the robot in front
};

/// Pictures of links and objects as the files of their robots show them: <visual> elements of a URDF, visible geoms of an MJCF (groups 0 to 2)
/// with the colours of their materials, of textures the mean. Bodies of whom no file shows anything have none; their geometries stand for them.
/// Mesh files are read now, and an MJCF with meshes is compiled again. A file that cannot be read, or has changed since the model was made, is
/// left out with a note.
/// Tests: tests/world/visuals_test.cpp
Visuals read_visuals(const Model& model);

}  // namespace stiction::world
