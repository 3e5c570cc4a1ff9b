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
/// Offset of the axis indices of followers while the model is built, since the number of velocity coordinates is not yet known.
inline constexpr int kFollowers = 1 << 24;

inline std::size_t at(int i) { return static_cast<std::size_t>(i); }

bool is_rotation(const Eigen::Matrix3d& R);

/// A Model::Impl under construction, with data on its bodies and geometries that only the construction needs.
class ModelParts {
 public:
  explicit ModelParts(Model::Impl& impl) : m(impl) {}

  /// Calls `body` and prefixes the message of an InvalidInput with the file and the place.
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
  /// Marks a body as joined to its parent by a movable joint. @param between  true: the parent only stands between two joints of one body, which
  /// is joined to the parents of that parent as well
  void join(int parent, int body, bool between);
  void set_joint_friction(double friction, double damping);  ///< sets them for the last coordinate added
  void set_joint_spring(double stiffness, double rest);      ///< sets them for the last coordinate added

  Model::Impl& m;
  std::vector<ContactMask> masks{};          ///< per geometry
  std::vector<int> group{};                  ///< per body: bodies with the same number are welded together
  std::set<std::pair<int, int>> adjacent{};  ///< groups joined by a movable joint
  std::vector<double> reach{};               ///< reach of each joint that moves by itself [m] (S.3)

 private:
  std::set<std::string> owner_names_{}, geometry_names_{};
};

/// Builds the model of a scene without its scales. @throws core::InvalidInput naming file, field, given and expected
std::unique_ptr<Model::Impl> build_model(const Scene& scene);

/// Adds an object to the model. Objects must be added before robots, and robots before fixed bodies. @throws core::InvalidInput with the field
void add_object(ModelParts& parts, const ObjectSpec& spec, int index);
/// Adds a robot to the model. @param spec  robot with its `contents` set
void add_robot(ModelParts& parts, const RobotSpec& spec, int index);

/// Adds the pairs of geometries that may touch, once the model has all its bodies and coordinates. @throws core::InvalidInput: filters, rest
void add_pairs(ModelParts& parts);

}  // namespace stiction::world
