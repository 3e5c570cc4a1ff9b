#include "stiction/contact/clearance.hpp"

#include <gtest/gtest.h>

#include "stiction/contact/free_path.hpp"
#include "stiction/world/read.hpp"
#include "stiction/world/scales.hpp"

namespace stiction::contact::test {
namespace {

/// A trolley on a rail beside a wall that is 0.4 mm away all along it, and a ball of 0.1 m as what gives the scene its length.
std::shared_ptr<const world::Model> make_trolley() {
  return world::Model::make(world::parse_scene(R"(
robots:
  - name: r
    stiffness: 100
    urdf: |
      <robot name="r"><link name="base"/><link name="cart"><collision><geometry><box size="0.1 0.1 0.1"/></geometry></collision></link>
      <joint name="x" type="prismatic"><parent link="base"/><child link="cart"/><axis xyz="1 0 0"/><limit lower="-1" upper="1" effort="10"/></joint></robot>
objects: [{name: ball, joint: free, mass: 1, shapes: [{sphere: {radius: 0.05}}]}]
fixed: [{name: wall, shapes: [{box: {size: [3, 0.1, 0.1]}, pose: {position: [0, 0.1004, 0]}}]}]
)",
                                               "."));
}

Eigen::VectorXd at(const world::Model& model, double x) {
  Eigen::VectorXd q = model.neutral();
  q.head<3>() << 0, 0, 5;
  q[7] = x;
  return q;
}

TEST(Clearance, LinksThatNearlyTouchAtRest_KeepHalfOfTheirGap) {
  const auto model = make_trolley();
  Workspace work(*model);
  const auto close = find_close_pairs(*model, work);
  ASSERT_EQ(close.size(), 1u);
  EXPECT_NEAR(close[0].gap, 4e-4, 1e-9);
  EXPECT_NEAR(close[0].clearance(), 2e-4, 1e-9);
  const std::vector<int> pairs{0, 1, 2};
  ASSERT_EQ(model->pairs().size(), 3u) << "ball and cart, ball and wall, cart and wall";
  const PairClearances split = split_by_clearance(*model, pairs, 2e-3, work);
  EXPECT_EQ(split.pairs.size(), 2u);
  ASSERT_EQ(split.close.size(), 1u);
  EXPECT_EQ(split_by_clearance(*model, pairs, 1e-4, work).close.size(), 0u) << "others keep less than it";
}

/// Without a clearance of its own no posture is free, as the wall is nearer than others may be.
TEST(Clearance, PathAlongAWall_IsFound) {
  const auto model = make_trolley();
  const world::RobotChains chains(*model);
  GeometryWorkspace work(*model);
  core::Random random(1, 0);
  std::vector<Eigen::VectorXd> path;
  const double clearance = world::share::kClearance * model->scales().robots().length;
  ASSERT_GT(clearance, 1e-3);
  const PathOptions options{.clearance = clearance};
  EXPECT_EQ(find_path(*model, chains, chains.all(), at(*model, -0.5), Eigen::VectorXd::Constant(1, 0.5), options, random, work, path),
            PathOutcome::Found);
}

/// The ball in the way is still kept at the whole clearance.
TEST(Clearance, OtherPairs_KeepTheWholeOfIt) {
  const auto model = make_trolley();
  const world::RobotChains chains(*model);
  GeometryWorkspace work(*model);
  core::Random random(1, 0);
  std::vector<Eigen::VectorXd> path;
  Eigen::VectorXd q = at(*model, -0.5);
  q.head<3>() << 0, 0, 0.1 + 1e-3;  // 1 mm above the cart's way
  const PathOptions options{.clearance = 2e-3};
  EXPECT_EQ(find_path(*model, chains, chains.all(), q, Eigen::VectorXd::Constant(1, 0.5), options, random, work, path),
            PathOutcome::NotFound);
}

}  // namespace
}  // namespace stiction::contact::test
