// Independent oracle: the residual (4.5b) as a quadratic program of the ray coordinates β.
#include <gtest/gtest.h>

#include <Eigen/QR>

#include "proxqp.hpp"
#include "sensing/random_contact.hpp"

namespace stiction::sensing::test {
namespace {

/// l / ‖τ‖². ProxQP says which rays carry; the value on their span is by QR, because its own is as good as its tolerance on ∇l allows.
/// Negative where it finds no solution.
double solve_qp(const RandomContact& c, const FrictionCone& cone) {
  const Eigen::MatrixXd J = cone.ray_matrix().transpose() * c.R.transpose() * c.J_C();  // J (4.5)
  const int n = cone.rays();
  const double unit = c.tau.squaredNorm();
  const auto minimiser = bench::minimise_by_proxqp({.H = 2 * J * J.transpose(),
                                                    .g = -2 * J * c.tau / std::sqrt(unit),  // of β in units of ‖τ‖
                                                    .C = Eigen::MatrixXd::Identity(n, n),
                                                    .lower = Eigen::VectorXd::Zero(n),
                                                    .upper = Eigen::VectorXd::Constant(n, 1e20)},
                                                   {.residual = 1e-12});
  if (!minimiser) return -1;
  const Eigen::VectorXd& beta = *minimiser;
  std::vector<Eigen::Index> carrying;
  for (Eigen::Index i = 0; i < n; ++i)
    if (beta[i] > 1e-6 * beta.cwiseAbs().maxCoeff()) carrying.push_back(i);
  if (beta.cwiseAbs().maxCoeff() < 1e-9) return 1;
  const Eigen::MatrixXd columns = J.transpose()(Eigen::all, carrying);
  return (columns * columns.completeOrthogonalDecomposition().solve(c.tau) - c.tau).squaredNorm() / unit;
}

TEST(ResidualOracle, RandomProblems_AgreeWithProxQp) {
  core::Random random(34, 0);
  constexpr int kRays[] = {3, 4, 5, 8, 16};
  int compared = 0;
  for (int i = 0; i < 2000; ++i) {
    const int joints = 1 + random.index(7);  // below 3 the force is not unique, the value is
    const RandomContact c(random, joints, 7, i % 3 == 0 ? 0.0 : 0.3);
    const FrictionCone cone(0.2 + random.uniform(), kRays[i % 5]);
    const double ours = calc_residual(c.link(), c.p, c.R, cone).value / c.tau.squaredNorm();
    const double theirs = solve_qp(c, cone);
    if (theirs < 0) continue;
    EXPECT_NEAR(ours, theirs, 1e-10) << "problem " << i << ", " << joints << " joints, " << cone.rays() << " rays";
    ++compared;
  }
  EXPECT_GE(compared, 1950);
}

}  // namespace
}  // namespace stiction::sensing::test
