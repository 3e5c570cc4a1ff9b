#include "stiction/sensing/descent.hpp"

#include <gtest/gtest.h>

#include "sensing/robots.hpp"
#include "stiction/sensing/known_contacts.hpp"
#include "stiction/sensing/sense.hpp"

namespace stiction::sensing::test {
namespace {

using Eigen::Vector3d;

enum class End {
  Converged,
  Stuck,
  AllSteps
};

/// Algorithm 4 as the thesis writes it, to its last step whatever happens on the way.
End descend_to_the_end(const DescentProblem& problem, const SteepestDescent& options, ContactPoint& point) {
  const double size = problem.link.surface.size, tau_tau = problem.torque.tau_tau, start = point.residual;
  for (int step = 0; step < options.max_steps; ++step) {
    const Vector3d g = 0.5 * calc_gradient(problem.torque, point.p_L, point.f_L), t = g - point.n_L * point.n_L.dot(g);
    const bool settled =
        point.residual <= problem.tolerance * problem.tolerance * tau_tau || t.norm() <= options.tol_gradient * tau_tau / size;
    if (settled) return step == 0 || point.residual < start ? End::Converged : End::Stuck;
    double a = std::min(options.max_step * size / t.norm(), 1.0);
    for (int tries = 0;; ++tries, a *= options.backtrack) {
      if (tries > options.max_backtracks) return End::Stuck;
      const double l = calc_residual(problem.torque, point.p_L - a * t, make_contact_frame(point.n_L), problem.cone).value;
      if (0.5 * l < 0.5 * point.residual - options.armijo * a * t.squaredNorm()) break;
    }
    const ContactPoint next = retract(problem, point.p_L - a * t, point.triangle);
    if ((next.p_L - (point.p_L - a * t)).norm() > options.max_step * size) return End::Stuck;
    point = next;
  }
  return End::AllSteps;
}

TEST(SteepestDescent, StepsThatGoBackAndForth_AreGivenUpWhereAllOfThemEndNowhere) {
  const auto sensor = Sensor::make(make_arm(kUr5));
  const FrictionCone cone(1, 4);
  std::vector<int> links;
  for (int i = 0; i < static_cast<int>(sensor->links().size()); ++i)
    if (sensor->links()[static_cast<std::size_t>(i)].joints >= 5) links.push_back(i);
  core::Random random(3, 0);
  int converged = 0, all_steps = 0;
  for (int i = 0; i < 20; ++i) {
    const KnownCase c = make_random_case(*sensor, links, cone, 10, random);
    world::KinematicsWorkspace work(sensor->model());
    world::Kinematics kinematics;
    world::calc_kinematics(sensor->model(), c.q, work, kinematics);
    for (const int index : links) {
      const SensedLink& link = sensor->links()[static_cast<std::size_t>(index)];
      Eigen::Matrix3Xd J_w, J_v;
      calc_link_jacobian(sensor->model(), kinematics, link.surface.body, J_w, J_v);
      const LinkTorque torque(J_w, J_v, c.tau);
      const DescentProblem problem{link, index, torque, cone, Normals::Flat, SenseOptions{}.tolerance};
      for (int s = 0; s < static_cast<int>(link.samples.size()); s += 10) {
        const SurfacePoint& sample = link.samples[static_cast<std::size_t>(s)];
        ContactPoint point = evaluate(problem, sample.triangle, sample.p_L), expected = point;
        const End end = descend_to_the_end(problem, {}, expected);
        EXPECT_EQ(descend(problem, SteepestDescent{}, point), end == End::Converged)
            << "case " << i << ", link " << index << ", sample " << s;
        if (end == End::Converged) {
          EXPECT_LT((point.p_L - expected.p_L).norm(), 1e-9 * link.surface.size);
        }
        converged += end == End::Converged;
        all_steps += end == End::AllSteps;
      }
    }
  }
  EXPECT_GT(converged, 1000);
  EXPECT_GT(all_steps, 100) << "no descent that goes back and forth: the test says nothing";
}

}  // namespace
}  // namespace stiction::sensing::test
