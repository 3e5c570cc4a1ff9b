#include "stiction/dynamics/rim.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <optional>

#include "stiction/world/axis.hpp"

namespace stiction::dynamics::detail {
namespace {

using Eigen::Vector3d;
using world::Model;

/// Feature number of the lowest point of a rim; the second rim has the next number (docs/theory/patches.md).
constexpr std::uint64_t kFirstRim = 250;
/// Tilt below which the fixed points of the cap gradually replace the lowest point of its rim [rad].
constexpr double kRimTilt = 0.1;

struct Rim {
  const world::Body *cylinder, *other;
  Vector3d axis_W;
  double s;  // s of (S.17)
};

std::optional<Rim> find_rim(const Model& model, const world::Kinematics& kinematics, const contact::Contact& contact) {
  const auto code = contact.id & 0xff;
  if (code != kFirstRim && code != kFirstRim + 1) return std::nullopt;
  const world::Pair& pair = model.pairs()[static_cast<std::size_t>(contact.pair)];
  const auto geometry = [&](int g) -> const world::Geometry& { return model.geometries()[static_cast<std::size_t>(g)]; };
  const bool first = std::holds_alternative<world::Cylinder>(geometry(pair.geometry_a).shape);
  const world::Geometry &own = geometry(first ? pair.geometry_a : pair.geometry_b),
                        &other = geometry(first ? pair.geometry_b : pair.geometry_a);
  if (!std::holds_alternative<world::Cylinder>(own.shape)) return std::nullopt;  // a mesh of many corners
  const Vector3d axis = kinematics.X_WB[static_cast<std::size_t>(own.body)].R * own.X_BG.R.col(2);
  return Rim{&model.bodies()[static_cast<std::size_t>(own.body)], &model.bodies()[static_cast<std::size_t>(other.body)], axis,
             std::min(1.0, axis.cross(contact.nhat_BA_W).norm() / kRimTilt)};
}

}  // namespace

double barrier_share(const Model& model, const world::Kinematics& kinematics, const contact::Contact& contact) {
  const auto rim = find_rim(model, kinematics, contact);
  return rim ? rim->s * rim->s * (3 - 2 * rim->s) : 1.0;
}

bool calc_share_slope(const Model& model, const world::Kinematics& kinematics, const contact::Contact& contact, Eigen::VectorXd& slope) {
  const auto rim = find_rim(model, kinematics, contact);
  if (!rim || rim->s >= 1 || rim->s * rim->s * (3 - 2 * rim->s) < kLeastShare) return false;
  slope.setZero(model.n_v());
  const double s = rim->s, D_log = 6 * (1 - s) / (s * (3 - 2 * s));                 // d ln share / ds
  const Vector3d turn = rim->axis_W.cross(contact.nhat_BA_W);                       // d(a·n̂) = turn · ω
  const double D_s = -rim->axis_W.dot(contact.nhat_BA_W) / turn.norm() / kRimTilt;  // of ‖a × n̂‖ = (1 − (a·n̂)²)^½
  for (const world::Body* body : {rim->cylinder, rim->other}) {
    for (const int axis : body->axes) {
      const auto [dof, kind, ratio] = world::axis_at(model, axis);
      if (kind == world::DofKind::Prismatic) continue;
      slope[dof] += (body == rim->cylinder ? 1 : -1) * ratio * D_log * D_s * turn.dot(kinematics.axis_W.col(axis));
    }
  }
  return true;
}

}  // namespace stiction::dynamics::detail
