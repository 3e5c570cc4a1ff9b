#include "stiction/sensing/joint_forces.hpp"

#include <gtest/gtest.h>

#include "random_contact.hpp"

namespace stiction::sensing::test {
namespace {

ForceProblem make_problem(core::Random& random, int contacts, int rows, double prior) {
  ForceProblem out;
  out.contacts = contacts;
  out.prior = prior;
  out.tau = random_matrix(random, rows, 1);
  for (int i = 0; i < contacts; ++i) out.maps[static_cast<std::size_t>(i)] = random_matrix(random, rows, 3);
  return out;
}

TEST(JointForces, OneContact_HasTheResidualInClosedForm) {
  core::Random random(1, 0);
  ForceWorkspace work;
  ForceSolution solution;
  for (int trial = 0; trial < 500; ++trial) {
    const RandomContact c(random, 3 + trial % 5, 7, trial % 2 == 0 ? 0.0 : 0.3);
    const FrictionCone cone(0.2 + random.uniform(), 3 + trial % 6);
    ForceProblem problem;
    problem.contacts = 1;
    problem.tau = c.tau;
    problem.maps[0] = c.J_C().transpose() * c.R;
    work.forget();
    solve_forces(problem, cone, work, solution);
    EXPECT_NEAR(solution.residual, calc_residual(c.link(), c.p, c.R, cone).value, 1e-8 * c.tau.squaredNorm()) << "trial " << trial;
  }
}

TEST(JointForces, SeveralContacts_SatisfyTheConditionsOfOptimality) {
  core::Random random(2, 0);
  ForceWorkspace work;
  ForceSolution solution;
  int carried = 0;
  for (int trial = 0; trial < 600; ++trial) {
    const int contacts = 1 + trial % 3;
    const FrictionCone cone(0.3 + random.uniform(), 4);
    // Six rows and up to nine force components: forces are unique by the prior alone.
    const ForceProblem problem = make_problem(random, contacts, 6, 1e-3);
    solve_forces(problem, cone, work, solution);  // from the rays of the last problem
    Eigen::VectorXd left = -problem.tau;
    for (std::size_t i = 0; i < static_cast<std::size_t>(contacts); ++i) left += problem.maps[i] * solution.forces_C[i];
    EXPECT_NEAR(left.squaredNorm(), solution.residual, 1e-12 * problem.tau.squaredNorm());
    for (std::size_t i = 0; i < static_cast<std::size_t>(contacts); ++i) {
      const Eigen::Vector3d& f = solution.forces_C[i];
      const Eigen::Vector3d gradient = problem.maps[i].transpose() * left + problem.prior * f;
      EXPECT_TRUE(cone.contains(f, 1e-9));
      EXPECT_NEAR(gradient.dot(f), 0, 1e-8 * problem.tau.squaredNorm());
      for (const auto& ray : cone.ray_matrix().colwise()) EXPECT_GE(gradient.dot(ray), -1e-8 * problem.tau.norm() * problem.maps[i].norm());
      carried += !f.isZero(0);
    }
  }
  EXPECT_GT(carried, 600);
}

TEST(JointForces, RaysOfTheLastProblem_DoNotChangeTheSolution) {
  core::Random random(3, 0);
  ForceWorkspace warm, cold;
  ForceSolution from_last, from_nothing;
  const FrictionCone cone(0.6, 5);
  for (int trial = 0; trial < 200; ++trial) {
    const ForceProblem problem = make_problem(random, 2, 7, 1e-4);
    solve_forces(problem, cone, warm, from_last);
    cold.forget();
    solve_forces(problem, cone, cold, from_nothing);
    EXPECT_NEAR(from_last.objective, from_nothing.objective, 1e-10 * problem.tau.squaredNorm());
    for (std::size_t i = 0; i < 2; ++i)
      EXPECT_NEAR((from_last.forces_C[i] - from_nothing.forces_C[i]).norm(), 0, 1e-6 * (1 + from_nothing.forces_C[i].norm()));
  }
}

}  // namespace
}  // namespace stiction::sensing::test
