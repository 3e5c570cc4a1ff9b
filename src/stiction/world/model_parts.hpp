#pragma once

#include <fmt/format.h>

#include <limits>
#include <memory>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "stiction/core/invalid_input.hpp"
#include "stiction/world/model_impl.hpp"

namespace stiction::world {

inline constexpr double kInfinity = std::numeric_limits<double>::infinity();
/// Axes of followers are counted from here until there are no more coordinates to come.
inline constexpr int kFollowers = 1 << 24;

inline std::size_t at(int i) { return static_cast<std::size_t>(i); }

bool is_rotation(const Eigen::Matrix3d& R);

/// A Model::Impl that is being built, and what is known of its bodies and geometries until then.
class ModelParts {
 public:
  explicit ModelParts(Model::Impl& impl) : m(impl) {}

  /// Puts the file and the place in front of what a check in `body` says.
  template <class F>
  void guard(const std::string& place, F&& body) const {
    try {
      body();
    } catch (const core::InvalidInput& e) {
      const std::string file = m.scene.file.empty() ? "" : m.scene.file.string() + ": ";
      throw core::InvalidInput(fmt::format("{}{}: {}", file, place, e.what()));
    }
  }

  void add_note(std::string_view owner, std::string_view note);
  void add_owner_name(const std::string& name);
  int add_body(std::string name, BodyKind kind, int owner, std::vector<int> dofs);
  void add_geometry(int body, const GeometrySpec& spec);
  void add_dof(std::string name, DofKind kind, BodyKind owner_kind, int owner, double lower, double upper, double stiffness,
               double effort = kInfinity);
  void set_joint_friction(double friction, double damping);  ///< of the last coordinate
  void set_joint_spring(double stiffness, double rest);      ///< of the last coordinate

  Model::Impl& m;
  std::vector<ContactMask> masks{};          ///< per geometry
  std::vector<int> group{};                  ///< per body: bodies with the same number are welded together
  std::set<std::pair<int, int>> adjacent{};  ///< groups joined by a movable joint
  std::vector<double> reach{};               ///< per joint that moves by itself (S.3)

 private:
  std::set<std::string> owner_names_{}, geometry_names_{};
};

/// The model of a scene without its scales. @throws core::InvalidInput naming file, field, given and expected
std::unique_ptr<Model::Impl> build_model(const Scene& scene);

/// Objects come before robots, robots before fixed bodies. @throws core::InvalidInput by the name of the field
void add_object(ModelParts& parts, const ObjectSpec& spec, int index);
/// @param spec  with its contents
void add_robot(ModelParts& parts, const RobotSpec& spec, int index);

/// Pairs of geometries that may touch, of a model that has all its bodies and coordinates. @throws core::InvalidInput: filters, rest
void add_pairs(ModelParts& parts);

}  // namespace stiction::world
