// The robot steps back from what stands by itself, and from nothing else.
#include "stiction/execution/closed_loop/step_back.hpp"

#include "dynamics/systems.hpp"
#include "stiction/contact/geometry_workspace.hpp"
#include "stiction/world/robot_chains.hpp"
#include "stiction/world/scales.hpp"

namespace stiction::execution::test {
namespace {

using dynamics::test::ball;
using dynamics::test::half_space;
using dynamics::test::pusher;
using Eigen::VectorXd;

/// A ball of radius 0.1 m at y = 0.2 m, and the pusher, a ball of the same size that moves along y and z.
std::shared_ptr<const world::Model> scene_of(double ground) {
  world::Scene scene = dynamics::test::empty_scene();
  scene.gravity = {0, 0, -9.81};
  scene.objects.push_back(ball(world::ObjectJoint::Free, 1, 0.1, 1));
  scene.robots.push_back(pusher());
  scene.fixed.push_back(half_space(Eigen::Vector3d::UnitZ(), {0, 0, ground}, 1));
  return world::Model::make(scene);
}

VectorXd configuration(const world::Model& model, double y) {
  VectorXd q = model.neutral();
  q[1] = 0.2;
  q[model.n_qu()] = y;
  return q;
}

double least_gap(const world::Model& model, const VectorXd& q) {
  contact::GeometryWorkspace work(model);
  world::calc_kinematics(model, q, work.kinematics_work, work.kinematics);
  std::vector<int> pairs;
  const world::RobotChains chains(model);
  chains.pairs_of(chains.all(), pairs);
  double least = 1;
  for (const int pair : pairs)
    if (chains.touches_object(pair)) least = std::min(least, contact::pair_distance(model, work.kinematics, pair, work.contact_work).phi);
  return least;
}

/// The robot touches at q, and leaves a gap.
void expect_gap(const world::Model& model, VectorXd q) {
  ASSERT_NEAR(least_gap(model, q), 0, 1e-6);
  const auto path = find_step_back(model, q);
  ASSERT_FALSE(path.empty());
  q.tail(model.n_a()) = path.back();
  EXPECT_GT(least_gap(model, q), 0.09 * model.scales().robots().length);
}

TEST(StepBack, FromWhatStands_LeavesAGap) {
  const auto model = scene_of(-0.1);
  expect_gap(*model, configuration(*model, 0.0));
}

TEST(StepBack, FromWhatItHolds_OrWhatItDoesNotTouch_IsNone) {
  const auto above = scene_of(-0.5);  // nothing but the robot is near the ball
  EXPECT_TRUE(find_step_back(*above, configuration(*above, 0.0)).empty());
  const auto model = scene_of(-0.1);
  EXPECT_TRUE(find_step_back(*model, configuration(*model, -0.05)).empty());
}

TEST(TouchesObjects, RobotsAloneCount) {
  const auto model = scene_of(-0.1);  // the ball touches the ground
  EXPECT_TRUE(touches_objects(*model, configuration(*model, 0.0)));
  EXPECT_FALSE(touches_objects(*model, configuration(*model, -0.05)));
}

/// A slide along y in place of the free ball, alone or on another object above the ground.
std::shared_ptr<const world::Model> slide_scene(bool on_object) {
  world::Scene scene = dynamics::test::empty_scene();
  scene.gravity = {0, 0, -9.81};
  if (on_object) {
    scene.objects.push_back(ball(world::ObjectJoint::Free, 1, 0.01, 1));
    scene.objects.back().name = "carrier";
  }
  scene.objects.push_back(ball(world::ObjectJoint::Slider, 1, 0.1, 1));
  scene.objects.back().axis = Eigen::Vector3d::UnitY();
  if (on_object) scene.objects.back().parent = "carrier";
  scene.robots.push_back(pusher());
  return world::Model::make(scene);
}

TEST(StepBack, FromWhatAJointKeeps_LeavesAGap) {
  const auto model = slide_scene(false);
  VectorXd q = model->neutral();
  q[0] = 0.2;
  expect_gap(*model, q);
}

TEST(StepBack, FromAJointOfWhatWouldFall_IsNone) {
  const auto model = slide_scene(true);
  VectorXd q = model->neutral();
  q[2] = 0.5;               // the carrier is above the pusher …
  q[model->n_qu()] = -0.2;  // … which touches what slides on it
  q[model->n_qu() + 1] = 0.5;
  ASSERT_NEAR(least_gap(*model, q), 0, 1e-6);
  EXPECT_TRUE(find_step_back(*model, q).empty());
}

/// A disc that moves along y and z, and turns about x.
std::vector<VectorXd> step_back_from_disc(const Eigen::Vector3d& gravity) {
  world::Scene scene = dynamics::test::empty_scene();
  scene.gravity = gravity;
  scene.objects.push_back(ball(world::ObjectJoint::PlanarYZ, 1, 0.1, 1));
  scene.robots.push_back(pusher());
  const auto model = world::Model::make(scene);
  VectorXd q = model->neutral();
  q[0] = 0.2;
  EXPECT_NEAR(least_gap(*model, q), 0, 1e-6);
  return find_step_back(*model, q);
}

TEST(StepBack, FromAPlane_IsWhereGravityDoesNotActInIt) {
  EXPECT_FALSE(step_back_from_disc({-9.81, 0, 0}).empty());
  EXPECT_TRUE(step_back_from_disc({0, 0, -9.81}).empty());
}

}  // namespace
}  // namespace stiction::execution::test
