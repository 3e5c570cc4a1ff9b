// The point of a Minkowski difference that is nearest to the origin: Gilbert, Johnson and Keerthi 1988. docs/theory/distance.md §5.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "stiction/contact/minkowski.hpp"

namespace stiction::contact::detail {
namespace {

constexpr int kMostIterations = 128;
constexpr double kRounding = 1e-15;  // rounding error of a coordinate, as a share of the sizes [-]
constexpr double kFlat = 1e-30;      // squared area or length below which corners count as degenerate, as a share of the sizes [-]

/// The best part of a simplex so far: its corners, their weights and its point nearest to the origin.
struct Nearest {
  int index[3] = {0, 0, 0};
  double weight[3] = {1, 0, 0};
  int n = 0;
  Vector3d v{0, 0, 0};
  double v2 = std::numeric_limits<double>::infinity();

  void offer(const Vector3d& point, std::initializer_list<int> indices, std::initializer_list<double> weights) {
    const double square = point.squaredNorm();
    if (square >= v2) return;
    v2 = square;
    v = point;
    n = static_cast<int>(indices.size());
    std::copy(indices.begin(), indices.end(), index);
    std::copy(weights.begin(), weights.end(), weight);
  }
};

void try_edge(const Simplex& s, int i, int j, Nearest& best) {
  const Vector3d &p = s.corner[i].w, along = s.corner[j].w - p;
  const double square = along.squaredNorm(), t = -p.dot(along);
  if (!(t > 0 && t < square)) return;
  best.offer(p + (t / square) * along, {i, j}, {1 - t / square, t / square});
}

void try_triangle(const Simplex& s, int i, int j, int k, double least, Nearest& best) {
  const Vector3d &p = s.corner[i].w, &q = s.corner[j].w, &r = s.corner[k].w;
  const Vector3d m = (q - p).cross(r - p);
  const double square = m.squaredNorm();
  if (square <= least) return;
  const double l_p = m.dot(q.cross(r)), l_q = m.dot(r.cross(p)), l_r = m.dot(p.cross(q));
  if (!(l_p > 0 && l_q > 0 && l_r > 0)) return;
  const double sum = l_p + l_q + l_r;
  best.offer(m * (m.dot(p) / square), {i, j, k}, {l_p / sum, l_q / sum, l_r / sum});
}

/// Whether the origin lies within the tetrahedron.
bool is_inside(const Simplex& s) {
  const Vector3d &p = s.corner[0].w, &q = s.corner[1].w, &r = s.corner[2].w, &x = s.corner[3].w;
  const double sides[] = {p.dot(q.cross(r)), -q.dot(r.cross(x)), r.dot(x.cross(p)), -x.dot(p.cross(q))};
  return (sides[0] > 0 && sides[1] > 0 && sides[2] > 0 && sides[3] > 0) || (sides[0] < 0 && sides[1] < 0 && sides[2] < 0 && sides[3] < 0);
}

/// Reduces the simplex to the part that contains its point nearest to the origin. This part contains the newest corner, which is the last
/// one. Returns false if the origin lies inside the simplex.
bool reduce(Simplex& s, double size, Vector3d& v) {
  if (s.n == 4 && is_inside(s)) return false;
  const int last = s.n - 1;
  const double least = kFlat * size * size * size * size;
  Nearest best;
  best.offer(s.corner[last].w, {last}, {1.0});
  for (int i = 0; i < last; ++i) {
    try_edge(s, last, i, best);
    for (int j = i + 1; j < last; ++j) try_triangle(s, last, i, j, least, best);
  }
  const std::array<Corner, 4> from = s.corner;
  for (int k = 0; k < best.n; ++k) s.corner[k] = from[best.index[k]], s.weight[k] = best.weight[k];
  s.n = best.n;
  v = best.v;
  return true;
}

}  // namespace

bool find_nearest(const Minkowski& c, double tolerance, double enough, Simplex& simplex, Vector3d& v) {
  const double size = c.size(), zero = kRounding * size;
  v = c.line();
  if (v.squaredNorm() <= zero * zero) v = Vector3d::UnitX();
  simplex.n = 1;
  c.find_farthest(-v, simplex.corner[0]);
  simplex.weight[0] = 1;
  v = simplex.corner[0].w;
  for (int iteration = 0; iteration < kMostIterations; ++iteration) {
    const double v2 = v.squaredNorm();
    if (v2 <= zero * zero) return false;
    Corner& next = simplex.corner[simplex.n];
    c.find_farthest(-v, next);
    const double length = std::sqrt(v2);
    const double separation = v.dot(next.w) / length;
    if (length - separation <= tolerance || separation >= enough) return true;
    for (int k = 0; k < simplex.n; ++k) {
      if (next.is(simplex.corner[k])) return true;
    }
    const Simplex before = simplex;
    ++simplex.n;
    Vector3d nearer;
    if (!reduce(simplex, size, nearer)) return false;
    if (nearer.squaredNorm() >= v2) {  // rounding allows no further progress
      simplex = before;
      return true;
    }
    v = nearer;
  }
  return true;  // accept the best point so far
}

}  // namespace stiction::contact::detail
