// Closed forms: one of the two is a sphere or a half-space, or both are capsules. docs/theory/contact.md §2–4.
#include "stiction/contact/closed_form.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "stiction/world/triangle.hpp"

namespace stiction::contact::detail {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Sets the witness points of a sphere from the surface point of B that is nearest to its centre. s is the signed distance of the centre to
// B's surface, n the outward normal there.
void from_center(const Vector3d& p_WCenter, double radius, double s, const Vector3d& n, Distance& out) {
  out.nhat_BA_W = n;
  out.phi = s - radius;
  out.p_WA = p_WCenter - radius * n;
  out.p_WB = p_WCenter - s * n;
}

bool across_plane(const Planar& planar, const Vector3d& n_W) { return planar.on && std::abs(n_W.dot(planar.axis_W)) > 0.5; }

// A unit vector perpendicular to the unit vector u: column x of R, or in a planar model a vector that also lies in the plane.
Vector3d perpendicular(const Vector3d& u, const Eigen::Matrix3d& R, const Planar& planar) {
  if (planar.on) {
    const Vector3d t = planar.axis_W.cross(u);
    if (t.squaredNorm() > 1e-12) return t.normalized();
    const Vector3d e = coincident_normal(planar);
    return (e - u * u.dot(e)).normalized();
  }
  return R.col(0);
}

struct Segment {
  Vector3d p, u;  // centre, unit direction
  double h;       // half length
};

constexpr double kParallel2 = 1e-12;  // squared angle below which two segments count as parallel [rad²]

// Parameters of the nearest points of two segments (Ericson, Real-Time Collision Detection, §5.1.9, in centred form).
void nearest_parameters(const Segment& a, const Segment& b, double sin2, double& s, double& t) {
  const Vector3d r = a.p - b.p;
  const double ab = a.u.dot(b.u), ar = a.u.dot(r), br = b.u.dot(r);
  s = sin2 > 0 ? std::clamp((ab * br - ar) / sin2, -a.h, a.h) : 0.0;
  t = ab * s + br;
  if (t < -b.h || t > b.h) {
    t = std::clamp(t, -b.h, b.h);
    s = std::clamp(ab * t - ar, -a.h, a.h);
  }
  if (sin2 > 100.0 * kParallel2) return;
  // Nearly parallel: s above has no correct digits. But unless the axes meet, a nearest point is an end of one of the segments.
  double best2 = (r + s * a.u - t * b.u).squaredNorm();
  const auto try_ends = [&](double s_end, double t_end) {
    const double d2 = (r + s_end * a.u - t_end * b.u).squaredNorm();
    if (d2 >= best2) return;
    best2 = d2;
    s = s_end;
    t = t_end;
  };
  for (const double sign : {-1.0, 1.0}) {
    try_ends(sign * a.h, std::clamp(ab * sign * a.h + br, -b.h, b.h));
    try_ends(std::clamp(ab * sign * b.h - ar, -a.h, a.h), sign * b.h);
  }
}

// Middle of the overlap of two parallel segments, or their facing ends if they do not overlap.
void middle_parameters(const Segment& a, const Segment& b, double& s, double& t) {
  const double ab = a.u.dot(b.u), c = -a.u.dot(a.p - b.p);  // centre of b on a's axis
  const double hb = b.h * std::abs(ab);
  const double middle = 0.5 * (std::max(-a.h, c - hb) + std::min(a.h, c + hb));
  s = std::clamp(middle, -a.h, a.h);
  t = std::clamp((middle - c) * (ab < 0 ? -1.0 : 1.0), -b.h, b.h);
}

// Outward normal and signed distance of a point to the surface of a box, cylinder or mesh, in the frame of the shape.
struct PointDistance {
  double s;
  Vector3d n;
};

PointDistance point_box(const Vector3d& p, const Vector3d& half, const Vector3d& planar_axis, bool planar) {
  const Vector3d q = p.cwiseMax(-half).cwiseMin(half);
  const Vector3d d = p - q;
  const double outside2 = d.squaredNorm();
  if (outside2 > 0) {
    const double length = std::sqrt(outside2);
    return {length, d / length};
  }
  int axis = -1;
  double best = -kInfinity;
  for (int i = 0; i < 3; ++i) {
    const double s = std::abs(p[i]) - half[i];
    if (s > best && !(planar && std::abs(planar_axis[i]) > 0.5)) {
      best = s;
      axis = i;
    }
  }
  Vector3d n = Vector3d::Zero();
  n[axis] = p[axis] < 0 ? -1.0 : 1.0;
  return {best, n};
}

PointDistance point_cylinder(const Vector3d& p, double radius, double half, const Vector3d& planar_axis, bool planar) {
  const double rho = std::hypot(p.x(), p.y());
  Vector3d radial(1, 0, 0);
  if (rho > 0) {
    radial = Vector3d(p.x() / rho, p.y() / rho, 0);
  } else if (planar && std::abs(planar_axis.z()) < 0.9) {
    radial = Vector3d(-planar_axis.y(), planar_axis.x(), 0).normalized();
  }
  const Vector3d cap(0, 0, p.z() < 0 ? -1.0 : 1.0);
  const double s_side = rho - radius, s_cap = std::abs(p.z()) - half;
  if (s_side <= 0 && s_cap <= 0) {
    const bool no_cap = planar && std::abs(planar_axis.z()) > 0.5;
    return s_side >= s_cap || no_cap ? PointDistance{s_side, radial} : PointDistance{s_cap, cap};
  }
  const double a = std::max(s_side, 0.0), b = std::max(s_cap, 0.0);
  const double length = std::hypot(a, b);
  return {length, (a * radial + b * cap) / length};
}

PointDistance point_mesh(const Vector3d& p, const MeshData& mesh, const Vector3d& planar_axis, bool planar) {
  const auto plane = [&](Eigen::Index i) { return mesh.nx[i] * p.x() + mesh.ny[i] * p.y() + mesh.nz[i] * p.z() - mesh.d[i]; };
  const Eigen::Index n_f = mesh.d.size();
  Eigen::Index top = -1, top_allowed = -1;
  double s = -kInfinity, s_allowed = -kInfinity;
  for (Eigen::Index i = 0; i < n_f; ++i) {
    const double value = plane(i);
    if (value > s) {
      s = value;
      top = i;
    }
    if (planar && value > s_allowed && std::abs(planar_axis.dot(Vector3d(mesh.nx[i], mesh.ny[i], mesh.nz[i]))) <= 0.5) {
      s_allowed = value;
      top_allowed = i;
    }
  }
  if (s <= 0) {
    if (planar && top_allowed >= 0) {
      s = s_allowed;
      top = top_allowed;
    }
    return {s, Vector3d(mesh.nx[top], mesh.ny[top], mesh.nz[top])};
  }
  // Outside: the nearest point lies on a face that looks at p, and no face is nearer than its plane.
  double best2 = kInfinity;
  Vector3d nearest = p;
  const auto visit = [&](Eigen::Index i) {
    const auto tri = mesh.triangles.col(mesh.face[i]);
    const Vector3d q = world::nearest_on_triangle(p, mesh.vertices.col(tri[0]), mesh.vertices.col(tri[1]), mesh.vertices.col(tri[2]));
    const double d2 = (p - q).squaredNorm();
    if (d2 < best2) {
      best2 = d2;
      nearest = q;
    }
  };
  visit(top);
  for (Eigen::Index i = 0; i < n_f; ++i) {
    const double value = plane(i);
    if (i != top && value > 0 && value * value < best2) visit(i);
  }
  const double length = std::sqrt(best2);
  // The point lies on the surface up to rounding: take the normal of the plane.
  if (length <= 1e-12 * mesh.radius) return {s, Vector3d(mesh.nx[top], mesh.ny[top], mesh.nz[top])};
  return {length, (p - nearest) / length};
}

// Sets the answer for half-space B and a support point of A at height s over its plane. p_WA is moved to the height s, a shift of rounding
// size.
void from_support(const Vector3d& p_W, double s, const Pose& X_WB, Distance& out) {
  const Vector3d n = X_WB.R.col(2);
  out.nhat_BA_W = n;
  out.phi = s;
  out.p_WB = p_W - n * n.dot(p_W - X_WB.p);
  out.p_WA = out.p_WB + s * n;
}

// Position of the lowest point along an edge, from −h to h, for half length h and slope a (sine of its angle to the plane). For an edge
// that is level to within `level`, the point moves through the middle from end to end without a jump.
double lower_end(double h, double a, double level) { return -h * std::clamp(2.0 * h * a / level, -1.0, 1.0); }

constexpr double kLevel = 1e-7;  // smaller height differences count as level, as a share of the bounding radius [-]

}  // namespace

