// Independent oracle: the bounded program with its slacks as variables, by ProxQP.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include "control/random_qp.hpp"
#include "proxqp.hpp"

namespace stiction::control::test {
namespace {

using Eigen::Index;

TEST(BoundedQpOracle, RandomPrograms_AgreeWithProxQp) {
  core::Random random(11, 0);
  BoundedQpWorkspace work;
  BoundedQpResult out;
  int compared = 0, felt = 0;
  for (int trial = 0; trial < 400; ++trial) {
    const Index n = 2 + random.index(8), m = 1 + random.index(5);
    BoundedQp qp = random_qp(random, n, m, trial % 2 == 0);
    qp.priority.setConstant(1e3);  // ProxQP stops by residuals, which large weights multiply
    ASSERT_EQ(solve_bounded_qp(qp, {}, work, out), core::Status::Solved);
    const Eigen::VectorXd soft = softness(qp);
    // Variables (x, s √ω): rows A x − s ≤ b.
    Eigen::MatrixXd H = Eigen::MatrixXd::Identity(n + m, n + m), C = Eigen::MatrixXd::Zero(m + n, n + m);
    H.topLeftCorner(n, n) = hessian(qp);
    Eigen::VectorXd g = Eigen::VectorXd::Zero(n + m), low(m + n), high(m + n);
    g.head(n) = -hessian(qp) * qp.center;
    C.topLeftCorner(m, n) = qp.A.topRows(m);
    C.topRightCorner(m, m) = -Eigen::MatrixXd(soft.cwiseSqrt().asDiagonal());
    C.bottomLeftCorner(n, n).setIdentity();
    low << Eigen::VectorXd::Constant(m, -1e20), qp.lower;
    high << qp.b.head(m), qp.upper;
    const double eps = 1e-10;
    const auto minimiser = bench::minimise_by_proxqp({.H = H, .g = g, .C = C, .lower = low, .upper = high}, {.residual = eps});
    if (!minimiser) continue;
    ++compared;
    felt += out.y.head(m).maxCoeff() > 1e-6;
    // Of a point whose stationarity and bounds are broken by ε, strong convexity (μ) says: ‖Δx‖ ≤ ε√n/μ + √(2 ε ‖(y, z)‖₁ / μ).
    const double mu = std::min(1.0, Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(hessian(qp)).eigenvalues()[0]);
    const double multipliers = out.y.head(m).lpNorm<1>() + out.z.lpNorm<1>() + out.y.head(m).dot(soft.cwiseSqrt());
    const double bound = eps * std::sqrt(n) / mu + std::sqrt(2 * eps * multipliers / mu);
    EXPECT_LE((minimiser->head(n) - out.x).norm(), bound + eps) << trial;
  }
  EXPECT_GT(compared, 300);
  EXPECT_GT(felt, 150) << "rows are never felt";
}

}  // namespace
}  // namespace stiction::control::test
