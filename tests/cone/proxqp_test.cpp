// Independent oracle: problems of half-lines and bounds against ProxQP.
#include <gtest/gtest.h>

#include "cone/random_problem.hpp"
#include "proxqp.hpp"

namespace stiction::cone::test {
namespace {

TEST(ConeOracle, HalfLineProblems_AgreeWithProxQp) {
  RandomOptions random;
  random.cones = false;
  random.deep = 0;
  random.mass_decades = 2;
  int compared = 0;
  for (std::uint64_t seed = 1; seed <= 150; ++seed) {
    const RawProblem raw = make_random(seed, random);
    const Problem problem = raw.make();
    Workspace work(problem.layout_ptr());
    Options options;
    options.tol_complementarity = 1e-11;  // ‖x − x*‖ falls with it; 1e-9 would leave up to 1e-5
    Result r;
    if (solve(problem, options, work, r) != core::Status::Solved) continue;
    const Eigen::MatrixXd G = raw.stacked_G();
    const Eigen::VectorXd g = raw.stacked_g();
    if (G.rows() == 0) continue;
    // Scaled by the diagonal of Q, which ProxQP needs for mass ratios of 100 and a robot.
    const Eigen::VectorXd d = raw.Q.diagonal().cwiseSqrt().cwiseInverse();
    const bench::QuadraticProgram scaled{.H = d.asDiagonal() * raw.Q * d.asDiagonal(),
                                         .g = d.cwiseProduct(raw.b),
                                         .C = G * d.asDiagonal(),
                                         .lower = -g,
                                         .upper = Eigen::VectorXd::Constant(G.rows(), 1e20)};
    const auto minimiser = bench::minimise_by_proxqp(scaled, {.residual = 1e-12});
    if (!minimiser) continue;
    const Eigen::VectorXd x = d.cwiseProduct(*minimiser);
    // In the metric of Q, in which the minimiser is unique and equally conditioned.
    const Eigen::VectorXd error = (r.x - x).cwiseQuotient(d);
    EXPECT_LE(error.norm(), 1e-6 * std::max(1.0, x.cwiseQuotient(d).norm())) << "seed " << seed;
    ++compared;
  }
  EXPECT_GT(compared, 75);
}

}  // namespace
}  // namespace stiction::cone::test