void sphere_sphere_kernel(const ShapeData& a, const Pose& X_WA, const ShapeData& b, const Pose& X_WB, const KernelContext& context,
                          Distance& out) {
  sphere_sphere(X_WA.p, a.radius, X_WB.p, b.radius, coincident_normal(context.planar), out);
}

void sphere_capsule_kernel(const ShapeData& a, const Pose& X_WA, const ShapeData& b, const Pose& X_WB, const KernelContext& context,
                           Distance& out) {
  const Vector3d u = X_WB.R.col(2);
  const double t = std::clamp(u.dot(X_WA.p - X_WB.p), -b.half.z(), b.half.z());
  const Vector3d q = X_WB.p + t * u;
  const Vector3d d = X_WA.p - q;
  const double length = d.norm();
  const Vector3d n = length > 0 ? Vector3d(d / length) : perpendicular(u, X_WB.R, context.planar);
  out.nhat_BA_W = n;
  out.phi = length - a.radius - b.radius;
  out.p_WA = X_WA.p - a.radius * n;
  out.p_WB = q + b.radius * n;
}

void sphere_box_kernel(const ShapeData& a, const Pose& X_WA, const ShapeData& b, const Pose& X_WB, const KernelContext& context,
                       Distance& out) {
  const Vector3d p = X_WB.R.transpose() * (X_WA.p - X_WB.p);
  const PointDistance r = point_box(p, b.half, X_WB.R.transpose() * context.planar.axis_W, context.planar.on);
  from_center(X_WA.p, a.radius, r.s, X_WB.R * r.n, out);
}

