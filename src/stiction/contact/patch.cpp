#include "stiction/contact/patch.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "stiction/contact/patch_reduction.hpp"

namespace stiction::contact::detail {
namespace {

/// Side planes are moved outwards by this share of the reference's radius. Two equal faces on each other then keep their own corners and do
/// not exchange them for the crossings nearby. The shift decreases with the tilt between the faces and is zero from kSlackTilt on [rad].
/// The error of heights is at most a quarter of the product of both constants.
constexpr double kSlack = 1e-6, kSlackTilt = 1e-3;
/// Cosine of the largest angle between the normal of a pair and that of its reference face (18°).
constexpr double kReferenceCosine = 0.95;
/// Cosine of the largest angle at which a face or an edge looks at a plane (60°, so that a box has such a face in every orientation).
constexpr double kLooks = 0.5;
constexpr double kLevel = 1e-7;  // as in closed_form.cpp: smaller height differences count as level, as a share of the bounding radius

constexpr int kLowestCode = 250;
enum class Owner {
  First,
  Second
};

int vertex_code(Owner owner, int vertex) { return (owner == Owner::First ? 0 : 64) + vertex % 64; }
int crossing_code(int edge_first, int edge_second) { return 128 + (edge_first % 11) * 11 + edge_second % 11; }

/// Point of the rim of the cap on the side `end` (±1) that lies farthest along d, in W. If the cap is level up to rounding, the point moves
/// to the middle of the cap, so that it does not jump when the cylinder tilts the other way.
Vector3d rim_point(const ShapeData& s, const Pose& X, const Vector3d& d, double end) {
  const Vector3d l = X.R.transpose() * d;
  const double least = kLevel * s.bounding_radius / (2 * std::max(s.radius, 1e-300));
  const double scale = s.radius / std::max(std::hypot(l.x(), l.y()), std::max(least, 1e-300));
  return X * Vector3d(scale * l.x(), scale * l.y(), end * s.half.z());
}

Vector3d cap_point(const ShapeData& s, const Pose& X, double end, int k) {
  static const double kInside = std::cos(std::numbers::pi / kCapCorners);
  const double angle = 2 * std::numbers::pi * k / kCapPoints;
  return X * Vector3d(kInside * s.radius * std::cos(angle), end * kInside * s.radius * std::sin(angle), end * s.half.z());
}

/// Collects the points of one pair.
class Gatherer {
 public:
  Gatherer(const Placed& a, const Placed& b, const Distance& d, const PatchOptions& options, PatchScratch& scratch)
      : a_(a), b_(b), d_(d), options_(options), scratch_(scratch), points_(scratch.gathered), scale_(a.solid.bounding_radius) {
    if (b.shape.kind != Kind::HalfSpace) scale_ += b.solid.bounding_radius;
    points_.clear();
  }

  void half_space();
  bool faces(bool certain);
  void reduce(Patch& out) { reduce_patch({e1_, e2_, m_, kSame * scale_}, options_, scratch_, out); }

 private:
  bool find_reference();
  void clip_incident();
  void set_slack(double tilt) { slack_ = kSlack * std::max(0.0, 1 - tilt / kSlackTilt) * placed(owner_).solid.bounding_radius; }
  void clip_face(const Polytope& polytope, const Pose& X);
  void clip_cylinder(const ShapeData& s, const Pose& X);
  void clip_polygon(const Vector3d& normal);
  void add_corners(const Vector3d& normal);
  void clip_segment(const Vector3d& p, const Vector3d& q, double radius, int code_p, int code_q);
  void add_rim_point(const ShapeData& s, const Pose& X, double end);
  void add_looking_vertices(const ShapeData& s, const Pose& X);
  void add(double x, double y, double z, PatchPoint kind, const Vector3d& edge, const Vector3d& side, int code);
  void add_witness();
  bool is_attained() const;
  bool is_inside(double x, double y) const;

