#include "stiction/world/object_space.hpp"

#include <numbers>

#include "world/test_scenes.hpp"

namespace stiction::world::test {
namespace {

TEST(ObjectSpace, FreeObject_ErrorIsLocalOfTheModel) {
  const auto model = load_task("allegro_ball");
  const ObjectSpace space(*model);
  core::Random random(3, 0);
  for (const double scale : {0.0, 1e-6, 0.3, 3.0}) {
    for (int sample = 0; sample < 200; ++sample) {
      Eigen::VectorXd delta(22), e(22), q1(23), q2(23);
      for (int i = 0; i < 22; ++i) delta[i] = scale * random.normal();
      retract(*model, model->neutral(), Eigen::VectorXd::NullaryExpr(22, [&] { return random.normal(); }), q1);
      retract(*model, q1, delta, q2);
      local(*model, q1, q2, e);
      Eigen::VectorXd ours(6);
      space.error(q1.data(), q2.data(), ours.data());
      if (e.segment<3>(3).norm() > 3.1) continue;  // at π the sign is a choice
      EXPECT_LT((ours - e.head(6)).norm(), 1e-9 + 4e-8 * e.head(6).norm());
      q2.segment<4>(3) *= -1;  // the same rotation
      space.error(q1.data(), q2.data(), ours.data());
      EXPECT_LT((ours - e.head(6)).norm(), 1e-9 + 4e-8 * e.head(6).norm());
    }
  }
}

TEST(ObjectSpace, PlanarAngle_IsWrapped) {
  const auto model = load_task("planar_hand");
  const ObjectSpace space(*model);
  const Eigen::Vector3d from(0, 0, 3.0), to(0.1, -0.2, -3.0);
  Eigen::Vector3d e;
  space.error(from.data(), to.data(), e.data());
  EXPECT_NEAR(e[2], 2 * std::numbers::pi - 6.0, 1e-12);
  EXPECT_NEAR(e[0], 0.1, 1e-15);
}

TEST(ObjectSpace, CoordinatesOfPose_GiveThatPose) {
  core::Random random(4, 0);
  for (const char* task : {"allegro_ball", "planar_hand", "planar_pushing"}) {
    const auto model = load_task(task);
    const ObjectSpace space(*model);
    for (int sample = 0; sample < 100; ++sample) {
      Eigen::VectorXd q = model->neutral();
      Eigen::VectorXd delta = Eigen::VectorXd::Zero(model->n_v());
      for (int i = 0; i < model->n_vu(); ++i) delta[i] = random.normal();
      retract(*model, q, delta, q);
      const Pose X = object_pose(*model, q, 0);
      q.head(model->n_qu()) = space.coordinates(0, X);
      const Pose Y = object_pose(*model, q, 0);
      EXPECT_LT((X.p - Y.p).norm() + (X.R - Y.R).norm(), 1e-12);
    }
  }
}

TEST(ObjectSpace, Samples_StayInTheBox) {
  const auto model = load_task("allegro_ball");
  const ObjectSpace space(*model);
  SampleBox box;
  box.lower = (Eigen::VectorXd(6) << -0.1, -0.2, 0, 0, 0, 1).finished();
  box.upper = (Eigen::VectorXd(6) << 0.1, 0.2, 0.3, 0, 0, 2).finished();
  core::Random random(5, 0);
  for (int sample = 0; sample < 100; ++sample) {
    Eigen::VectorXd q_u = model->neutral().head(7);
    space.sample({box}, random, q_u);
    EXPECT_NEAR(q_u.tail<4>().norm(), 1, 1e-12);
    const double yaw = 2 * std::atan2(q_u[5], q_u[6]);
    EXPECT_GE(yaw, 1 - 1e-12);
    EXPECT_LE(yaw, 2 + 1e-12);
    EXPECT_TRUE((q_u.head<3>().array() >= box.lower.head<3>().array()).all() &&
                (q_u.head<3>().array() <= box.upper.head<3>().array()).all());
  }
}

}  // namespace
}  // namespace stiction::world::test
