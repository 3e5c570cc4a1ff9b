#include "stiction/contact/curvature.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

namespace stiction::contact::detail {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Largest depth below a plane of the shape at which a witness point counts as lying on the plane, as a share of the bounding radius [-].
/// Witness points are accurate to 1e-9 of the sizes of both shapes (rounding, slack of the polish); ten times that is far below the size of
/// any feature.
constexpr double kOnPlane = 1e-8;
constexpr double kParallel = 1e-6;  // sine of the angle below which two straight edges count as parallel, as for two capsules

Surface make_round(double radius) { return {radius, radius, Vector3d::Zero()}; }

Surface box_surface(const ShapeData& s, const Pose& X_WG, const Vector3d& p) {
  const Vector3d out = p.cwiseAbs() - s.half;
  const double on = out.maxCoeff() - kOnPlane * s.bounding_radius;
  int planes = 0, free = 0;
  for (int i = 0; i < 3; ++i) {
    if (out[i] >= on) {
      ++planes;
    } else {
      free = i;
    }
  }
  if (planes == 1) return make_round(kInfinity);
  if (planes == 3) return make_round(0);
  return {kInfinity, 0, X_WG.R.col(free)};
}

// The normals of the planes through p span one dimension on a face, two on an edge, three in a vertex.
Surface mesh_surface(const ShapeData& s, const Pose& X_WG, const Vector3d& p) {
  const MeshData& m = *s.mesh;
  const auto out = [&](Eigen::Index i) { return m.nx[i] * p.x() + m.ny[i] * p.y() + m.nz[i] * p.z() - m.d[i]; };
  const auto normal = [&](Eigen::Index i) { return Vector3d(m.nx[i], m.ny[i], m.nz[i]); };
  double on = -kInfinity;
  Eigen::Index first = 0;
  for (Eigen::Index i = 0; i < m.d.size(); ++i) {
    if (out(i) > on) on = out(i), first = i;
  }
  on -= kOnPlane * s.bounding_radius;
  constexpr double kSame = 1e-9;  // sine of the angle below which two planes count as one plane that was cut into triangles
  const Vector3d n = normal(first);
  Vector3d edge = Vector3d::Zero();
  for (Eigen::Index i = 0; i < m.d.size(); ++i) {
    if (out(i) < on) continue;
    const Vector3d cross = n.cross(normal(i));
    if (cross.squaredNorm() > edge.squaredNorm()) edge = cross;
  }
  if (edge.norm() < kSame) return make_round(kInfinity);
  edge.normalize();
  for (Eigen::Index i = 0; i < m.d.size(); ++i) {
    if (out(i) >= on && std::abs(edge.dot(normal(i))) > kSame) return make_round(0);
  }
  return {kInfinity, 0, X_WG.R * edge};
}

Surface capsule_surface(const ShapeData& s, const Pose& X_WG, const Vector3d& p, const Vector3d& m_W) {
  const Vector3d axis = X_WG.R.col(2);
  const double z = p.z() - s.radius * axis.dot(m_W);  // coordinate of the axis point below p
  if (std::abs(z) >= s.half.z() - kOnPlane * s.bounding_radius) return make_round(s.radius);
  return {kInfinity, s.radius, axis};
}

Surface cylinder_surface(const ShapeData& s, const Pose& X_WG, const Vector3d& p, const Vector3d& m_W) {
  const Vector3d axis = X_WG.R.col(2);
  const double out_side = std::hypot(p.x(), p.y()) - s.radius, out_cap = std::abs(p.z()) - s.half.z();
  const double on = std::max(out_side, out_cap) - kOnPlane * s.bounding_radius;
  if (out_side < on) return make_round(kInfinity);
  if (out_cap < on) return {kInfinity, s.radius, axis};
  // The rim: its support points turn with the radial part of the normal, by r/cos θ along the rim (6).
  const double radial = (m_W - axis * axis.dot(m_W)).norm();
  if (radial < 1e-9) return make_round(kInfinity);  // a rim point with the normal of the cap
  const Vector3d outwards = X_WG.R.col(0) * p.x() + X_WG.R.col(1) * p.y();
  return {s.radius / radial, 0, axis.cross(outwards)};
}

/// A surface in the basis (t1, t2).
struct Curve {
  double radius[2];
  Eigen::Matrix2d E;  // columns: the two directions
};

Curve to_frame(const Surface& s, const Contact& c) {
  Curve out{{s.radius_along, s.radius_across}, Eigen::Matrix2d::Identity()};
  if (s.radius_along == s.radius_across) return out;
  const Eigen::Vector2d along(c.t1_W.dot(s.along_W), c.t2_W.dot(s.along_W));
  const double length = along.norm();
  if (length < 1e-9) {  // a surface direction cannot lie along the normal, so this is no witness point
    out.radius[0] = out.radius[1] = 0;
    return out;
  }
  out.E << along[0], -along[1], along[1], along[0];
  out.E /= length;
  return out;
}

// If both surfaces are flat along one direction, the witness point is not unique along it: the point of A then counts as fixed in A.
void separate_flats(Curve& a, const Curve& b) {
  const auto is_flat = [](double radius) { return radius == kInfinity; };
  const int flat_a = is_flat(a.radius[0]) + is_flat(a.radius[1]), flat_b = is_flat(b.radius[0]) + is_flat(b.radius[1]);
  if (flat_a == 0 || flat_b == 0) return;
  const int at_b = is_flat(b.radius[0]) ? 0 : 1;
  if (flat_b == 1 && flat_a == 2) {
    a.E = b.E;
    a.radius[at_b] = 0;
  } else if (flat_b == 2) {
    for (double& radius : a.radius) radius = is_flat(radius) ? 0 : radius;
  } else {
    const int at_a = is_flat(a.radius[0]) ? 0 : 1;
    const Eigen::Vector2d ea = a.E.col(at_a), eb = b.E.col(at_b);
    if (std::abs(ea[0] * eb[1] - ea[1] * eb[0]) < kParallel) a.radius[at_a] = 0;
  }
}

/// Radius r as (L, r)/(L + r): how much the normal turns and how far the point moves. Both are finite for any r.
struct Projective {
  Eigen::Matrix2d normal, point;  // E diag(·), applied to coordinates along the two directions
};

Projective to_projective(const Curve& curve, double length) {
  Projective out;
  for (int k = 0; k < 2; ++k) {
    const double r = curve.radius[k];
    const double point = r == kInfinity ? 1.0 : r / (length + r);
    out.point.col(k) = point * curve.E.col(k);
    out.normal.col(k) = (1.0 - point) * curve.E.col(k);
  }
  return out;
}

// Solves (D.4). Returns false if the normal has no derivative.
bool solve_rolling(const Projective& a, const Projective& b, double phi, double length, Rolling& D) {
  Eigen::Matrix4d M;
  M << a.normal, b.normal, a.point, -b.point - phi / length * b.normal;
  Eigen::Matrix4d inverse;
  bool regular = false;
  M.computeInverseWithCheck(inverse, regular, 1e-12);
  if (!regular) return false;
  inverse.rightCols<2>() /= length;
  D.topRows<2>() = b.normal * inverse.bottomRows<2>();
  D.middleRows<2>(2) = length * a.point * inverse.topRows<2>();
  D.bottomRows<2>() = length * b.point * inverse.bottomRows<2>();
  return true;
}

}  // namespace