  Owner incident() const { return owner_ == Owner::First ? Owner::Second : Owner::First; }
  const Placed& placed(Owner owner) const { return owner == Owner::First ? a_ : b_; }
  Vector3d to_local(const Vector3d& p_W) const {
    const Vector3d r = p_W - origin_;
    return {e1_.dot(r), e2_.dot(r), m_.dot(r)};
  }
  /// (s, c) of side k of the reference face.
  const Vector3d& side(int k) const { return placed(owner_).shape.polytope->sides[face_->begin + k]; }
  Vector3d side_normal_W(int k) const { return side(k).x() * e1_ + side(k).y() * e2_; }
  double outside(int k, double x, double y) const { return side(k).x() * x + side(k).y() * y - side(k).z() - slack_; }
  int edge_code(int incident_edge, int k) const {
    return owner_ == Owner::First ? crossing_code(k, incident_edge) : crossing_code(incident_edge, k);
  }

  const Placed &a_, &b_;
  Distance d_;
  const PatchOptions& options_;
  PatchScratch& scratch_;
  std::vector<Patch::Point>& points_;
  double scale_;  // sum of the sizes [m]

  // The reference face, or the plane of the half-space (face_ null).
  Owner owner_ = Owner::Second;
  const Polytope::Face* face_ = nullptr;
  Vector3d origin_{0, 0, 0}, e1_{0, 0, 0}, e2_{0, 0, 0}, m_{0, 0, 0};
  double slack_ = 0;
};

/// Selects the reference face: among the face of A and the face of B best aligned with the normal, the one with the larger separation. If
/// this separation equals the distance of the pair, the face normal replaces the normal of the pair, which is inaccurate near contact.
bool Gatherer::find_reference() {
  double most = -1e300;
  for (const Owner owner : {Owner::Second, Owner::First}) {
    const Placed &self = placed(owner), &other = placed(owner == Owner::First ? Owner::Second : Owner::First);
    const Polytope* polytope = self.shape.polytope.get();
    if (!polytope || polytope->faces.empty()) continue;
    const Vector3d d = owner == Owner::First ? Vector3d(-d_.nhat_BA_W) : d_.nhat_BA_W;
    const Polytope::Face& face = polytope->faces[find_face(*polytope, self.X_W.R.transpose() * d)];
    const Vector3d m = self.X_W.R * face.normal;
    if (m.dot(d) < kReferenceCosine) continue;
    const double separation = -support(other.shape, other.X_W, -m) - (face.d + m.dot(self.X_W.p));
    if (face_ && separation <= most + 1e-12 * scale_) continue;
    most = separation;
    owner_ = owner;
    face_ = &face;
    m_ = m;
  }
  if (!face_) return false;
  const Placed& reference = placed(owner_);
  origin_ = reference.X_W.p + face_->d * m_;
  e1_ = reference.X_W.R * face_->e1;
  e2_ = reference.X_W.R * face_->e2;
  if (most >= d_.phi - kSame * scale_) {
    d_.phi = most;
    d_.nhat_BA_W = owner_ == Owner::First ? Vector3d(-m_) : m_;
  }
  return true;
}

void Gatherer::add(double x, double y, double z, PatchPoint kind, const Vector3d& edge, const Vector3d& side, int code) {
  if (z >= options_.limit) return;
  // No true contact point can be deeper than the distance of the pair. In deep penetration along another normal a corner may seem to be
  // deeper.
  if (z < d_.phi - kSame * scale_) return;
  Patch::Point& p = points_.emplace_back();
  const Vector3d foot = origin_ + x * e1_ + y * e2_;
  p.at.phi = z;
  p.at.p_WB = owner_ == Owner::Second ? foot : Vector3d(foot + z * m_);
  p.at.p_WA = owner_ == Owner::Second ? Vector3d(foot + z * m_) : foot;
  p.at.nhat_BA_W = owner_ == Owner::Second ? m_ : Vector3d(-m_);
  // The lowest point of a rim rolls, so it moves like the witness point of two surfaces and not like a point of a patch.
  p.reference = code >= kLowestCode ? PatchSide::None : owner_ == Owner::First ? PatchSide::A : PatchSide::B;
  p.kind = kind;
  p.edge_W = edge;
  p.side_W = side;
  p.code = code;
}

void Gatherer::add_witness() {
  if (d_.phi >= options_.limit) return;
  Patch::Point& p = points_.emplace_back();
  p.at = d_;
  const Vector3d middle = 0.5 * (d_.p_WA + d_.p_WB);  // the normal may have been replaced
  p.at.p_WA = middle + 0.5 * d_.phi * d_.nhat_BA_W;
  p.at.p_WB = middle - 0.5 * d_.phi * d_.nhat_BA_W;
  p.code = kWitnessCode;
}

bool Gatherer::is_attained() const {
  if (1 - std::abs(m_.dot(d_.nhat_BA_W)) > 1e-12) return false;
  return std::any_of(points_.begin(), points_.end(), [&](const Patch::Point& p) { return p.at.phi <= d_.phi + kSame * scale_; });
}

bool Gatherer::is_inside(double x, double y) const {
  for (int k = 0; face_ && k < face_->count; ++k) {
    if (outside(k, x, y) > 0) return false;
  }
  return true;
}

/// Clips the incident polygon by the side planes of the reference face, one after the other (Sutherland and Hodgman).
void Gatherer::clip_polygon(const Vector3d& normal) {
  std::vector<ClipCorner>&from = scratch_.polygon, &to = scratch_.clipped;
  for (int k = 0; face_ && k < face_->count && !from.empty(); ++k) {
    to.clear();
    bool cut = false;
    ClipCorner p = from.back();
    double d_p = outside(k, p.x, p.y);
    for (const ClipCorner& q : from) {
      const double d_q = outside(k, q.x, q.y);
      if ((d_p <= 0) != (d_q <= 0)) {
        const double t = d_p / (d_p - d_q);
        to.push_back({p.x + t * (q.x - p.x), p.y + t * (q.y - p.y), p.z + t * (q.z - p.z), d_p <= 0 ? ~k : p.edge});
      }
      if (d_q <= 0) {
        to.push_back(q);
      } else {
        cut = true;
      }
      p = q;
      d_p = d_q;
    }
    if (cut) from.swap(to);
  }
  add_corners(normal);
}

/// Adds the corners of the clipped polygon. The two edges that meet in a corner determine its kind.
void Gatherer::add_corners(const Vector3d& normal) {
  const std::vector<ClipCorner>& polygon = scratch_.polygon;
  const int n = static_cast<int>(scratch_.vertex.size());
  const Vector3d zero = Vector3d::Zero();
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const ClipCorner& c = polygon[i];
    const int in = polygon[i > 0 ? i - 1 : polygon.size() - 1].edge, out = c.edge;
    if (in >= 0 && out >= 0) {
      add(c.x, c.y, c.z, PatchPoint::Vertex, zero, zero, vertex_code(incident(), scratch_.vertex[out]));
    } else if (in < 0 && out < 0) {
      const int k = ~in == (~out + 1) % face_->count ? ~in : ~out;  // the corner between two sides is the start of the later side
      const int vertex = placed(owner_).shape.polytope->loop[face_->begin + k];
      add(c.x, c.y, c.z, PatchPoint::Corner, normal, zero, vertex_code(owner_, vertex));
    } else {
      const int edge = std::max(in, out), k = ~std::min(in, out);
      const Vector3d along = scratch_.corner_W[(edge + 1) % n] - scratch_.corner_W[edge];
      add(c.x, c.y, c.z, PatchPoint::Crossing, along.normalized(), side_normal_W(k), edge_code(edge, k));
    }
  }
}

/// Adds the points of a segment: the axis of a capsule with its radius, or a generator of a cylinder.
void Gatherer::clip_segment(const Vector3d& p_W, const Vector3d& q_W, double radius, int code_p, int code_q) {
  const Vector3d p = to_local(p_W), q = to_local(q_W);
  double from = 0, to = 1;
  int cut_p = -1, cut_q = -1;
  for (int k = 0; face_ && k < face_->count; ++k) {
    const double d_p = outside(k, p.x(), p.y()), d_q = outside(k, q.x(), q.y());
    if (d_p > 0 && d_q > 0) return;
    const double t = d_p / (d_p - d_q);
    if (d_p > 0 && t > from) from = t, cut_p = k;
    if (d_q > 0 && t < to) to = t, cut_q = k;
  }
  if (from > to) return;
  const Vector3d along = (q_W - p_W).normalized();
  const auto add_end = [&](double t, int cut, int code) {
    const Vector3d x = p + t * (q - p);
    if (cut < 0) {
      add(x.x(), x.y(), x.z() - radius, PatchPoint::Vertex, Vector3d::Zero(), Vector3d::Zero(), code);
    } else {
      add(x.x(), x.y(), x.z() - radius, PatchPoint::Crossing, along, side_normal_W(cut), edge_code(10, cut));
    }
  };
  add_end(from, cut_p, code_p);
  add_end(to, cut_q, code_q);
}

void Gatherer::clip_face(const Polytope& polytope, const Pose& X) {
  const Polytope::Face& face = polytope.faces[find_face(polytope, X.R.transpose() * -m_)];
  set_slack(m_.cross(X.R * face.normal).norm());
  scratch_.polygon.clear();
  scratch_.vertex.clear();
  scratch_.corner_W.clear();
  for (int i = 0; i < face.count; ++i) {
    const int v = polytope.loop[face.begin + i];
    const Vector3d p_W = X * polytope.vertices[v], p = to_local(p_W);
    scratch_.polygon.push_back({p.x(), p.y(), p.z(), i});
    scratch_.vertex.push_back(v);
    scratch_.corner_W.push_back(p_W);
  }
  clip_polygon(X.R * face.normal);
}

/// Adds the lowest point of a rim, with its exact height.
void Gatherer::add_rim_point(const ShapeData& s, const Pose& X, double end) {
  const Vector3d p = to_local(rim_point(s, X, -m_, end)), l = X.R.transpose() * m_;
  const double z = m_.dot(X.p - origin_) + end * s.half.z() * l.z() - s.radius * std::hypot(l.x(), l.y());
  if (!is_inside(p.x(), p.y())) return;
  add(p.x(), p.y(), z, PatchPoint::Vertex, Vector3d::Zero(), Vector3d::Zero(), kLowestCode + (end > 0 ? 1 : 0));
}

/// Adds the fixed points of the cap that looks at the plane, and the lowest points of the rims that look at it.
void Gatherer::clip_cylinder(const ShapeData& s, const Pose& X) {
  const double slope = X.R.col(2).dot(m_), end = slope > 0 ? -1.0 : 1.0;
  const double upright = std::sqrt(std::max(0.0, 1 - slope * slope));
  if (face_) set_slack(std::abs(slope) > kLooks ? upright : std::abs(slope));
  if (std::abs(slope) > kLooks) {
    scratch_.polygon.clear();
    scratch_.vertex.clear();
    scratch_.corner_W.clear();
    for (int k = 0; k < kCapPoints; ++k) {
      const Vector3d p_W = cap_point(s, X, end, k), p = to_local(p_W);
      scratch_.polygon.push_back({p.x(), p.y(), p.z(), k});
      scratch_.vertex.push_back(k + (end > 0 ? kCapPoints : 0));
      scratch_.corner_W.push_back(p_W);
    }
    clip_polygon(end * X.R.col(2));
  }
  if (upright > kLooks) {
    if (face_) {
      clip_segment(rim_point(s, X, -m_, end), rim_point(s, X, -m_, -end), 0.0, kLowestCode + (end > 0), kLowestCode + (end < 0));
    } else {
      add_rim_point(s, X, end);
      add_rim_point(s, X, -end);
    }
  } else {
    add_rim_point(s, X, end);
  }
}

void Gatherer::clip_incident() {
  const Placed& body = placed(incident());
  const ShapeData& s = body.shape;
  const Pose& X = body.X_W;
  if (s.kind == Kind::Capsule) {
    const Vector3d reach = s.half.z() * X.R.col(2);
    const double slope = X.R.col(2).dot(m_);
    const bool looks = 1 - slope * slope > kLooks * kLooks;
    if (face_) set_slack(std::abs(slope));
    const double end = slope > 0 ? -1.0 : 1.0;  // an upright capsule has its lower end only
    const Vector3d p = X.p + end * reach, q = looks ? Vector3d(X.p - end * reach) : p;
    const int code = vertex_code(incident(), end > 0 ? 1 : 0);
    clip_segment(p, q, s.radius, code, looks ? vertex_code(incident(), end > 0 ? 0 : 1) : code);
    if (!looks && points_.size() > 1) points_.pop_back();
  } else if (s.kind == Kind::Cylinder) {
    clip_cylinder(s, X);
  } else {
    clip_face(*s.polytope, X);
  }
}

bool Gatherer::faces(bool certain) {
  if (find_reference()) {
    clip_incident();
    if (is_attained()) return true;
  }
  if (certain) add_witness();
  return certain;
}

/// Adds the corners of all faces that look at the plane; the lowest corner always counts.
void Gatherer::add_looking_vertices(const ShapeData& s, const Pose& X) {
  const Polytope& polytope = *s.polytope;
  const Vector3d down = X.R.transpose() * -m_;
  const double reach = options_.limit - m_.dot(X.p - origin_) + kSame * scale_;
  const auto looks = [&](int face) { return polytope.faces[static_cast<std::size_t>(face)].normal.dot(down) >= kLooks; };
  const std::size_t lowest = static_cast<std::size_t>(find_vertex(polytope, down));
  for (std::size_t v = 0; v < polytope.vertices.size(); ++v) {
    if (-down.dot(polytope.vertices[v]) >= reach) continue;
    const auto first = polytope.around.begin() + polytope.begin[v], last = polytope.around.begin() + polytope.begin[v + 1];
    if (v != lowest && std::none_of(first, last, looks)) continue;
    const Vector3d p = to_local(X * polytope.vertices[v]);
    add(p.x(), p.y(), p.z(), PatchPoint::Vertex, Vector3d::Zero(), Vector3d::Zero(), vertex_code(Owner::First, static_cast<int>(v)));
  }
}

void Gatherer::half_space() {
  const Pose& X = b_.X_W;
  origin_ = X.p;
  e1_ = X.R.col(0);
  e2_ = X.R.col(1);
  m_ = X.R.col(2);
  if (a_.solid.kind == Kind::Box || a_.solid.kind == Kind::Mesh) {
    add_looking_vertices(a_.solid, a_.X_W);
  } else {
    clip_incident();
  }
  if (points_.empty()) add_witness();
}

}  // namespace

bool has_patch(const ShapeData& a, const ShapeData& b) {
  if (a.kind == Kind::Sphere || b.kind == Kind::Sphere) return false;
  return b.kind == Kind::HalfSpace || a.polytope || b.polytope;
}

bool calc_patch(const Placed& a, const Placed& b, const Distance& d, bool certain, const PatchOptions& options, PatchScratch& scratch,
                Patch& out) {
  Gatherer gatherer(a, b, d, options, scratch);
  if (b.shape.kind == Kind::HalfSpace) {
    gatherer.half_space();
  } else if (!gatherer.faces(certain)) {
    return false;
  }
  gatherer.reduce(out);
  return true;
}

}  // namespace stiction::contact::detail
