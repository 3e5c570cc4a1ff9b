#include "stiction/sensing/residual.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "sensing/random_contact.hpp"
#include "support/message_of.hpp"

namespace stiction::sensing::test {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Optimality of a convex problem: f ∈ K, y = A f − a ∈ K*, y·f = 0, as shares of ‖τ‖² where forces have unit gain.
void expect_optimal(const RandomContact& c, const FrictionCone& cone, const Residual& r, double tolerance, int problem) {
  const Vector3d f_L = c.R * r.force_C;
  const Vector3d y = c.R.transpose() * (c.J_C() * (c.J_C().transpose() * f_L - c.tau));
  const double unit = c.J_C().norm() * c.tau.norm();  // of y
  EXPECT_TRUE(cone.contains(r.force_C, 1e-12)) << "problem " << problem << ": f = " << r.force_C.transpose();
  const double dual = cone.is_lorentz() ? y[0] - cone.friction() * y.tail<2>().norm() : (cone.ray_matrix().transpose() * y).minCoeff();
  EXPECT_GE(dual, -tolerance * unit) << "problem " << problem;
  EXPECT_NEAR(y.dot(r.force_C), 0, tolerance * c.tau.squaredNorm()) << "problem " << problem;
  EXPECT_NEAR(r.value, c.objective(r.force_C), 1e-12 * c.tau.squaredNorm()) << "problem " << problem;
}

TEST(Residual, PolyhedralCones_SatisfyKkt) {
  core::Random random(1, 0);
  constexpr int kRays[] = {3, 4, 6, 8, 64};
  int faces[4] = {};
  for (int i = 0; i < 2000; ++i) {
    const RandomContact c(random, 3 + random.index(5), 7, 0.3);
    const FrictionCone cone(2 * random.uniform() + 0.01, kRays[i % 5]);
    const Residual r = calc_residual(c.link(), c.p, c.R, cone);
    expect_optimal(c, cone, r, 1e-9, i);
    ++faces[static_cast<int>(r.face)];
  }
  for (const int count : faces) EXPECT_GT(count, 50) << "each face of the cone is the answer sometimes";
}

TEST(Residual, LorentzCone_SatisfiesKkt) {
  core::Random random(2, 0);
  int faces[4] = {};
  for (int i = 0; i < 2000; ++i) {
    const RandomContact c(random, 3 + random.index(5), 7, 0.3);
    const FrictionCone cone(2 * random.uniform() + 0.01, 0);
    const Residual r = calc_residual(c.link(), c.p, c.R, cone);
    expect_optimal(c, cone, r, 1e-9, i);
    ++faces[static_cast<int>(r.face)];
  }
  for (const ConeFace face : {ConeFace::Apex, ConeFace::Facet, ConeFace::Interior}) EXPECT_GT(faces[static_cast<int>(face)], 50);
}

TEST(Residual, FewJoints_ValueSatisfiesKkt) {
  core::Random random(3, 0);
  for (int i = 0; i < 1000; ++i) {
    const int joints = i % 3;
    RandomContact c(random, joints, 7, 0.0);
    if (joints == 0) c.tau = random_matrix(random, 7, 1);
    const FrictionCone cone(0.5, 4);
    expect_optimal(c, cone, calc_residual(c.link(), c.p, c.R, cone), 1e-9, i);
  }
}

/// The least over all sets of at most three rays, each by QR in the space of torques: one of them carries a best force (Carathéodory).
double search_rays(const RandomContact& c, const FrictionCone& cone) {
  const Eigen::MatrixXd J_T = c.J_C().transpose() * c.R * cone.ray_matrix();
  const auto n = J_T.cols();
  double best = c.tau.squaredNorm();
  const auto look = [&](const std::vector<Eigen::Index>& set) {
    const Eigen::MatrixXd columns = J_T(Eigen::all, set);
    const Eigen::VectorXd beta = columns.colPivHouseholderQr().solve(c.tau);
    if (beta.minCoeff() >= 0) best = std::min(best, (columns * beta - c.tau).squaredNorm());
  };
  for (Eigen::Index i = 0; i < n; ++i) {
    look({i});
    for (Eigen::Index j = 0; j < i; ++j) {
      look({i, j});
      for (Eigen::Index k = 0; k < j; ++k) look({i, j, k});
    }
  }
  return best;
}

TEST(Residual, RandomProblems_AgreeWithSearchOverRays) {
  core::Random random(34, 1);
  constexpr int kRays[] = {3, 4, 5, 8};
  for (int i = 0; i < 2000; ++i) {
    const RandomContact c(random, 1 + random.index(7), 7, i % 3 == 0 ? 0.0 : 0.3);
    const FrictionCone cone(0.2 + random.uniform(), kRays[i % 4]);
    EXPECT_NEAR(calc_residual(c.link(), c.p, c.R, cone).value, search_rays(c, cone), 1e-10 * c.tau.squaredNorm()) << "problem " << i;
  }
}

TEST(Residual, ManyRays_TendToTheLorentzCone) {
  core::Random random(4, 0);
  for (int i = 0; i < 500; ++i) {
    const RandomContact c(random, 7, 7, 0.3);
    const double exact = calc_residual(c.link(), c.p, c.R, FrictionCone(0.8, 0)).value;
    const double coarse = calc_residual(c.link(), c.p, c.R, FrictionCone(0.8, 4)).value;
    const double fine = calc_residual(c.link(), c.p, c.R, FrictionCone(0.8, 64)).value;
    EXPECT_LE(exact, fine + 1e-12 * c.tau.squaredNorm());  // the cones lie in each other
    EXPECT_LE(fine, coarse + 1e-12 * c.tau.squaredNorm());
    EXPECT_LE(fine - exact, 0.01 * c.tau.squaredNorm());  // 1 − cos(π/64) = 0.0012 of the tangential force
  }
}

/// Three prismatic joints along x, y and z: τ is the force, and l its squared distance from the cone.
struct Cartesian {
  Eigen::Matrix3Xd J_w = Eigen::Matrix3Xd::Zero(3, 3), J_v = Matrix3d::Identity();
  Residual at(const Vector3d& tau, const FrictionCone& cone) const {
    Matrix3d R = Matrix3d::Identity();  // contact frame along x, y, z
    return calc_residual(LinkTorque(J_w, J_v, tau), Vector3d(0.3, 0.1, 0.2), R, cone);
  }
};

TEST(Residual, CartesianRobot_IsDistanceFromTheCone) {
  const Cartesian robot;
  for (const int rays : {0, 4}) {
    const FrictionCone cone(1, rays);
    const Residual inside = robot.at({5, 1, -2}, cone);
    EXPECT_EQ(inside.face, ConeFace::Interior);
    EXPECT_NEAR(inside.value, 0, 1e-14);
    EXPECT_NEAR((inside.force_C - Vector3d(5, 1, -2)).norm(), 0, 1e-14);
    const Residual behind = robot.at({-5, 1, 0}, cone);
    EXPECT_EQ(behind.face, ConeFace::Apex);
    EXPECT_DOUBLE_EQ(behind.value, 26);
    // Beside the ray (1, 1, 0)/√2: the foot of (0, 2, 0) is (1, 1, 0), √2 away.
    const Residual beside = robot.at({0, 2, 0}, cone);
    EXPECT_EQ(beside.face, rays == 0 ? ConeFace::Facet : ConeFace::Edge);
    EXPECT_NEAR(beside.value, 2, 1e-14);
    EXPECT_NEAR((beside.force_C - Vector3d(1, 1, 0)).norm(), 0, 1e-7);
  }
  // Facet x = y + z of the four rays: the foot of (0, 3, 3) is (2, 1, 1).
  const Residual facet = robot.at({0, 3, 3}, FrictionCone(1, 4));
  EXPECT_EQ(facet.face, ConeFace::Facet);
  EXPECT_NEAR(facet.value, 12, 1e-13);
  EXPECT_NEAR((facet.force_C - Vector3d(2, 1, 1)).norm(), 0, 1e-14);
}

TEST(Residual, WithoutFriction_IsAlongTheNormal) {
  const Cartesian robot;
  for (const int rays : {0, 4, 8}) {
    const Residual r = robot.at({3, 4, 0}, FrictionCone(0, rays));
    EXPECT_DOUBLE_EQ(r.value, 16);
    EXPECT_EQ(r.force_C, Vector3d(3, 0, 0));
    EXPECT_DOUBLE_EQ(robot.at({-3, 4, 0}, FrictionCone(0, rays)).value, 25);
  }
}

TEST(Residual, Gradient_MatchesCentralDifferences) {
  core::Random random(5, 0);
  int compared = 0;
  for (int i = 0; i < 2000; ++i) {
    const RandomContact c(random, 4 + random.index(4), 7, 0.3);
    const FrictionCone cone(0.2 + random.uniform(), i % 2 == 0 ? 4 : 0);
    const LinkTorque link = c.link();
    const Residual r = calc_residual(link, c.p, c.R, cone);
    if (r.face == ConeFace::Apex) continue;  // l = ‖τ‖² there
    const Vector3d gradient = calc_gradient(link, c.p, c.R * r.force_C);
    Vector3d difference;
    const double step = 1e-5;  // cbrt of rounding
    for (int k = 0; k < 3; ++k) {
      const Vector3d e = step * Vector3d::Unit(k);
      difference[k] = (calc_residual(link, c.p + e, c.R, cone).value - calc_residual(link, c.p - e, c.R, cone).value) / (2 * step);
    }
    // Compared where ‖f‖ and so the third derivatives are of the size that they have for a force of the torque's size.
    if (r.force_C.norm() > 10 * c.tau.norm()) continue;
    EXPECT_NEAR((gradient - difference).norm(), 0, 1e-6 * (gradient.norm() + c.tau.squaredNorm())) << "problem " << i;
    ++compared;
  }
  EXPECT_GT(compared, 1000);
}

TEST(Residual, Batch_IsThatOfEachSample) {
  core::Random random(6, 0);
  for (const int rays : {0, 3, 4, 7, 8, 64}) {
    const RandomContact c(random, 6, 7, 0.2);
    const LinkTorque link = c.link();
    const FrictionCone cone(0.7, rays);
    SampleBatch batch;
    batch.resize(101);  // not a multiple of four
    for (int i = 0; i < 101; ++i)
      batch.set(i, 0.2 * random_matrix(random, 3, 1), make_contact_frame(random_matrix(random, 3, 1).normalized()));
    Eigen::VectorXd values(batch.rows.cols());
    calc_residuals(link, batch, cone, values);
    for (int i = 0; i < 101; ++i) {
      const double one = calc_residual(link, batch.p_L(i), batch.R_LC(i), cone).value;
      EXPECT_NEAR(values[i], one, 1e-13 * link.tau_tau) << rays << " rays, sample " << i;
    }
  }
}

TEST(FrictionCone, BadInput_IsNamed) {
  using stiction::test::message_of;
  EXPECT_EQ(message_of([] { FrictionCone(-1, 4); }), "friction: got -1, expected a finite number ≥ 0");
  EXPECT_EQ(message_of([] { FrictionCone(1, 2); }), "rays: got 2, expected 0 (the exact cone), or 3 to 64");
}

}  // namespace
}  // namespace stiction::sensing::test