void sphere_cylinder_kernel(const ShapeData& a, const Pose& X_WA, const ShapeData& b, const Pose& X_WB, const KernelContext& context,
                            Distance& out) {
  const Vector3d p = X_WB.R.transpose() * (X_WA.p - X_WB.p);
  const PointDistance r = point_cylinder(p, b.radius, b.half.z(), X_WB.R.transpose() * context.planar.axis_W, context.planar.on);
  from_center(X_WA.p, a.radius, r.s, X_WB.R * r.n, out);
}

void sphere_mesh_kernel(const ShapeData& a, const Pose& X_WA, const ShapeData& b, const Pose& X_WB, const KernelContext& context,
                        Distance& out) {
  const Vector3d p = X_WB.R.transpose() * (X_WA.p - X_WB.p);
  const PointDistance r = point_mesh(p, *b.mesh, X_WB.R.transpose() * context.planar.axis_W, context.planar.on);
  from_center(X_WA.p, a.radius, r.s, X_WB.R * r.n, out);
}

void capsule_capsule_kernel(const ShapeData& a, const Pose& X_WA, const ShapeData& b, const Pose& X_WB, const KernelContext& context,
                            Distance& out) {
  const Segment sa{X_WA.p, X_WA.R.col(2), a.half.z()}, sb{X_WB.p, X_WB.R.col(2), b.half.z()};
  const double sin2 = sa.u.cross(sb.u).squaredNorm();
  double s = 0, t = 0;
  nearest_parameters(sa, sb, sin2, s, t);
  const Vector3d qa = sa.p + s * sa.u, qb = sb.p + t * sb.u;
  const Vector3d d = qa - qb;
  const double length = d.norm();
  Vector3d n;
  if (length > 1e-14 * (a.bounding_radius + b.bounding_radius)) {
    n = d / length;
  } else {
    const Vector3d cross = sa.u.cross(sb.u);
    const double size = cross.norm();
    n = size > 1e-9 && !across_plane(context.planar, cross / size) ? Vector3d(cross / size) : perpendicular(sa.u, X_WA.R, context.planar);
  }
  out.nhat_BA_W = n;
  out.phi = length - a.radius - b.radius;
  Vector3d middle = 0.5 * (qa - a.radius * n + qb + b.radius * n);
  const double weight = kParallel2 * kParallel2 / (kParallel2 * kParallel2 + sin2 * sin2);
  if (weight > 1e-12) {  // parallel axes: only the witness point moves to the middle of the overlap; phi and the normal stay
    double s_middle = 0, t_middle = 0;
    middle_parameters(sa, sb, s_middle, t_middle);
    middle += 0.5 * weight * ((s_middle - s) * sa.u + (t_middle - t) * sb.u);
  }
  out.p_WA = middle + 0.5 * out.phi * n;
  out.p_WB = middle - 0.5 * out.phi * n;
}

