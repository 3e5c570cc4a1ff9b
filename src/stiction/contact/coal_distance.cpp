#include "stiction/contact/coal_distance.hpp"

#include <coal/narrowphase/narrowphase.h>
#include <coal/shape/convex.h>
#include <coal/shape/geometric_shapes.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "stiction/contact/polish.hpp"
#include "stiction/contact/polytope.hpp"
#include "stiction/core/invalid_input.hpp"

namespace stiction::contact::detail {

struct CoalShape {
  std::unique_ptr<coal::ShapeBase> shape;
};

namespace {

// Tolerance of GJK and EPA [m]. Polytopes (a capsule counts as its axis) end on an exact feature. Around a cylinder Coal's answers
// become wrong without notice below 1e-6.
constexpr double kPolytopeTolerance = 1e-9, kCurvedTolerance = 1e-6;
constexpr int kGjkIterations = 256, kEpaIterations = 128;

using Triangles = std::vector<coal::Triangle>;

/// Most neighbours of a vertex: Coal counts them in a byte.
constexpr std::size_t kMostNeighbours = 255;

std::size_t most_neighbours(const Triangles& triangles, std::size_t n_vertices) {
  std::vector<std::set<coal::Triangle::index_type>> neighbours(n_vertices);
  for (const auto& t : triangles) {
    for (int k = 0; k < 3; ++k) neighbours[t[k]].insert({t[(k + 1) % 3], t[(k + 2) % 3]});
  }
  const auto more = [](const auto& a, const auto& b) { return a.size() < b.size(); };
  return std::max_element(neighbours.begin(), neighbours.end(), more)->size();
}

/// The polygon loop[i] … loop[j], cut in the middle again and again: a corner of n has about 2 log₂ n neighbours, where in a fan one has all.
void halve(const int* loop, int i, int j, Triangles& out) {
  if (j - i < 2) return;
  const int middle = (i + j) / 2;
  out.emplace_back(loop[i], loop[middle], loop[j]);
  halve(loop, i, middle, out);
  halve(loop, middle, j, out);
}

/// @throws core::InvalidInput: an edge from one vertex to each of more than kMostNeighbours others
std::unique_ptr<coal::ShapeBase> make_convex(const MeshData& mesh, const Polytope& polytope) {
  auto points = std::make_shared<std::vector<coal::Vec3s>>();
  for (Eigen::Index i = 0; i < mesh.vertices.cols(); ++i) points->push_back(mesh.vertices.col(i));
  auto triangles = std::make_shared<Triangles>();
  for (Eigen::Index i = 0; i < mesh.triangles.cols(); ++i) {
    triangles->emplace_back(mesh.triangles(0, i), mesh.triangles(1, i), mesh.triangles(2, i));
  }
  if (most_neighbours(*triangles, points->size()) > kMostNeighbours) {  // a cap that is one fan, as tools write it
    triangles->clear();
    for (const Polytope::Face& face : polytope.faces)
      halve(&polytope.loop[static_cast<std::size_t>(face.begin)], 0, face.count - 1, *triangles);
    if (const std::size_t most = most_neighbours(*triangles, points->size()); most > kMostNeighbours) {
      core::throw_invalid("mesh", fmt::format("a vertex with {} edges", most),
                          fmt::format("at most {} at a vertex: fewer triangles", kMostNeighbours));
    }
  }
  const auto n_v = static_cast<unsigned>(points->size()), n_t = static_cast<unsigned>(triangles->size());
  return std::make_unique<coal::Convex<coal::Triangle>>(points, n_v, triangles, n_t);
}

// Coal decides at the first support of a box in the process whether boxes are larger by 1e-10 from then on: they are if that direction
// has a component that is exactly 0. This first one has none.
bool ask_for_first_box() {
  const coal::Box box(1, 1, 1);
  const coal::Transform3s X(Eigen::Quaterniond(0.7, 0.1, 0.5, 0.3).normalized().toRotationMatrix(), coal::Vec3s(0.31, 0.42, 2.3));
  coal::GJKSolver solver;
  solver.gjk_initial_guess = coal::GJKInitialGuess::CachedGuess;
  solver.cached_guess = coal::Vec3s(0.31, 0.42, 2.3);
  coal::Vec3s p_a, p_b, normal;
  return solver.shapeDistance(box, coal::Transform3s(), box, X, true, p_a, p_b, normal) > 0;
}

}  // namespace

std::shared_ptr<const CoalShape> make_coal_shape(const ShapeData& s) {
  auto out = std::make_shared<CoalShape>();
  switch (s.kind) {
    case Kind::Capsule:
      out->shape = std::make_unique<coal::Capsule>(s.radius, 2.0 * s.half.z());
      break;
    case Kind::Box: {
      static const bool asked = ask_for_first_box();
      static_cast<void>(asked);
      out->shape = std::make_unique<coal::Box>(2.0 * s.half);
      break;
    }
    case Kind::Cylinder:
      out->shape = std::make_unique<coal::Cylinder>(s.radius, 2.0 * s.half.z());
      break;
    case Kind::Mesh:
      out->shape = make_convex(*s.mesh, *s.polytope);
      break;
    case Kind::Sphere:
    case Kind::HalfSpace:
      return nullptr;
  }
  return out;
}

struct CoalScratch::Impl {
  coal::GJKSolver solver;
};

CoalScratch::CoalScratch() : impl_(std::make_unique<Impl>()) {
  coal::GJKSolver& solver = impl_->solver;
  solver.gjk_initial_guess = coal::GJKInitialGuess::CachedGuess;
  solver.gjk_max_iterations = kGjkIterations;
  solver.epa_max_iterations = kEpaIterations;
  solver.epa.reset(kEpaIterations, kPolytopeTolerance);  // its storage, so that no query allocates it
}

CoalScratch::~CoalScratch() = default;

void coal_kernel(const ShapeData& a, const Pose& X_WA, const ShapeData& b, const Pose& X_WB, const KernelContext& context, Distance& out) {
  coal::GJKSolver& solver = context.coal->impl().solver;
  const bool curved = a.kind == Kind::Cylinder || b.kind == Kind::Cylinder;
  solver.gjk_tolerance = solver.epa_tolerance = curved ? kCurvedTolerance : kPolytopeTolerance;
  // The first guess is the line of the centres and never the last answer: equal configurations give equal bits.
  const Vector3d guess = a.p_GCenter - X_WA.R.transpose() * (X_WB * b.p_GCenter - X_WA.p);
  solver.cached_guess = guess.squaredNorm() > 0 ? guess : Vector3d::UnitX();
  // Where Coal's walks over the vertices start: where the first one ends.
  const Vector3d towards_a = X_WB.R.transpose() * (X_WA.R * solver.cached_guess);
  solver.support_func_cached_guess = {a.mesh ? find_vertex(*a.mesh, -solver.cached_guess) : 0,
                                      b.mesh ? find_vertex(*b.mesh, towards_a) : 0};

  coal::Vec3s p_a, p_b, normal;
  const double distance = solver.shapeDistance(*a.coal->shape, coal::Transform3s(X_WA.R, X_WA.p), *b.coal->shape,
                                               coal::Transform3s(X_WB.R, X_WB.p), true, p_a, p_b, normal);
  // Coal's normal points from the first shape to the second and p_b − p_a = distance · normal, in penetration too.
  out.phi = distance;
  out.nhat_BA_W = -normal;
  const Vector3d middle = 0.5 * (p_a + p_b);
  out.p_WA = middle + 0.5 * distance * out.nhat_BA_W;
  out.p_WB = middle - 0.5 * distance * out.nhat_BA_W;
  if (curved || a.kind == Kind::Capsule || b.kind == Kind::Capsule || is_doubtful(a, X_WA, b, X_WB, out)) polish(a, X_WA, b, X_WB, out);
}

}  // namespace stiction::contact::detail
