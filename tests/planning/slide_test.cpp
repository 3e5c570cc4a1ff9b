#include "stiction/planning/slide.hpp"

#include "planning/systems.hpp"

namespace stiction::planning::test {
namespace {

/// Smallest distance of a pair at q.
double gap(const world::Model& model, int pair, const Eigen::VectorXd& q, GeometryWorkspace& work) {
  world::calc_kinematics(model, q, work.kinematics_work, work.kinematics);
  return contact::pair_distance(model, work.kinematics, pair, work.contact_work).phi;
}

TEST(DrawSlide, BallOnABox_IsTheTangent) {
  const auto model = load_model("planar_pushing");  // a ball on two sliders, y and z, beside a box
  const RobotChains chains(*model);
  GeometryWorkspace work(*model);
  Eigen::VectorXd q = model->neutral();
  q.tail(2) << -0.6, 0.1;  // half of the box and the radius of the ball
  core::Random random(1, 0);
  int up = 0, down = 0;
  for (int k = 0; k < 50; ++k) {
    const auto slide = draw_slide(*model, chains, q, random, work);
    ASSERT_TRUE(slide.has_value());
    EXPECT_NEAR(slide->delta[0], 0, 1e-6);
    EXPECT_NEAR(std::abs(slide->delta[1]), 1, 1e-6);
    ++(slide->delta[1] > 0 ? up : down);
  }
  EXPECT_GT(up, 10);
  EXPECT_GT(down, 10);
}

TEST(DrawSlide, FarFromTheObject_IsNone) {
  const auto model = load_model("planar_pushing");
  const RobotChains chains(*model);
  GeometryWorkspace work(*model);
  Eigen::VectorXd q = model->neutral();
  q.tail(2) << -0.7, 0.1;
  core::Random random(1, 0);
  EXPECT_FALSE(draw_slide(*model, chains, q, random, work).has_value());
}

TEST(DrawSlide, Hand_MovesOneFingerAndKeepsItsGapsToFirstOrder) {
  const auto model = load_model("allegro_ball");
  const RobotChains chains(*model);
  GeometryWorkspace work(*model);
  core::Random random(3, 0);
  int slides = 0;
  for (int k = 0; k < 50; ++k) {
    const auto sample = sample_contact(*model, chains, GenericSampler{}, {chains.all(), false}, allegro_start(), random, work);
    if (!sample) continue;
    Eigen::VectorXd q = allegro_start();
    q.tail(16) = sample->q_a;
    const auto slide = draw_slide(*model, chains, q, random, work);
    if (!slide) continue;
    ++slides;
    EXPECT_NEAR(slide->delta.norm(), 1, 1e-9);
    for (int c = 0; c < chains.size(); ++c) {
      if (c == slide->branch) continue;
      for (const int j : chains.joints(c)) EXPECT_EQ(slide->delta[j], 0);
    }
    constexpr double kStep = 1e-4;
    Eigen::VectorXd ahead = q, behind = q;
    ahead.tail(16) += kStep * slide->delta;
    behind.tail(16) -= kStep * slide->delta;
    for (const int pair : chains.pairs_against(slide->branch)) {
      if (gap(*model, pair, q, work) > 0.99 * kSlideReach) continue;
      EXPECT_NEAR((gap(*model, pair, ahead, work) - gap(*model, pair, behind, work)) / (2 * kStep), 0, 1e-4);
    }
  }
  EXPECT_GT(slides, 20);
}

}  // namespace
}  // namespace stiction::planning::test
