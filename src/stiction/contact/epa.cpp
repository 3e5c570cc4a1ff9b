// The shortest way out of a Minkowski difference: van den Bergen's expanding polytope. docs/theory/distance.md §5.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "stiction/contact/minkowski.hpp"

namespace stiction::contact::detail {
namespace {

constexpr double kSame = 1e-13;   // smaller heights over a plane and lengths are rounding, as a share of the sizes [-]
constexpr double kFlat = 1e-9;    // thinner Minkowski differences count as flat, as a share of the sizes [-]
constexpr double kLevel = 1e-12;  // normals count as equal up to this value of 1 − cosine of their angle [-]

/// A polytope of triangles within C. It grows by one corner at a time.
class Expanding {
 public:
  explicit Expanding(double size) : same_(kSame * size) {}

  struct Face {
    int corner[3], next[3];  // next[k]: the face beyond the edge from corner k
    Vector3d normal;
    double d;
    bool alive;
  };

  bool start(const Simplex& s) {
    for (n_corners_ = 0; n_corners_ < 4; ++n_corners_) corners_[n_corners_] = s.corner[n_corners_];
    const auto w = [&](int k) -> const Vector3d& { return corners_[k].w; };
    const bool left = (w(1) - w(0)).cross(w(2) - w(0)).dot(w(3) - w(0)) < 0;  // corner 3 below the triangle 0 1 2
    const int p = left ? 1 : 2, q = left ? 2 : 1;
    const int around[4][3] = {{0, p, q}, {0, 3, p}, {p, 3, q}, {q, 3, 0}};
    const int next[4][3] = {{1, 2, 3}, {3, 2, 0}, {1, 3, 0}, {2, 1, 0}};
    for (n_faces_ = 0; n_faces_ < 4;) {
      const int k = n_faces_;
      if (!add(around[k][0], around[k][1], around[k][2])) return false;
      for (int e = 0; e < 3; ++e) faces_[k].next[e] = next[k][e];
    }
    return true;
  }

  bool is_full() const { return n_corners_ == kMostCorners || n_faces_ + kMostRim > kMostFaces; }

  /// The face nearest to the origin.
  int find_nearest() const {
    int best = -1;
    double least = std::numeric_limits<double>::infinity();
    for (int k = 0; k < n_faces_; ++k) {
      if (faces_[k].alive && faces_[k].d < least) least = faces_[k].d, best = k;
    }
    return best;
  }

  /// Adds a corner beyond face `from`. New faces between this corner and the rim of the faces that it sees replace those faces.
  bool grow(const Corner& corner, int from) {
    corners_[n_corners_++] = corner;
    n_rim_ = 0;
    faces_[from].alive = false;
    for (int e = 0; e < 3; ++e) {
      if (!look(faces_[from].next[e], from)) return false;
    }
    if (n_rim_ < 3) return false;
    const int first = n_faces_, top = n_corners_ - 1;
    for (int k = 0; k < n_rim_; ++k) {
      const Face& hidden = faces_[rim_[k].face];
      const int e = rim_[k].edge, start = hidden.corner[(e + 1) % 3], end = hidden.corner[e];
      if (k > 0 && faces_[n_faces_ - 1].corner[1] != start) return false;  // the rim is no loop
      if (!add(start, end, top)) return false;
    }
    if (faces_[n_faces_ - 1].corner[1] != faces_[first].corner[0]) return false;
    for (int k = 0; k < n_rim_; ++k) {
      Face& face = faces_[first + k];
      face.next[0] = rim_[k].face;
      face.next[1] = first + (k + 1) % n_rim_;
      face.next[2] = first + (k + n_rim_ - 1) % n_rim_;
      faces_[rim_[k].face].next[rim_[k].edge] = first + k;
    }
    return true;
  }

  /// Projects the origin onto the plane of face k and finds the triangle in this plane that contains the projection: its corners and
  /// weights.
  bool find_foot(int k, Simplex& out) const {
    const Vector3d m = faces_[k].normal, foot = faces_[k].d * m;
    for (int walk = 0; walk < kMostCorners; ++walk) {
      const Face& f = faces_[k];
      double sum = 0, weight[3];
      for (int i = 0; i < 3; ++i) {
        weight[i] = m.dot((corners_[f.corner[(i + 1) % 3]].w - foot).cross(corners_[f.corner[(i + 2) % 3]].w - foot));
        sum += weight[i];
      }
      const auto least = static_cast<int>(std::min_element(weight, weight + 3) - weight);
      const int beyond = f.next[(least + 1) % 3];
      if (weight[least] < 0 && faces_[beyond].alive && faces_[beyond].d - faces_[k].d <= same_ &&
          m.dot(faces_[beyond].normal) > 1 - kLevel) {
        k = beyond;
        continue;
      }
      out.n = 3;
      double left = 0;
      for (int i = 0; i < 3; ++i) left += out.weight[i] = std::max(0.0, weight[i]);
      for (int i = 0; i < 3; ++i) out.corner[i] = corners_[f.corner[i]], out.weight[i] /= left;
      return left > 0 && weight[least] > -kSame * sum;
    }
    return false;
  }

