#include "stiction/world/model_parts.hpp"

#include <Eigen/LU>

#include "stiction/world/shapes.hpp"

namespace stiction::world {

bool is_rotation(const Eigen::Matrix3d& R) {
  return (R.transpose() * R - Eigen::Matrix3d::Identity()).norm() <= 1e-9 && R.determinant() > 0;
}

void ModelParts::add_note(std::string_view owner, std::string_view note) { m.notes.push_back(fmt::format("{}: {}", owner, note)); }

void ModelParts::add_owner_name(const std::string& name) {
  if (name.empty() || name.find_first_of("/* ") != std::string::npos)
    core::throw_invalid("name", fmt::format("'{}'", name), "a name without '/', '*' or spaces");
  if (!owner_names_.insert(name).second) core::throw_invalid("name", fmt::format("'{}' twice", name), "each name once");
}

int ModelParts::add_body(std::string name, BodyKind kind, int owner, std::vector<int> dofs) {
  m.bodies.push_back({std::move(name), kind, owner, dofs, dofs});
  m.inertias.emplace_back();
  group.push_back(static_cast<int>(group.size()));
  return static_cast<int>(m.bodies.size()) - 1;
}

void ModelParts::add_geometry(int body, const GeometrySpec& spec) {
  const auto& [name, shape, X_BG, friction, mask, max_force, rule] = spec;
  const std::string full = fmt::format("{}/{}", m.bodies[at(body)].name, name);
  if (!geometry_names_.insert(full).second) core::throw_invalid("geometry", fmt::format("'{}' twice", full), "each name once");
  require_shape(name, shape);
  core::require_nonnegative(fmt::format("{}.friction", name), friction);
  core::require_nonnegative(fmt::format("{}.torsional_friction", name), rule.torsional);
  core::require_nonnegative(fmt::format("{}.rolling_friction", name), rule.rolling);
  if (rule.dimension != 1 && rule.dimension != 3 && rule.dimension != 4 && rule.dimension != 6)
    core::throw_invalid(fmt::format("{}.rule.dimension", name), fmt::format("{}", rule.dimension), "1, 3, 4 or 6");
  if (!(max_force > 0))
    core::throw_invalid(fmt::format("{}.max_force", name), fmt::format("{}", max_force), "a number > 0, or infinity for none");
  if (!is_rotation(X_BG.R) || !X_BG.p.allFinite()) core::throw_invalid(fmt::format("{}.pose", name), "no rigid transform", "one");
  if (std::holds_alternative<HalfSpace>(shape) && m.bodies[at(body)].kind != BodyKind::Fixed) {
    core::throw_invalid(name, "a half-space", "half-spaces on fixed bodies only");
  }
  const BoundingSphere sphere = calc_bounding_sphere(shape);
  m.geometries.push_back({full, body, shape, X_BG, friction, X_BG * sphere.center, sphere.radius, max_force, rule});
  masks.push_back(mask);
}

void ModelParts::add_dof(std::string name, DofKind kind, BodyKind owner_kind, int owner, double lower, double upper, double stiffness,
                         double effort) {
  m.dofs.push_back({std::move(name), kind, owner_kind, owner, lower, upper, lower, upper, stiffness, effort});
}

void ModelParts::join(int parent, int body, bool between) {
  const int above = group[at(parent)], below = group[at(body)];
  std::set<std::pair<int, int>> more{{above, below}};
  for (const auto& [a, b] : adjacent) {
    if (between && b == above) more.emplace(a, below);
  }
  adjacent.merge(more);
}

void ModelParts::set_joint_friction(double friction, double damping) {
  m.dofs.back().friction = friction;
  m.dofs.back().damping = damping;
}

void ModelParts::set_joint_spring(double stiffness, double rest) {
  m.dofs.back().spring = stiffness;
  m.dofs.back().spring_rest = rest;
}

}  // namespace stiction::world
