#include "stiction/sensing/discriminate.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "sensing/robots.hpp"
#include "stiction/core/random.hpp"
#include "support/message_of.hpp"

namespace stiction::sensing::test {
namespace {

using Eigen::Matrix3Xd;
using Eigen::Vector3d;
using Eigen::VectorXd;

struct Problem {
  Matrix3Xd normals;
  std::vector<Matrix3Xd> jacobians;
};

/// Contacts anywhere on links of a random arm.
Problem random_problem(core::Random& random, int contacts, int joints) {
  Problem out;
  Matrix3Xd axes(3, joints), origins(3, joints);
  for (int j = 0; j < joints; ++j) {
    axes.col(j) = Vector3d(random.normal(), random.normal(), random.normal()).normalized();
    origins.col(j) = Vector3d(0, 0, 0.2 * j) + 0.05 * Vector3d(random.normal(), random.normal(), random.normal());
  }
  out.normals.resize(3, contacts);
  for (int i = 0; i < contacts; ++i) {
    out.normals.col(i) = Vector3d(random.normal(), random.normal(), random.normal()).normalized();
    const int moved = std::max(2, joints - random.index(3));
    const Vector3d p = Vector3d(0, 0, 0.2 * moved) + 0.1 * Vector3d(random.normal(), random.normal(), random.normal());
    Matrix3Xd J = Matrix3Xd::Zero(3, joints);
    for (int j = 0; j < moved; ++j) J.col(j) = Vector3d(axes.col(j)).cross(p - origins.col(j));
    out.jacobians.push_back(J);
  }
  return out;
}

constexpr double kTravel = 0.03;

/// Whether x keeps all rows, to rounding.
bool satisfies(const LinearRows& rows, const VectorXd& x) {
  const VectorXd Cx = rows.C * x;
  return ((rows.lower - Cx).array() <= 1e-8).all() && ((Cx - rows.upper).array() <= 1e-8).all();
}

/// Whether the weights prove that the rows have no point in the box |x| ≤ 1, whatever rounding left of Cᵀy.
bool refutes(const LinearRows& rows, const VectorXd& y) {
  const double bound = y.cwiseMax(0).dot(rows.lower) + y.cwiseMin(0).dot(rows.upper);
  return bound > (rows.C.transpose() * y).lpNorm<1>();
}

TEST(Feasible, RandomRows_HaveAPointOrAProofThatThereIsNone) {
  core::Random random(1, 0);
  int feasible = 0;
  for (int i = 0; i < 1000; ++i) {
    const Problem p = random_problem(random, 2 + random.index(8), 3 + random.index(5));
    std::vector<int> signs(p.jacobians.size());
    for (int& sign : signs) sign = random.index(3) - 1;
    const LinearRows rows = make_rows(p.normals, p.jacobians, kTravel, {}, signs);
    const Feasibility found = find_feasible(rows);
    if (found.feasible) {
      EXPECT_TRUE(satisfies(rows, found.x)) << "problem " << i;
    } else {
      EXPECT_TRUE(refutes(rows, found.weights)) << "problem " << i;
    }
    feasible += found.feasible;
  }
  EXPECT_GT(feasible, 100);
  EXPECT_LT(feasible, 900);
}

/// The least objective over all 2^N signs, each shown to have a motion or not to have one; −1: none.
int search_signs(const Problem& p, const DiscriminationOptions& options, int problem) {
  const int n = static_cast<int>(p.jacobians.size());
  int best = -1;
  for (int mask = 0; mask < 1 << n; ++mask) {
    std::vector<int> signs(static_cast<std::size_t>(n));
    int sum = 0;
    for (int i = 0; i < n; ++i) sum += signs[static_cast<std::size_t>(i)] = (mask >> i) & 1;
    if (n > 1 && (sum == 0 || sum == n)) continue;
    const LinearRows rows = make_rows(p.normals, p.jacobians, kTravel, options, signs);
    const Feasibility found = find_feasible(rows);
    EXPECT_TRUE(found.feasible ? satisfies(rows, found.x) : refutes(rows, found.weights)) << "problem " << problem;
    if (found.feasible && (best < 0 || std::abs(sum - n / 2) < best)) best = std::abs(sum - n / 2);
  }
  return best;
}

TEST(Discriminate, RandomContacts_AgreeWithAllSigns) {
  core::Random random(2, 0);
  int solved = 0, infeasible = 0;
  for (int i = 0; i < 300; ++i) {
    const int n = 1 + random.index(7);
    const Problem p = random_problem(random, n, 3 + random.index(5));
    DiscriminationOptions options;
    options.sideways = 0.3 + random.uniform();
    Discrimination out;
    const core::Status status = discriminate(p.normals, p.jacobians, kTravel, options, out);
    const int best = search_signs(p, options, i);
    EXPECT_EQ(status == core::Status::Solved, best >= 0) << "problem " << i;
    if (status == core::Status::Solved) {
      EXPECT_EQ(out.objective, best) << "problem " << i;
      const LinearRows rows = make_rows(p.normals, p.jacobians, kTravel, options, out.pull);
      EXPECT_TRUE(satisfies(rows, out.dq / options.joint_step)) << "problem " << i;
      ++solved;
      continue;
    }
    ++infeasible;
    for (const RefutedSigns& refuted : out.certificate)
      EXPECT_TRUE(refutes(make_rows(p.normals, p.jacobians, kTravel, options, refuted.signs), refuted.weights)) << "problem " << i;
    for (int mask = 1; mask < (1 << n) - 1; ++mask) {  // each informative b is in a refuted set
      const bool covered = std::any_of(out.certificate.begin(), out.certificate.end(), [&](const RefutedSigns& refuted) {
        for (int k = 0; k < n; ++k) {
          const int sign = refuted.signs[static_cast<std::size_t>(k)];
          if (sign >= 0 && sign != ((mask >> k) & 1)) return false;
        }
        return true;
      });
      EXPECT_TRUE(covered) << "problem " << i << ", signs " << mask;
    }
  }
  EXPECT_GT(solved, 20);
  EXPECT_GT(infeasible, 20);
}

TEST(Discriminate, OppositePointsOfASlider_CannotBeLeftTogether) {
  // One joint along x; contacts on its two ends: moving away from one is moving into the other.
  Problem p;
  p.normals.resize(3, 2);
  p.normals << 1, -1, 0, 0, 0, 0;
  p.jacobians.assign(2, Vector3d::UnitX());
  Discrimination out;
  ASSERT_EQ(discriminate(p.normals, p.jacobians, kTravel, {}, out), core::Status::Solved);
  EXPECT_EQ(out.objective, 0);
  EXPECT_EQ(out.pull[0] + out.pull[1], 1);
  EXPECT_EQ(out.pull[0] == 1, out.dq[0] < 0);
  // Both on the same end: every motion treats them alike.
  p.normals.col(1) = p.normals.col(0);
  EXPECT_EQ(discriminate(p.normals, p.jacobians, kTravel, {}, out), core::Status::Infeasible);
  EXPECT_FALSE(out.certificate.empty());
}

TEST(Discriminate, BadInput_IsNamed) {
  Discrimination out;
  const auto with = [&](DiscriminationOptions options) {
    return stiction::test::message_of([&] { (void)discriminate(Matrix3Xd(3, 0), {}, kTravel, options, out); });
  };
  EXPECT_EQ(with({}), "candidates: got none, expected at least one");
  DiscriminationOptions wrong;
  wrong.joint_step = 0;
  EXPECT_EQ(with(wrong), "joint_step: got 0, expected a finite number > 0");
}

}  // namespace
}  // namespace stiction::sensing::test
