#include <gtest/gtest.h>

#include <Eigen/LU>
#include <optional>

#include "control/random_qp.hpp"

namespace stiction::control::test {
namespace {

using core::Status;
using Eigen::Index;

BoundedQp plane(double b) {  // x̂ = (1, 1), x₀ + x₁ ≤ b, box [−2, 2]²
  BoundedQp qp;
  qp.reserve(2, 1);
  qp.H.setIdentity();
  qp.diagonal = true;
  qp.center.setOnes();
  qp.lower.setConstant(-2), qp.upper.setConstant(2);
  qp.A.setOnes();
  qp.b[0] = b;
  qp.priority[0] = 1e8;
  qp.m = 1;
  return qp;
}

TEST(BoundedQp, OneRow_ProjectsOntoTheHalfPlane) {
  for (const bool closed_form : {true, false}) {
    BoundedQpWorkspace work;
    BoundedQpResult out;
    ASSERT_EQ(solve_bounded_qp(plane(1), {.closed_form = closed_form}, work, out), Status::Solved);
    EXPECT_NEAR(out.x[0], 0.5, 1e-8);  // priority 1e8: 1e-8 of the violation 1 is left
    EXPECT_NEAR(out.x[1], 0.5, 1e-8);
    EXPECT_NEAR(out.slack[0], 1 / (1 + 1e8), 1e-16);
    EXPECT_NEAR(out.y[0], 0.5, 1e-8);
  }
}

TEST(BoundedQp, RowAgainstBox_BoxHoldsAndSlackIsWhatIsMissing) {
  for (const bool closed_form : {true, false}) {
    BoundedQpWorkspace work;
    BoundedQpResult out;
    ASSERT_EQ(solve_bounded_qp(plane(-5), {.closed_form = closed_form}, work, out), Status::Solved);
    EXPECT_EQ(out.x[0], -2);
    EXPECT_EQ(out.x[1], -2);
    EXPECT_NEAR(out.slack[0], 1, 1e-12);
  }
}

TEST(BoundedQp, RowWithoutEffect_TracksExactly) {
  BoundedQpWorkspace work;
  BoundedQpResult out;
  ASSERT_EQ(solve_bounded_qp(plane(3), {}, work, out), Status::Solved);
  EXPECT_EQ(out.x[0], 1);
  EXPECT_EQ(out.y[0], 0);
  EXPECT_EQ(out.slack[0], 0);
}

TEST(BoundedQp, NotPositiveDefinite_IsSaid) {
  BoundedQp qp = plane(1);
  qp.H(1, 1) = 0;
  BoundedQpWorkspace work;
  BoundedQpResult out;
  EXPECT_EQ(solve_bounded_qp(qp, {}, work, out), Status::NumericalFailure);
  qp.diagonal = false;
  qp.H(1, 1) = -1;
  EXPECT_EQ(solve_bounded_qp(qp, {}, work, out), Status::NumericalFailure);
}

TEST(BoundedQp, LimitOfIterations_IsSaidAndTheBoxHolds) {
  core::Random random(5, 0);
  const BoundedQp qp = random_qp(random, 7, 3, false);
  BoundedQpWorkspace work;
  BoundedQpResult out;
  ASSERT_EQ(solve_bounded_qp(qp, {}, work, out), Status::Solved);
  ASSERT_GT(out.iterations, 1) << "the limit would not be felt";
  EXPECT_EQ(solve_bounded_qp(qp, {.max_iterations = 1}, work, out), Status::MaxIterations);
  EXPECT_TRUE(((out.x - qp.lower).array() >= 0).all() && ((qp.upper - out.x).array() >= 0).all());
}

/// Minimum over every set of active bounds and rows: each gives a linear system.
double brute_force(const BoundedQp& qp, Eigen::VectorXd& best) {
  const Index n = qp.center.size(), m = qp.m, N = n + m;
  const Eigen::VectorXd softness_of = softness(qp);
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(N, N);
  H.topLeftCorner(n, n) = hessian(qp);
  for (Index i = 0; i < m; ++i) H(n + i, n + i) = 1;  // of s √ω
  Eigen::VectorXd g = Eigen::VectorXd::Zero(N);
  g.head(n) = -hessian(qp) * qp.center;
  int sets = 1;
  for (Index k = 0; k < n; ++k) sets *= 3;
  for (Index k = 0; k < m; ++k) sets *= 2;
  double least = std::numeric_limits<double>::infinity();
  for (int set = 0; set < sets; ++set) {
    std::vector<std::pair<Eigen::VectorXd, double>> equalities;
    int code = set;
    for (Index j = 0; j < n; ++j, code /= 3)
      if (code % 3 > 0) equalities.emplace_back(Eigen::VectorXd::Unit(N, j), code % 3 == 1 ? qp.lower[j] : qp.upper[j]);
    for (Index i = 0; i < m; ++i, code /= 2) {
      if (code % 2 == 0) continue;
      Eigen::VectorXd row = Eigen::VectorXd::Zero(N);
      row.head(n) = qp.A.row(i);
      row[n + i] = -std::sqrt(softness_of[i]);
      equalities.emplace_back(row, qp.b[i]);
    }
    const auto E = static_cast<Index>(equalities.size());
    Eigen::MatrixXd KKT = Eigen::MatrixXd::Zero(N + E, N + E);
    Eigen::VectorXd rhs(N + E);
    KKT.topLeftCorner(N, N) = H;
    rhs.head(N) = -g;
    for (Index e = 0; e < E; ++e) {
      KKT.col(N + e).head(N) = KKT.row(N + e).head(N) = equalities[static_cast<std::size_t>(e)].first;
      rhs[N + e] = equalities[static_cast<std::size_t>(e)].second;
    }
    const Eigen::VectorXd solution = KKT.fullPivLu().solve(rhs);
    const Eigen::VectorXd x = solution.head(n), s = solution.segment(n, m).cwiseProduct(softness_of.cwiseSqrt());
    const double slip = 1e-9 * (1 + solution.cwiseAbs().head(N).maxCoeff());
    bool feasible = (KKT * solution - rhs).cwiseAbs().maxCoeff() < 1e-6 * (1 + rhs.cwiseAbs().maxCoeff());
    feasible = feasible && ((x - qp.lower).array() > -slip).all() && ((qp.upper - x).array() > -slip).all();
    for (Index i = 0; i < m; ++i) feasible = feasible && qp.A.row(i).dot(x) - s[i] <= qp.b[i] + slip * (1 + qp.A.row(i).norm());
    const double cost = 0.5 * (x - qp.center).dot(hessian(qp) * (x - qp.center)) + 0.5 * s.dot(softness_of.cwiseInverse().cwiseProduct(s));
    if (feasible && cost < least) least = cost, best = x;
  }
  return least;
}

TEST(BoundedQpOracle, SmallPrograms_AgreeWithAllActiveSets) {
  core::Random random(1, 0);
  BoundedQpWorkspace work;
  BoundedQpResult out;
  int active = 0;
  for (int trial = 0; trial < 600; ++trial) {
    const Index n = 1 + random.index(3), m = random.index(4);
    BoundedQp qp = random_qp(random, n, m, trial % 2 == 0);
    qp.priority.setConstant(1e4);  // the linear systems of the oracle are worse off than those of the method
    work.reserve(n, m);
    ASSERT_EQ(solve_bounded_qp(qp, {}, work, out), Status::Solved) << trial;
    Eigen::VectorXd best;
    const double least = brute_force(qp, best);
    ASSERT_TRUE(std::isfinite(least)) << trial;
    const Eigen::VectorXd s = out.slack.head(m);
    const double cost =
        0.5 * (out.x - qp.center).dot(hessian(qp) * (out.x - qp.center)) + 0.5 * s.dot(softness(qp).cwiseInverse().cwiseProduct(s));
    EXPECT_NEAR(cost, least, 1e-6 * (1 + least)) << trial;
    active += m > 0 && out.y.head(m).maxCoeff() > 0;
  }
  EXPECT_GT(active, 150) << "rows are never felt";
}

TEST(BoundedQpProperty, RandomPrograms_MeetTheOptimalityConditions) {
  core::Random random(2, 0);
  BoundedQpWorkspace work;
  BoundedQpResult out;
  int most_iterations = 0, rows_felt = 0, conflicts = 0;
  for (int trial = 0; trial < 6000; ++trial) {
    const Index n = 1 + random.index(10), m = random.index(9);
    const BoundedQp qp = random_qp(random, n, m, trial % 2 == 0);
    ASSERT_EQ(solve_bounded_qp(qp, {}, work, out), Status::Solved) << trial;
    ASSERT_LE(kkt_residual(qp, out), 1e-8) << trial;
    most_iterations = std::max(most_iterations, out.iterations);
    rows_felt += m > 0 && out.y.head(m).maxCoeff() > 0;
    conflicts += m > 0 && out.slack.head(m).maxCoeff() > 1e-3;
  }
  EXPECT_GT(rows_felt, 2000);
  EXPECT_GT(conflicts, 1000);
  EXPECT_LT(most_iterations, 60);
}

TEST(BoundedQpProperty, OneRow_ClosedFormAgreesWithTheActiveSet) {
  core::Random random(3, 0);
  BoundedQpWorkspace work;
  BoundedQpResult closed, general;
  for (int trial = 0; trial < 4000; ++trial) {
    const BoundedQp qp = random_qp(random, 1 + random.index(8), 1, true);
    ASSERT_EQ(solve_bounded_qp(qp, {}, work, closed), Status::Solved);
    ASSERT_EQ(solve_bounded_qp(qp, {.closed_form = false}, work, general), Status::Solved);
    ASSERT_LE((closed.x - general.x).cwiseAbs().maxCoeff(), 1e-9) << trial;
    ASSERT_LE(kkt_residual(qp, closed), 1e-8) << trial;
  }
}

TEST(BoundedQpProperty, TwoSidesOfARow_ClosedFormAgreesWithTheActiveSet) {
  core::Random random(4, 0);
  BoundedQpWorkspace work;
  BoundedQpResult closed, general;
  int upper = 0, lower = 0, contradict = 0;
  for (int trial = 0; trial < 4000; ++trial) {
    BoundedQp qp = random_qp(random, 1 + random.index(8), 2, true);
    qp.A.row(1) = -qp.A.row(0);
    if (random.chance(0.8)) qp.b[1] = std::abs(qp.b[1]) - qp.b[0];  // else as they come: sides that contradict each other
    ASSERT_EQ(solve_bounded_qp(qp, {}, work, closed), Status::Solved);
    ASSERT_EQ(solve_bounded_qp(qp, {.closed_form = false}, work, general), Status::Solved);
    ASSERT_LE((closed.x - general.x).cwiseAbs().maxCoeff(), 1e-9) << trial;
    ASSERT_LE(kkt_residual(qp, closed), 1e-8) << trial;
    upper += closed.y[0] > 0, lower += closed.y[1] > 0, contradict += qp.b[0] + qp.b[1] < 0;
  }
  EXPECT_GT(upper, 500);
  EXPECT_GT(lower, 500);
  EXPECT_GT(contradict, 100);
}

}  // namespace
}  // namespace stiction::control::test