  const Face& face(int k) const { return faces_[k]; }

 private:
  static constexpr int kMostCorners = 256, kMostFaces = 1600, kMostRim = 128;

  bool add(int i, int j, int k) {
    Face& f = faces_[n_faces_];
    f.corner[0] = i, f.corner[1] = j, f.corner[2] = k;
    const Vector3d &p = corners_[i].w, &q = corners_[j].w, &r = corners_[k].w;
    const Vector3d m = (q - p).cross(r - p);
    const double area = m.norm();
    const double longest = std::sqrt(std::max({(q - p).squaredNorm(), (r - p).squaredNorm(), (r - q).squaredNorm()}));
    if (!(area > same_ * longest)) return false;
    f.normal = m / area;
    f.d = f.normal.dot(p);
    f.alive = true;
    ++n_faces_;
    return true;
  }

  /// Depth first and anticlockwise, so that the edges of the rim appear in their order around it.
  bool look(int at, int before) {
    Face& f = faces_[at];
    if (!f.alive) return true;
    int e = 0;
    while (e < 3 && f.next[e] != before) ++e;
    if (e == 3) return false;
    if (f.normal.dot(corners_[n_corners_ - 1].w) < f.d - same_) {
      if (n_rim_ == kMostRim) return false;
      rim_[n_rim_++] = {at, e};
      return true;
    }
    f.alive = false;
    return look(f.next[(e + 1) % 3], at) && look(f.next[(e + 2) % 3], at);
  }

  struct RimEdge {
    int face, edge;
  };
  double same_;
  int n_corners_ = 0, n_faces_ = 0, n_rim_ = 0;
  std::array<Corner, kMostCorners> corners_;
  std::array<Face, kMostFaces> faces_;
  std::array<RimEdge, kMostRim> rim_;
};

/// Finds the corner farthest along d and adds it if it is far enough.
template <class Condition>
void offer(const Minkowski& c, const Vector3d& d, Simplex& s, const Condition& is_far) {
  Corner& next = s.corner[s.n];
  c.find_farthest(d, next);
  if (is_far(next.w)) s.weight[s.n++] = 0;
}

/// Extends a simplex that contains the origin to a tetrahedron. Returns false if C is thinner than kFlat; m is then perpendicular to C.
bool complete(const Minkowski& c, Simplex& s, Vector3d& m) {
  const double flat = kFlat * c.size();
  const Vector3d p = s.corner[0].w;
  m = Vector3d::UnitZ();
  for (int k = 0; k < 6 && s.n == 1; ++k) {
    offer(c, (k % 2 ? -1.0 : 1.0) * Vector3d::Unit(k / 2), s, [&](const Vector3d& w) { return (w - p).norm() > flat; });
  }
  if (s.n == 1) return false;
  const Vector3d along = (s.corner[1].w - p).normalized(), u = along.unitOrthogonal(), v = along.cross(u);
  m = u;
  for (int k = 0; k < 6 && s.n == 2; ++k) {
    const double angle = k * std::numbers::pi / 3;
    offer(c, std::cos(angle) * u + std::sin(angle) * v, s, [&](const Vector3d& w) { return along.cross(w - p).norm() > flat; });
  }
  if (s.n == 2) return false;
  m = (s.corner[1].w - p).cross(s.corner[2].w - p).normalized();
  for (const double side : {1.0, -1.0}) {
    if (s.n == 3) offer(c, side * m, s, [&](const Vector3d& w) { return std::abs(m.dot(w - p)) > flat; });
  }
  return s.n == 4;
}

}  // namespace

bool find_way_out(const Minkowski& c, double tolerance, Simplex& simplex, Vector3d& m) {
  if (!complete(c, simplex, m)) return true;  // the shortest way out of a flat C is perpendicular to it
  Expanding polytope(c.size());
  if (!polytope.start(simplex)) return false;
  for (;;) {
    const int k = polytope.find_nearest();
    m = polytope.face(k).normal;
    Corner next;
    c.find_farthest(m, next);
    const bool ends = m.dot(next.w) - polytope.face(k).d <= tolerance;
    if (ends || polytope.is_full()) return polytope.find_foot(k, simplex) && ends;
    if (!polytope.grow(next, k)) return false;
  }
}

}  // namespace stiction::contact::detail
