#include "stiction/world/mjcf_geoms.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <memory>

#include "stiction/core/invalid_input.hpp"
#include "stiction/world/shapes.hpp"

namespace stiction::world {

MjcfGeoms::MjcfGeoms(const MjcfView& view) : MjcfView(view) {
  for (int g = 0; g < m_->ngeom; ++g) given_.insert(given_name(mjOBJ_GEOM, g));
}

RobotCollision MjcfGeoms::read(int geom, const std::string& holder, bool simpler) {
  const mjtNum *p = m_->geom_pos + 3 * geom, *wxyz = m_->geom_quat + 4 * geom;
  RobotCollision c{
      .name = {},
      .shape = read_shape(geom),
      .X_LG = {Eigen::Quaterniond(wxyz[0], wxyz[1], wxyz[2], wxyz[3]).normalized().toRotationMatrix(), Eigen::Vector3d(p[0], p[1], p[2])}};
  c.name = make_name(geom, holder, c.shape);
  c.friction = m_->geom_friction[3 * geom];
  c.mask = {static_cast<std::uint32_t>(m_->geom_contype[geom]), static_cast<std::uint32_t>(m_->geom_conaffinity[geom])};
  // The model combines two rules as MuJoCo does: the larger condim, and the friction of the higher priority.
  c.rule = {.dimension = m_->geom_condim[geom],
            .torsional = m_->geom_friction[3 * geom + 1],
            .rolling = m_->geom_friction[3 * geom + 2],
            .priority = m_->geom_priority[geom]};
  if (const auto* mesh = std::get_if<Mesh>(&c.shape); mesh != nullptr && simpler) {
    SimplifiedHull hull = simplify_hull_by_share(*mesh->mesh, kHullTolerance);
    hulls_.add(hull.error, given_name(mjOBJ_MESH, m_->geom_dataid[geom]));
    c.shape = Mesh{std::make_shared<const ConvexMesh>(std::move(hull.mesh))};
  }
  return c;
}

std::string MjcfGeoms::full_name(int geom) const {
  const auto found = full_name_.find(geom);
  return found != full_name_.end() ? found->second : "";
}

/// Makes a name that is unique in the holder. A geom without a name gets its kind and number, unless another geom has that name.
std::string MjcfGeoms::make_name(int geom, const std::string& holder, const Shape& shape) {
  const int body = m_->geom_bodyid[geom];
  const std::string given = given_name(mjOBJ_GEOM, geom);
  std::string own = given.empty() ? fmt::format("{}_{}", shape_name(shape), geom - m_->body_geomadr[body]) : usable(given);
  while (own != given && given_.contains(own)) own += "_";
  if (holder != body_name(body)) own = fmt::format("{}.{}", body_name(body), own);
  while (!taken_.insert(fmt::format("{}/{}", holder, own)).second) own += "_";
  full_name_.emplace(geom, fmt::format("{}/{}", holder, own));
  return own;
}

Shape MjcfGeoms::read_shape(int geom) const {
  if (const auto shape = read_primitive(geom)) return *shape;
  const int mesh = m_->geom_dataid[geom];
  const Eigen::Map<const Eigen::Matrix3Xf> vertices(m_->mesh_vert + 3 * m_->mesh_vertadr[mesh], 3, m_->mesh_vertnum[mesh]);
  try {
    auto hull = std::make_shared<ConvexMesh>(make_convex_hull(vertices.cast<double>()));
    hull->source = file_.string();
    return Mesh{std::move(hull)};
  } catch (const core::InvalidInput& e) {
    throw core::InvalidInput(fmt::format("{}: mjcf: got mesh '{}': {}, expected a mesh with a convex hull", file_.string(),
                                         given_name(mjOBJ_MESH, mesh), e.what()));
  }
}

}  // namespace stiction::world
