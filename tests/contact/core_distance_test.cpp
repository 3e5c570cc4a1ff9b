// Polytopes and capsules against Coal, and against all separating axes: corners, edges and faces, deep and grazing, flat, needles, metres.
#include <coal/narrowphase/narrowphase.h>
#include <coal/shape/convex.h>
#include <coal/shape/geometric_shapes.h>
#include <gtest/gtest.h>

#include "contact/shapes.hpp"

namespace stiction::contact {
namespace {

using test::Random;
using test::Vector3d;
using world::Pose;

/// Hull of n points of an ellipsoid, by trying all planes.
world::Mesh make_round(Random& random, int n, const Vector3d& half) {
  auto m = std::make_shared<world::ConvexMesh>();
  m->vertices.resize(3, n);
  for (int i = 0; i < n; ++i) m->vertices.col(i) = half.cwiseProduct(random.direction());
  std::vector<Eigen::Vector3i> triangles;
  const auto add = [&](int i, int j, int k) {
    const Vector3d p = m->vertices.col(i);
    const Vector3d normal = (m->vertices.col(j) - p).cross(Vector3d(m->vertices.col(k)) - p);
    double most = -1;
    for (int v = 0; v < n; ++v) {
      if (v != i && v != j && v != k) most = std::max(most, normal.dot(m->vertices.col(v) - p));
    }
    if (most <= 0) triangles.emplace_back(i, j, k);
  };
  for (int i = 0; i < n; ++i) {
    for (int j = i + 1; j < n; ++j) {
      for (int k = j + 1; k < n; ++k) add(i, j, k), add(i, k, j);
    }
  }
  m->triangles.resize(3, static_cast<Eigen::Index>(triangles.size()));
  for (std::size_t i = 0; i < triangles.size(); ++i) m->triangles.col(static_cast<Eigen::Index>(i)) = triangles[i];
  return {m};
}

world::Mesh scaled(const world::Mesh& mesh, double scale) {
  auto m = std::make_shared<world::ConvexMesh>(*mesh.mesh);
  m->vertices *= scale;
  return {m};
}

std::unique_ptr<coal::ShapeBase> make_coal(const world::Shape& shape) {
  if (const auto* s = std::get_if<world::Box>(&shape)) return std::make_unique<coal::Box>(2.0 * s->half_extents);
  if (const auto* s = std::get_if<world::Capsule>(&shape)) return std::make_unique<coal::Capsule>(s->radius, 2.0 * s->half_length);
  const world::ConvexMesh& m = *std::get<world::Mesh>(shape).mesh;
  auto points = std::make_shared<std::vector<coal::Vec3s>>();
  auto triangles = std::make_shared<std::vector<coal::Triangle>>();
  for (Eigen::Index i = 0; i < m.vertices.cols(); ++i) points->push_back(m.vertices.col(i));
  for (Eigen::Index i = 0; i < m.triangles.cols(); ++i) triangles->emplace_back(m.triangles(0, i), m.triangles(1, i), m.triangles(2, i));
  return std::make_unique<coal::Convex<coal::Triangle>>(points, points->size(), triangles, triangles->size());
}

double ask_coal(const coal::ShapeBase& a, const Pose& X_WA, const coal::ShapeBase& b, const Pose& X_WB) {
  coal::GJKSolver solver;
  solver.gjk_tolerance = solver.epa_tolerance = 1e-9;
  solver.gjk_max_iterations = 256;
  solver.epa_max_iterations = 255;
  solver.epa.reset(255, 1e-9);
  solver.gjk_initial_guess = coal::GJKInitialGuess::CachedGuess;
  solver.cached_guess = X_WA.R.transpose() * (X_WA.p - X_WB.p);
  if (solver.cached_guess.squaredNorm() == 0) solver.cached_guess = Vector3d::UnitX();
  coal::Vec3s p_a, p_b, normal;
  return solver.shapeDistance(a, coal::Transform3s(X_WA.R, X_WA.p), b, coal::Transform3s(X_WB.R, X_WB.p), true, p_a, p_b, normal);
}

struct PairCase {
  std::string name;
  world::Shape a, b;
  double size;
};
void PrintTo(const PairCase& c, std::ostream* os) { *os << c.name; }

std::vector<PairCase> all_cases() {
  Random random(2);
  const Vector3d half(0.05, 0.03, 0.08);
  const world::Mesh round = make_round(random, 40, half), other = make_round(random, 40, half.reverse());
  const world::Mesh flat = make_round(random, 40, {0.1, 0.08, 1e-4}), needle = make_round(random, 40, {5e-4, 5e-4, 0.2});
  return {{"box_mesh", world::Box{half}, test::make_mesh(), 0.2},
          {"box_round", world::Box{half}, round, 0.2},
          {"boxes_of_triangles", test::make_box_mesh(half), test::make_box_mesh(half), 0.2},
          {"round_round", round, other, 0.2},
          {"capsule_box", world::Capsule{0.03, 0.06}, world::Box{half}, 0.2},
          {"capsule_round", world::Capsule{0.03, 0.06}, round, 0.2},
          {"flat_round", flat, round, 0.2},
          {"needle_round", needle, round, 0.3},
          {"needle_flat", needle, flat, 0.3},
          {"metres", scaled(round, 50), scaled(other, 50), 10.0},
          {"plate_round", world::Box{{0.2, 0.2, 1e-3}}, round, 0.3}};
}

class AgainstCoal : public ::testing::TestWithParam<PairCase> {};
INSTANTIATE_TEST_SUITE_P(Pairs, AgainstCoal, ::testing::ValuesIn(all_cases()), [](const auto& p) { return p.param.name; });

// A at a gap from B, aside from it in any direction or along one of the axes of B, turned at random, like B, or nearly so.
Pose make_pose(Random& random, const PairCase& pair, const Pose& X_WB, int i) {
  constexpr double gaps[] = {0.3, 1e-3, 1e-6, 1e-9, 1e-12, 0, -1e-12, -1e-9, -1e-6, -1e-3, -0.1};
  const double tilt = i % 3 == 0 ? 0.0 : std::pow(10.0, random.uniform(-12, -1));
  Pose X_WA{i % 2 ? random.rotation() : Eigen::Matrix3d(X_WB.R * Eigen::AngleAxisd(tilt, random.direction()).toRotationMatrix()), X_WB.p};
  X_WA.p += pair.size * (i % 5 == 0 ? Vector3d(X_WB.R.col(i % 3)) : random.direction()) + pair.size * random.in_cube(0.05);
  const Distance d = calc_distance(pair.a, X_WA, pair.b, X_WB);
  X_WA.p += (pair.size * gaps[(i / 6) % 11] - d.phi) * d.nhat_BA_W;
  return X_WA;
}

TEST_P(AgainstCoal, GapAndDepthAgree_AndItsBoundsMeet) {
  const PairCase& pair = GetParam();
  const auto coal_a = make_coal(pair.a), coal_b = make_coal(pair.b);
  const double tolerance = 1e-9 * pair.size;
  Random random(8);
  int apart = 0, over = 0;
  for (int i = 0; i < 660; ++i) {
    const Pose X_WB = random.pose(pair.size), X_WA = make_pose(random, pair, X_WB, i);
    const Distance d = calc_distance(pair.a, X_WA, pair.b, X_WB);
    (d.phi > 0 ? apart : over)++;
    // phi is a true separation and, apart, the distance of two points: nothing is left to prove. Coal stops up to 1e-6 short of touching.
    const double coal = ask_coal(*coal_a, X_WA, *coal_b, X_WB);
    EXPECT_NEAR(d.phi, coal, (d.phi > 0 ? 1e-6 : 1e-8) * pair.size) << i;
    EXPECT_NEAR(test::gap_along(pair.a, X_WA, pair.b, X_WB, d.nhat_BA_W), d.phi, tolerance) << i;
    EXPECT_LE((d.p_WA - d.p_WB - d.phi * d.nhat_BA_W).norm(), 1e-14 * pair.size) << i;
    EXPECT_LE(test::outside(pair.a, X_WA, d.p_WA), tolerance) << i << " phi " << d.phi;
    EXPECT_LE(test::outside(pair.b, X_WB, d.p_WB), tolerance) << i << " phi " << d.phi;
  }
  EXPECT_GT(apart, 100);
  EXPECT_GT(over, 100);
}

}  // namespace
}  // namespace stiction::contact