void sphere_halfspace_kernel(const ShapeData& a, const Pose& X_WA, const ShapeData&, const Pose& X_WB, const KernelContext&,
                             Distance& out) {
  const Vector3d n = X_WB.R.col(2);
  from_center(X_WA.p, a.radius, n.dot(X_WA.p - X_WB.p), n, out);
}

void capsule_halfspace_kernel(const ShapeData& a, const Pose& X_WA, const ShapeData&, const Pose& X_WB, const KernelContext&,
                              Distance& out) {
  const Vector3d n = X_WB.R.col(2), u = X_WA.R.col(2);
  const double slope = n.dot(u), h = a.half.z();
  const double end = lower_end(h, slope, kLevel * a.bounding_radius);
  from_support(X_WA.p + end * u - a.radius * n, n.dot(X_WA.p - X_WB.p) - h * std::abs(slope) - a.radius, X_WB, out);
}

void box_halfspace_kernel(const ShapeData& a, const Pose& X_WA, const ShapeData&, const Pose& X_WB, const KernelContext&, Distance& out) {
  const Vector3d n = X_WB.R.col(2);
  const Vector3d slope = X_WA.R.transpose() * n;
  Vector3d corner;
  for (int i = 0; i < 3; ++i) corner[i] = lower_end(a.half[i], slope[i], kLevel * a.bounding_radius);
  from_support(X_WA * corner, n.dot(X_WA.p - X_WB.p) - a.half.dot(slope.cwiseAbs()), X_WB, out);
}

void cylinder_halfspace_kernel(const ShapeData& a, const Pose& X_WA, const ShapeData&, const Pose& X_WB, const KernelContext&,
                               Distance& out) {
  const Vector3d n = X_WB.R.col(2);
  const Vector3d slope = X_WA.R.transpose() * n;
  const double tilt = std::hypot(slope.x(), slope.y());  // sine of the angle between axis and normal
  const double level = kLevel * a.bounding_radius;
  const double scale = a.radius / std::max(tilt, a.radius > 0 ? level / (2.0 * a.radius) : 1.0);
  const Vector3d p(-scale * slope.x(), -scale * slope.y(), lower_end(a.half.z(), slope.z(), level));
  from_support(X_WA * p, n.dot(X_WA.p - X_WB.p) - a.half.z() * std::abs(slope.z()) - a.radius * tilt, X_WB, out);
}

void mesh_halfspace_kernel(const ShapeData& a, const Pose& X_WA, const ShapeData&, const Pose& X_WB, const KernelContext&, Distance& out) {
  const Vector3d n = X_WB.R.col(2);
  const Vector3d slope = X_WA.R.transpose() * n;
  const Eigen::Matrix3Xd& v = a.mesh->vertices;
  const double lowest = slope.dot(v.col(find_vertex(*a.mesh, -slope)));
  const double level = kLevel * a.bounding_radius;
  static_assert(kLevel < SupportTable::kNear, "every vertex with a weight is among the lowest");
  Vector3d sum = Vector3d::Zero();
  double weights = 0;
  for (const int i : a.mesh->farthest.near(-slope)) {
    const double weight = 1.0 - (slope.dot(v.col(i)) - lowest) / level;
    if (weight <= 0) continue;
    sum += weight * v.col(i);
    weights += weight;
  }
  from_support(X_WA * Vector3d(sum / weights), n.dot(X_WA.p - X_WB.p) + lowest, X_WB, out);
}

}  // namespace stiction::contact::detail