Surface calc_surface(const ShapeData& shape, const Pose& X_WG, const Vector3d& p_W, const Vector3d& m_W) {
  const Vector3d p = X_WG.R.transpose() * (p_W - X_WG.p);
  switch (shape.kind) {
    case Kind::Sphere:
      return make_round(shape.radius);
    case Kind::Capsule:
      return capsule_surface(shape, X_WG, p, m_W);
    case Kind::Box:
      return box_surface(shape, X_WG, p);
    case Kind::Cylinder:
      return cylinder_surface(shape, X_WG, p, m_W);
    case Kind::Mesh:
      return mesh_surface(shape, X_WG, p);
    case Kind::HalfSpace:
      return make_round(kInfinity);
  }
  return make_round(0);
}

Rolling calc_rolling(const Surface& a, const Surface& b, const Contact& contact, double length) {
  Curve curve_a = to_frame(a, contact);
  const Curve curve_b = to_frame(b, contact);
  separate_flats(curve_a, curve_b);
  Rolling D;
  if (!solve_rolling(to_projective(curve_a, length), to_projective(curve_b, length), contact.phi, length, D)) {
    // Coincident centres, or two vertices at one point: the normal is arbitrary and stays fixed to B.
    const Curve vertex{{0, 0}, Eigen::Matrix2d::Identity()}, plane{{kInfinity, kInfinity}, Eigen::Matrix2d::Identity()};
    solve_rolling(to_projective(vertex, length), to_projective(plane, length), contact.phi, length, D);
  }
  return D;
}

Eigen::Vector2d calc_frame_spin(const Contact& c, const std::optional<int>& planar_axis) {
  const Vector3d& n = c.nhat_BA_W;
  Vector3d slope = Vector3d::Zero();  // spin = slope · dn
  if (planar_axis) {
    const Vector3d axis = Vector3d::Unit(*planar_axis);
    const double length = axis.cross(n).norm();
    if (length > 1e-9) slope = c.t2_W.cross(axis) / length;
  } else {
    // The two charts of (4): with s = −1 for the cap of 8° around −z.
    const double sign = n.z() > -0.99 ? 1.0 : -1.0;
    slope = Vector3d(n.y(), -n.x(), 0) / (sign + n.z());
  }
  return {slope.dot(c.t1_W), slope.dot(c.t2_W)};
}

}  // namespace stiction::contact::detail
