// Queries, distances and Jacobians use no heap after the first call. Every malloc of this program is counted.
#include <gtest/gtest.h>

#include "cone_allocations.hpp"
#include "contact/scenes.hpp"

namespace stiction::contact {
namespace {

using test::Fixture;
using test::Random;

TEST(Query, AfterTheFirstCall_NothingIsAllocated) {
  if (!bench::counts_allocations()) GTEST_SKIP() << "mallocs are not counted under sanitizers";
  ASSERT_GT(bench::allocations(), 0) << "the counter does not count";
  Fixture s(test::make_busy_scene());
  ASSERT_GT(s.model->pairs().size(), 20u);
  Random random(8);
  std::vector<Eigen::VectorXd> configurations;
  for (int i = 0; i < 200; ++i) {
    s.move_to_random(random);
    configurations.push_back(s.q);
  }
  std::vector<Contact> out, subset;
  Jacobians jacobians;
  std::vector<double> J(3 * static_cast<std::size_t>(s.model->n_v()));
  const std::vector<int> pairs = s.all_pairs();
  jacobians.values.reserve(8 * pairs.size() * J.size());  // a patch has up to eight points
  jacobians.begin.reserve(8 * pairs.size() + 1);
  double sum = 0;
  const auto everything = [&] {
    query(*s.model, s.kinematics, {.margin = 0.1}, s.work, out);
    query_pairs(*s.model, s.kinematics, pairs, 0.1, s.work, subset);
    sum += calc_min_distance(*s.model, s.kinematics, pairs, -1, s.work) + pair_distance(*s.model, s.kinematics, 0, s.work).phi;
    calc_jacobians(*s.model, s.kinematics, out, s.work, jacobians);
    for (const Contact& c : out) calc_jacobian(*s.model, s.kinematics, c, J.data());
  };
  everything();
  long inside = 0;
  for (const Eigen::VectorXd& q : configurations) {
    world::calc_kinematics(*s.model, q, s.kinematics_work, s.kinematics);
    const long before = bench::allocations();
    everything();
    inside += bench::allocations() - before;
  }
  EXPECT_EQ(inside, 0);
  EXPECT_NE(sum, 0);
}

TEST(Query, TwoBoxesInAnyPose_NothingIsAllocated) {
  if (!bench::counts_allocations()) GTEST_SKIP() << "mallocs are not counted under sanitizers";
  ASSERT_GT(bench::allocations(), 0) << "the counter does not count";
  world::Scene scene;
  scene.contact_distance = 1;
  scene.objects = {test::make_object("a", world::Box{{0.05, 0.03, 0.08}}), test::make_object("b", world::Box{{0.05, 0.06, 0.02}})};
  Fixture s(scene);
  Random random(10);
  std::vector<Contact> out;
  long inside = 0;
  int single = 0;
  for (int i = 0; i < 2000; ++i) {
    Eigen::VectorXd q = s.model->neutral();
    for (int k = 0; k < 2; ++k) {
      q.segment<3>(7 * k) = random.in_cube(0.1);
      q.segment<4>(7 * k + 3) = Eigen::Quaterniond(random.rotation()).coeffs();
    }
    s.move_to(q);
    query(*s.model, s.kinematics, {}, s.work, out);
    const long before = bench::allocations();
    query(*s.model, s.kinematics, {}, s.work, out);
    (void)pair_distance(*s.model, s.kinematics, 0, s.work);
    inside += bench::allocations() - before;
    single += out.size() == 1;
  }
  EXPECT_EQ(inside, 0);
  EXPECT_GT(single, 100) << "edges and corners";
}

}  // namespace
}  // namespace stiction::contact
