// Independent oracle: the structured QP against ProxQP on the same problem with the states eliminated.
#include <gtest/gtest.h>

#include <optional>

#include "proxqp.hpp"
#include "trajopt/random_lq.hpp"

namespace stiction::trajopt::test {
namespace {

/// Minimum by ProxQP; nullopt where it gives up.
std::optional<double> minimum(const Condensed& qp) {
  const auto N = qp.h.size();
  const auto rows = qp.C.rows() + N;
  bench::QuadraticProgram program{.H = qp.H, .g = qp.h};
  program.C.resize(rows, N);
  program.C << qp.C, Eigen::MatrixXd::Identity(N, N);
  program.lower.resize(rows);
  program.lower << -qp.c, qp.lower;
  program.upper.resize(rows);
  program.upper << Eigen::VectorXd::Constant(qp.c.size(), 1e20), qp.upper;
  const auto minimiser = bench::minimise_by_proxqp(program, {.residual = 1e-10});
  if (!minimiser) return {};
  return qp.cost(*minimiser);
}

void compare(int rows) {
  int compared = 0, at_bounds = 0, at_rows = 0;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    const int n = 2 + static_cast<int>(seed % 7), m = 1 + static_cast<int>(seed % 4), T = 1 + static_cast<int>(seed % 9);
    const BoxLqProblem problem = random_problem(seed, n, m, T, rows);
    BoxLqWorkspace work;
    BoxLqResult out;
    ASSERT_EQ(solve_box_lq(problem, {.tolerance = 1e-8}, work, out), core::Status::Solved) << "seed " << seed;
    const Condensed qp(problem);
    const Eigen::VectorXd u = stacked(out.u);
    const double scale = std::max(1.0, std::abs(qp.constant));
    EXPECT_NEAR(out.cost, qp.cost(u), 1e-11 * scale) << "seed " << seed;
    EXPECT_TRUE(((u - qp.lower).array() >= 0).all() && ((qp.upper - u).array() >= 0).all());
    if (rows > 0) {
      EXPECT_GE((qp.C * u + qp.c).minCoeff(), -1e-9) << "seed " << seed;
      at_rows += (qp.C * u + qp.c).minCoeff() < 1e-6;
    }
    at_bounds += std::min((u - qp.lower).minCoeff(), (qp.upper - u).minCoeff()) < 1e-6;
    const auto best = minimum(qp);
    if (!best) continue;
    ++compared;
    EXPECT_LE(out.cost, *best + 1e-8 + 1e-10 * scale) << "seed " << seed;
    EXPECT_NEAR(out.cost, *best, 1e-6 * scale) << "seed " << seed;  // ProxQP stops by residuals: its cost may be this much too high
  }
  EXPECT_GT(compared, 50);
  EXPECT_GT(at_bounds, 40) << "the boxes are never felt";
  if (rows > 0) {
    EXPECT_GT(at_rows, 30) << "the rows are never felt";
  }
}

TEST(BoxLqOracle, Boxes_AgreeWithProxQp) { compare(0); }
TEST(BoxLqOracle, BoxesAndRows_AgreeWithProxQp) { compare(3); }

}  // namespace
}  // namespace stiction::trajopt::test
