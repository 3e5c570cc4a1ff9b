#pragma once

#include <nlohmann/json.hpp>
#include <vector>

#include "stiction/world/model.hpp"

namespace stiction::app {

/// A model as the page maker draws it: bodies and geometries as in a plan file, and where the bodies are that move. Links of robots without geometry
/// are there as well: files may show them.
class PageScene {
 public:
  /// @param hidden  bodies that are drawn some other way: their geometries are left out
  explicit PageScene(const world::Model& model, const std::vector<int>& hidden = {});

  /// The members "bodies" and "geometries" of a document, and "scene_file", from which the page maker reads how bodies look.
  void write(nlohmann::ordered_json& document) const;

  /// Poses of the moving bodies, [x, y, z, qw, qx, qy, qz] in W each. @param q  (n_q)
  nlohmann::ordered_json poses(const Eigen::VectorXd& q);

  /// Its place in "bodies".
  int place(int body) const { return place_[static_cast<std::size_t>(body)]; }

 private:
  const world::Model& model_;
  world::KinematicsWorkspace work_;
  world::Kinematics kinematics_;
  std::vector<int> shown_, place_;  ///< bodies that are drawn; where each is in that list, −1: nowhere
  std::vector<char> hidden_;        ///< per body
};

nlohmann::ordered_json page_numbers(const Eigen::Vector3d& v);

}  // namespace stiction::app
