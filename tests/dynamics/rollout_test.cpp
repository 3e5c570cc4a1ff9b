#include "stiction/dynamics/rollout.hpp"

#include "dynamics/systems.hpp"
#include "stiction/core/invalid_input.hpp"

namespace stiction::dynamics::test {
namespace {

using core::Status;

struct BoxAndHand {
  std::shared_ptr<const world::Model> model = load_task("planar_pushing");
  StepWorkspace work{model};
  Eigen::VectorXd q = (Eigen::VectorXd(5) << 0, 0.5, 0, 0, -0.1).finished();
  Eigen::VectorXd u0 = Eigen::Vector2d(0, -0.1);
};

TEST(Rollout, FreeMotion_IsCutIntoEqualPartsByTheJointLimits) {
  BoxAndHand push;
  RolloutResult r;
  const Eigen::Vector2d u1(0.06, -0.35);  // away from the box, 0.25 m along z
  ASSERT_EQ(rollout(*push.model, push.q, push.u0, u1, {}, {.joint_travel = 0.05}, push.work, r), Status::Solved);
  ASSERT_EQ(r.knots.size(), 5u);
  EXPECT_EQ(r.knots.back().u, u1);
  for (std::size_t k = 0; k < 5; ++k) EXPECT_NEAR(r.knots[k].u[1], -0.1 - 0.05 * static_cast<double>(k + 1), 1e-12);
}

TEST(Rollout, SlidingContact_IsCutFurtherUntilItSlidesLessThanTheLimit) {
  BoxAndHand push;
  RolloutResult r;
  const Eigen::Vector2d u1(0.1, -0.09);  // drags along the face under light load
  const SubstepLimits limits{.joint_travel = 0.05, .slide = 4e-3};
  ASSERT_EQ(rollout(*push.model, push.q, push.u0, u1, {}, limits, push.work, r), Status::Solved);
  EXPECT_GT(static_cast<int>(r.knots.size()), 3 * count_substeps(*push.model, push.u0, u1, limits));
  EXPECT_GT(r.steps, static_cast<int>(r.knots.size()));
  EXPECT_LE(r.max_slide, limits.slide);
  EXPECT_GT(r.max_slide, 0.2 * limits.slide);
}

TEST(Rollout, SlideThatNoSubstepShortens_IsStoppedBeforeOrAccepted) {
  BoxAndHand push;
  const Eigen::Vector2d u1(0.1, -0.09);
  const SubstepLimits limits{.joint_travel = 0.05, .slide = 4e-4};  // the shortest sub-step drags the ball by 3 mm
  RolloutResult accepted, stopped;
  ASSERT_EQ(rollout(*push.model, push.q, push.u0, u1, {}, limits, push.work, accepted), Status::Solved);
  EXPECT_GT(accepted.max_slide, limits.slide);
  push.work.forget();
  ASSERT_EQ(rollout(*push.model, push.q, push.u0, u1, {}, limits, push.work, stopped, Overrun::Stop), Status::MaxIterations);
  EXPECT_LE(stopped.max_slide, limits.slide);
  ASSERT_LT(stopped.knots.size(), accepted.knots.size());
  for (std::size_t k = 0; k < stopped.knots.size(); ++k) EXPECT_EQ(stopped.knots[k].q, accepted.knots[k].q);
}

TEST(Rollout, LowFriction_MaySlideFartherInASubstep) {
  BoxAndHand rough, smooth;
  world::Scene scene = world::load_scene(source_dir() / "tasks" / "planar_pushing.yaml");
  for (auto& geometry : scene.objects[0].geometries) geometry.friction = 0.02;
  smooth.model = world::Model::make(scene);
  StepWorkspace work(smooth.model);
  const Eigen::Vector2d u1(0.1, -0.09);
  const SubstepLimits limits{.joint_travel = 0.05, .slide = 4e-3};
  RolloutResult a, b;
  ASSERT_EQ(rollout(*rough.model, rough.q, rough.u0, u1, {}, limits, rough.work, a), Status::Solved);
  ASSERT_EQ(rollout(*smooth.model, smooth.q, smooth.u0, u1, {}, limits, work, b), Status::Solved);
  EXPECT_EQ(b.knots.size(), 2u);  // as many as the joint limits ask for
  EXPECT_GT(a.knots.size(), 3 * b.knots.size());
}

/// The sub-stepped motion converges: halving the sub-steps changes less and less.
TEST(Rollout, SmallerSubsteps_Converge) {
  BoxAndHand push;
  const Eigen::Vector2d u1(0.03, 0.1);
  std::vector<Eigen::VectorXd> ends;
  for (const double travel : {0.02, 0.01, 0.005, 0.0025}) {
    RolloutResult r;
    push.work.forget();
    ASSERT_EQ(rollout(*push.model, push.q, push.u0, u1, {}, {.joint_travel = travel, .slide = 1}, push.work, r), Status::Solved);
    ends.push_back(r.knots.back().q);
  }
  const double first = (ends[0] - ends[1]).norm(), second = (ends[1] - ends[2]).norm(), third = (ends[2] - ends[3]).norm();
  EXPECT_GT(first, 1e-6);
  EXPECT_LT(second, 0.75 * first);
  EXPECT_LT(third, 0.75 * second);
}

TEST(Rollout, BudgetUsedUp_ReturnsWhatItHas) {
  BoxAndHand push;
  RolloutResult r;
  EXPECT_EQ(rollout(*push.model, push.q, push.u0, Eigen::Vector2d(0, -1.1), {}, {.joint_travel = 0.01, .max_substeps = 7}, push.work, r),
            Status::MaxIterations);
  EXPECT_EQ(r.knots.size(), 7u);
}

TEST(Rollout, TimeUsedUpOrCancelled_ReturnsWhatItHas) {
  BoxAndHand push;
  RolloutResult r;
  core::RunControl control;
  control.deadline = core::RunControl::Clock::now();
  const Eigen::Vector2d u1(0, -1.1);
  EXPECT_EQ(rollout(*push.model, push.q, push.u0, u1, {}, {.joint_travel = 0.01}, push.work, r, Overrun::Accept, &control),
            Status::MaxIterations);
  EXPECT_TRUE(r.knots.empty());
  std::atomic<bool> cancel{true};
  control = {};
  control.cancel = &cancel;
  EXPECT_EQ(rollout(*push.model, push.q, push.u0, u1, {}, {.joint_travel = 0.01}, push.work, r, Overrun::Accept, &control),
            Status::Cancelled);
  EXPECT_EQ(r.steps, 0);
}

TEST(Rollout, BadLimits_AreNamed) {
  BoxAndHand push;
  RolloutResult r;
  try {
    (void)rollout(*push.model, push.q, push.u0, push.u0, {}, {.slide = 0}, push.work, r);
    FAIL();
  } catch (const core::InvalidInput& e) {
    EXPECT_STREQ(e.what(), "substep.slide: got 0, expected a finite number > 0");
  }
}

}  // namespace
}  // namespace stiction::dynamics::test
