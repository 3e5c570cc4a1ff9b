#include "stiction/tasks/place_links.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <cmath>
#include <numbers>

#include "stiction/core/invalid_input.hpp"
#include "stiction/core/random.hpp"
#include "stiction/tasks/task.hpp"
#include "stiction/world/read.hpp"

namespace stiction::tasks {
namespace {

using core::Status;
using Eigen::Vector3d;
using Eigen::VectorXd;
using world::Model;

int body_of(const Model& model, const std::string& name) {
  for (std::size_t i = 0; i < model.bodies().size(); ++i) {
    if (model.bodies()[i].name == name) return static_cast<int>(i);
  }
  return -1;
}

world::Pose pose_at(const Model& model, const VectorXd& q, int body) {
  world::KinematicsWorkspace work(model);
  world::Kinematics kinematics;
  world::calc_kinematics(model, q, work, kinematics);
  return kinematics.X_WB[static_cast<std::size_t>(body)];
}

/// Three links of 0.3, 0.25 and 0.2 m in the plane, whose third joint is mirrored by a pointer at the end.
std::shared_ptr<const Model> make_arm(const std::string& fixed = "") {
  return Model::make(world::parse_scene(R"(
robots:
  - name: arm
    stiffness: 100
    urdf: |
      <robot name="arm"><link name="base"/><link name="a"/><link name="b"/><link name="c"/>
      <link name="tip"><collision><geometry><sphere radius="0.02"/></geometry></collision></link>
      <joint name="j1" type="revolute"><parent link="base"/><child link="a"/><axis xyz="0 0 1"/><limit lower="-2" upper="2" effort="9"/></joint>
      <joint name="j2" type="revolute"><parent link="a"/><child link="b"/><origin xyz="0.3 0 0"/><axis xyz="0 0 1"/><limit lower="-2" upper="2" effort="9"/></joint>
      <joint name="j3" type="revolute"><parent link="b"/><child link="c"/><origin xyz="0.25 0 0"/><axis xyz="0 0 1"/><limit lower="-2" upper="2" effort="9"/></joint>
      <joint name="j4" type="revolute"><parent link="c"/><child link="tip"/><origin xyz="0.2 0 0"/><axis xyz="0 0 1"/><limit lower="-4" upper="4" effort="9"/><mimic joint="j3" multiplier="-1"/></joint></robot>
)" + fixed,
                                        "."));
}

/// Of the postures that put the tip at a point, the one whose distance from the given joints has no slope along the others.
TEST(PlaceLinks, PositionOfARedundantArm_IsReachedByTheNearestPosture) {
  const auto model = make_arm();
  const int tip = body_of(*model, "arm/tip");
  core::Random random(4, 0);
  for (int k = 0; k < 20; ++k) {
    VectorXd given(3), known(3);
    for (int j = 0; j < 3; ++j) known[j] = random.uniform(-1.2, 1.2), given[j] = known[j] + random.uniform(-0.3, 0.3);
    const Vector3d p = pose_at(*model, known, tip).p;
    const LinkTarget target{.body = tip, .p_WB = p};
    const PlacedLinks placed = place_links(*model, given, {&target, 1});
    ASSERT_EQ(placed.status, Status::Solved) << k;
    EXPECT_LT((pose_at(*model, placed.q, tip).p - p).norm(), 1e-6) << k;
    EXPECT_LE((placed.q - given).norm(), (known - given).norm() + 1e-3) << k;
    Eigen::Matrix<double, 2, 3> J;
    for (int j = 0; j < 3; ++j) {
      VectorXd ahead = placed.q, behind = placed.q;
      ahead[j] += 1e-5, behind[j] -= 1e-5;
      J.col(j) = ((pose_at(*model, ahead, tip).p - pose_at(*model, behind, tip).p) / 2e-5).head<2>();
    }
    const Eigen::JacobiSVD<Eigen::MatrixXd> svd(J, Eigen::ComputeFullV);
    if (svd.singularValues()[1] < 0.05) continue;  // stretched
    EXPECT_NEAR(svd.matrixV().col(2).dot(given - placed.q), 0, 2e-3) << k << ": along the postures that do the same";
  }
}

/// The tip turns by j1 + j2 alone, as the last joint takes the third one back.
TEST(PlaceLinks, PoseThroughAJointThatFollows_IsReached) {
  const auto model = make_arm();
  const int tip = body_of(*model, "arm/tip");
  const VectorXd known = (VectorXd(3) << 0.4, -0.7, 0.9).finished();
  const world::Pose X = pose_at(*model, known, tip);
  const LinkTarget target{.body = tip, .p_WB = X.p, .R_WB = X.R};
  const PlacedLinks placed = place_links(*model, VectorXd::Constant(3, 0.1), {&target, 1});
  ASSERT_EQ(placed.status, Status::Solved);
  EXPECT_LT((pose_at(*model, placed.q, tip).p - X.p).norm(), 1e-6);
  EXPECT_LT((pose_at(*model, placed.q, tip).R - X.R).norm(), 1e-6);
}

/// A ball where the nearest posture is: the arm goes there from its other side.
TEST(PlaceLinks, PostureThatOverlaps_GivesWayToOneThatDoesNot) {
  const auto model = make_arm("fixed: [{name: post, shapes: [{cylinder: {radius: 0.05, length: 0.2}, pose: {position: [0.3, 0, 0]}}]}]\n");
  const int tip = body_of(*model, "arm/tip");
  const LinkTarget target{.body = tip, .p_WB = {0.3, 0.3, 0}};
  const PlacedLinks free = place_links(*model, VectorXd::Zero(3), {&target, 1});
  EXPECT_EQ(free.status, Status::Solved);
  const LinkTarget inside{.body = tip, .p_WB = {0.3, 0.01, 0}};
  const PlacedLinks blocked = place_links(*model, VectorXd::Zero(3), {&inside, 1});
  EXPECT_EQ(blocked.status, Status::NumericalFailure);
  EXPECT_GE(blocked.pair, 0);
  EXPECT_NEAR(blocked.depth, 0.05 + 0.02 - 0.01, 1e-3);
}

TEST(PlaceLinks, PointOutOfReach_IsNotReachedAndSaysHowFarItIs) {
  const auto model = make_arm();
  const LinkTarget target{.body = body_of(*model, "arm/tip"), .p_WB = {0, 1, 0}};
  const PlacedLinks placed = place_links(*model, VectorXd::Constant(3, 0.2), {&target, 1});
  EXPECT_EQ(placed.status, Status::MaxIterations);
  EXPECT_NEAR(placed.position, 0.25, 1e-3);
}

/// An arm of seven joints with the meshes of its maker.
TEST(PlaceLinks, PosesOfAnIiwa_AreReached) {
  const Task task = load_task("iiwa_bimanual_box");
  const Model& model = *task.model;
  const int link = model.links()[7].body;
  core::Random random(9, 0);
  int reached = 0;
  for (int k = 0; k < 5; ++k) {
    VectorXd q = task.problem.q_start;
    for (int j = 0; j < 7; ++j) q[model.n_qu() + j] += random.uniform(-0.2, 0.2);
    const world::Pose X = pose_at(model, q, link);
    const LinkTarget target{.body = link, .p_WB = X.p, .R_WB = X.R};
    const PlacedLinks placed = place_links(model, task.problem.q_start, {&target, 1});
    if (placed.status == Status::NumericalFailure) continue;  // the arms are near to the box
    ASSERT_EQ(placed.status, Status::Solved) << k;
    ++reached;
    EXPECT_LT((pose_at(model, placed.q, link).p - X.p).norm(), 1e-6);
    EXPECT_LT((pose_at(model, placed.q, link).R - X.R).norm(), 1e-6);
  }
  EXPECT_GE(reached, 3);
}

/// A tip that is dragged around a circle, each posture from the one before: no joint leaps, not even where another posture would be nearer
/// to the first one, and none leaves its limits.
TEST(PlaceLinks, LinkThatIsDraggedInACircle_TakesItsJointsAlong) {
  const auto model = make_arm("fixed: [{name: post, shapes: [{cylinder: {radius: 0.02, length: 0.2}, pose: {position: [0.15, 0, 0]}}]}]\n");
  const int tip = body_of(*model, "arm/tip");
  VectorXd q = (VectorXd(3) << 0.5, -0.8, 0.9).finished();
  const Vector3d p = pose_at(*model, q, tip).p;
  for (int k = 1; k <= 120; ++k) {
    const double angle = 2 * std::numbers::pi * k / 60;
    const Vector3d step = 0.1 * Vector3d(std::cos(angle) - 1, std::sin(angle), 0);
    const LinkTarget target{.body = tip, .p_WB = p + step};
    const PlacedLinks placed = place_links(*model, q, {&target, 1}, {.postures = 1, .overlap = true});
    ASSERT_EQ(placed.status, Status::Solved) << k;
    EXPECT_LT((placed.q - q).cwiseAbs().maxCoeff(), 0.5) << k << ": the other elbow is more than a radian away";
    EXPECT_LE((placed.q.array().abs() - 2).maxCoeff(), 0) << "limits";
    q = placed.q;
  }
}

/// Out of reach the arm stretches towards the hand that drags it, does not swing there, and no joint leaves its limits.
TEST(PlaceLinks, LinkThatIsDraggedTooFar_IsAsNearAsItGets) {
  const auto model = make_arm();
  const LinkTarget target{.body = body_of(*model, "arm/tip"), .p_WB = {0.8, 0.6, 0}};
  const VectorXd stretched = (VectorXd(3) << std::atan2(0.6, 0.8), 0, 0).finished();
  PlacedLinks placed{.q = VectorXd::Constant(3, 0.2)};
  for (int tick = 0; tick < 3; ++tick) {
    placed = place_links(*model, VectorXd(placed.q), {&target, 1}, {.postures = 1, .overlap = true});
    EXPECT_EQ(placed.status, Status::MaxIterations);
    EXPECT_NEAR(placed.position, 0.25, 1e-3) << tick;
    EXPECT_LT((placed.q - stretched).cwiseAbs().maxCoeff(), 0.05) << tick;
  }
}

TEST(PlaceLinks, OverlapThatIsAllowed_IsNotInTheWay) {
  const auto model = make_arm("fixed: [{name: post, shapes: [{cylinder: {radius: 0.05, length: 0.2}, pose: {position: [0.3, 0, 0]}}]}]\n");
  const LinkTarget inside{.body = body_of(*model, "arm/tip"), .p_WB = {0.3, 0.01, 0}};
  EXPECT_EQ(place_links(*model, VectorXd::Constant(3, 0.5), {&inside, 1}, {.overlap = true}).status, Status::Solved);
}

TEST(PlaceLinks, BadInput_IsNamed) {
  const auto model = make_arm();
  const auto message = [&](const VectorXd& q, const LinkTarget& target, const PlaceLinksOptions& options) -> std::string {
    try {
      (void)place_links(*model, q, {&target, 1}, options);
    } catch (const core::InvalidInput& e) {
      return e.what();
    }
    return "";
  };
  const LinkTarget tip{.body = body_of(*model, "arm/tip")};
  EXPECT_EQ(message(VectorXd::Zero(3), {.body = body_of(*model, "arm/base")}, {}),
            "link: got 'arm/base', expected a link that joints of a robot move");
  EXPECT_NE(message(VectorXd::Zero(2), tip, {}).find("q"), std::string::npos);
  EXPECT_EQ(message(VectorXd::Zero(3), tip, {.postures = 0}), "postures: got 0, expected an integer ≥ 1");
  EXPECT_EQ(message(VectorXd::Zero(3), {.body = tip.body, .p_WB = Vector3d::Constant(NAN)}, {}),
            "pose of 'arm/tip': got numbers that are not finite, expected finite ones");
}

}  // namespace
}  // namespace stiction::tasks
