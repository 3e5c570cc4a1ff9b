#include <atomic>
#include <filesystem>
#include <thread>

#include "simulation/scenes.hpp"
#include "stiction/core/invalid_input.hpp"
#include "support/message_of.hpp"

namespace stiction::simulation::test {
namespace {

using core::Status;
using Eigen::Vector2d;
using Eigen::VectorXd;

/// The hand of planar_pushing runs into its box.
struct Push {
  Push() : rig(load_task("planar_pushing")) { u << 0.0, 0.0, -0.1, 0.3; }

  Status run(Workspace& work, SimulationResult& out) const { return simulate(*rig.plant, {q0, times, u, nullptr}, rig.run, work, out); }

  Rig rig;
  VectorXd q0 = (VectorXd(5) << 0, 0.6, 0, 0, -0.1).finished();
  Vector2d times{0, 1};
  Eigen::MatrixXd u{2, 2};
};

TEST(Simulate, SameInput_SameBitsInAnyWorkspaceAndThread) {
  Push push;
  SimulationResult first;
  ASSERT_EQ(push.run(push.rig.work, first), Status::Solved) << first.message;
  ASSERT_GT(first.q(1, first.q.cols() - 1), 0.61) << "the box was pushed";
  SimulationResult again;
  ASSERT_EQ(push.run(push.rig.work, again), Status::Solved);
  EXPECT_EQ(first.q, again.q) << "the same workspace";
  SimulationResult other[2];
  std::thread threads[2];
  for (int i = 0; i < 2; ++i) {
    threads[i] = std::thread([&, i] {
      Workspace work(push.rig.plant);
      (void)push.run(work, other[i]);
    });
  }
  for (auto& thread : threads) thread.join();
  for (const auto& result : other) {
    EXPECT_EQ(first.q, result.q);
    EXPECT_EQ(first.v, result.v);
    ASSERT_EQ(first.forces.size(), result.forces.size());
    for (std::size_t k = 0; k < first.forces.size(); ++k) ASSERT_EQ(first.forces[k].size(), result.forces[k].size());
  }
}

TEST(Simulate, Recording_DoesNotChangeTheMotion) {
  Push push;
  SimulationResult coarse, fine;
  push.rig.run.record_interval = 0.1;
  ASSERT_EQ(push.run(push.rig.work, coarse), Status::Solved);
  push.rig.run.record_interval = 1e-3;
  ASSERT_EQ(push.run(push.rig.work, fine), Status::Solved);
  ASSERT_EQ(coarse.times.size(), 11u);
  ASSERT_EQ(fine.times.size(), 1001u);
  EXPECT_EQ(coarse.q.rightCols<1>(), fine.q.rightCols<1>());
  EXPECT_NEAR(coarse.times[3], 0.3, 1e-12);
  EXPECT_EQ(coarse.q.col(3), fine.q.col(300));
}

/// Momentum: what the contact gives to the box in all is what the box has in the end.
TEST(Simulate, ForcesInTheResult_AreThoseThatMoveTheObject) {
  Push push;
  push.rig.run.record_interval = push.rig.plant->options().timestep;
  SimulationResult r;
  ASSERT_EQ(push.run(push.rig.work, r), Status::Solved);
  Eigen::Vector3d impulse = Eigen::Vector3d::Zero();
  for (std::size_t k = 0; k + 1 < r.times.size(); ++k) {
    for (const auto& f : r.forces[k]) impulse += f.force_W * (r.times[k + 1] - r.times[k]);
  }
  const Eigen::Index last = r.q.cols() - 1;
  ASSERT_GT(impulse.norm(), 0.05);
  EXPECT_NEAR(impulse.y(), 5.0 * r.v(0, last), 1e-6);
  EXPECT_NEAR(impulse.z(), 5.0 * r.v(1, last), 1e-6);
}

TEST(Simulate, StartingVelocity_IsInTangentCoordinates) {
  world::Scene scene = empty_scene(Eigen::Vector3d::Zero());
  scene.objects.push_back(solid(world::ObjectJoint::Free, world::Sphere{0.05}, 1, 1));
  Rig rig(scene);
  VectorXd q0(7), v0(6);
  q0 << 1, 2, 3, 0.5, -0.5, 0.5, 0.5;
  v0 << 0.1, 0.2, -0.3, 0.4, 0.5, -0.6;
  ASSERT_EQ(rig.hold(q0, {}, 0.5, &v0), Status::Solved);
  VectorXd want(7);
  world::retract(*rig.model, q0, 0.5 * v0, want);  // a ball turns about a fixed axis
  VectorXd difference(6);
  world::local(*rig.model, rig.q_end(), want, difference);
  EXPECT_LT(difference.norm(), 1e-9);
  EXPECT_LT((rig.v_end() - v0).norm(), 1e-9);
}

/// A joint on a ramp: with damping on its own velocity it trails by v D/K, with damping on what it differs by from the command by nothing.
TEST(Simulate, VelocityReference_TakesTheLagAway) {
  for (const bool reference : {false, true}) {
    world::Scene scene = empty_scene(Eigen::Vector3d::Zero());
    scene.robots.push_back(pusher(500));
    PlantOptions options;
    options.velocity_reference = reference;
    Rig rig(scene, options);
    const double speed = 0.2, duration = 1.0;
    Eigen::MatrixXd u = Eigen::MatrixXd::Zero(2, 2);
    u(0, 1) = speed * duration;
    ASSERT_EQ(simulate(*rig.plant, {VectorXd::Zero(2), Vector2d(0, duration), u, nullptr}, rig.run, rig.work, rig.result), Status::Solved);
    const Eigen::Index before_end = rig.result.q.cols() - 2;  // the last command is at rest
    const double lag = speed * rig.result.times[static_cast<std::size_t>(before_end)] - rig.result.q(0, before_end);
    EXPECT_NEAR(lag, reference ? 0.0 : speed * rig.plant->damping()[0] / 500, 1e-5);
  }
}

TEST(Simulate, UnstableSpring_IsReportedAndLeavesTheWorkspaceUsable) {
  world::Scene scene = empty_scene(Eigen::Vector3d::Zero());
  scene.robots.push_back(pusher(1e9));
  PlantOptions options;
  options.damping_ratio = 0;
  options.spring_resolution = 1e6;  // no armature to speak of
  Rig rig(scene, options);
  EXPECT_EQ(rig.hold(Vector2d(0, 0), Vector2d(0.1, 0), 1.0), Status::NumericalFailure);
  EXPECT_NE(rig.result.message.find("out of range after"), std::string::npos) << rig.result.message;
  EXPECT_EQ(rig.result.status, Status::NumericalFailure);
  EXPECT_EQ(rig.hold(Vector2d(0, 0), Vector2d(0, 0), 0.1), Status::Solved) << "nothing of the failure is left";
  EXPECT_FALSE(std::filesystem::exists("MUJOCO_LOG.TXT"));
}

TEST(Simulate, CancelAndDeadline_StopEarlyAndKeepWhatWasRecorded) {
  Push push;
  std::atomic<bool> cancel{true};
  core::RunControl control{.cancel = &cancel, .deadline = std::nullopt, .on_progress = {}};
  push.rig.run.control = &control;
  SimulationResult r;
  EXPECT_EQ(push.run(push.rig.work, r), Status::Cancelled);
  EXPECT_EQ(r.times.size(), 0u);
  cancel = false;
  control.deadline = core::RunControl::Clock::now();
  EXPECT_EQ(push.run(push.rig.work, r), Status::MaxIterations);
  EXPECT_EQ(static_cast<std::size_t>(r.q.cols()), r.times.size());
}

TEST(Simulate, Stop_EndsAtTheFirstSampleThatAsksForIt) {
  Push push;
  SimulationResult whole, part;
  ASSERT_EQ(push.run(push.rig.work, whole), Status::Solved);
  const double z = 0.605;  // on the way from 0.6 m
  push.rig.run.stop = [&](double, VectorRef q) { return q[1] >= z; };
  ASSERT_EQ(push.run(push.rig.work, part), Status::Solved);
  const Eigen::Index last = part.q.cols() - 1;
  ASSERT_LT(last, whole.q.cols() - 1);
  EXPECT_GE(part.q(1, last), z);
  EXPECT_LT(part.q(1, last - 1), z);
  EXPECT_EQ(part.q, whole.q.leftCols(last + 1)) << "and changes nothing before it";
}

template <class F>
std::string message(F&& call) {
  try {
    (void)call();
  } catch (const core::InvalidInput& e) {
    return e.what();
  }
  return "accepted";
}

TEST(Simulate, WrongInput_IsNamed) {
  Push push;
  SimulationResult r;
  const auto call = [&](const VectorXd& q0, const VectorXd& times, const Eigen::MatrixXd& u) {
    return message([&] { return simulate(*push.rig.plant, {q0, times, u, nullptr}, {}, push.rig.work, r); });
  };
  EXPECT_EQ(call(VectorXd::Zero(4), push.times, push.u), "q0: got 4 numbers, expected 5");
  EXPECT_EQ(call(push.q0, Eigen::Vector3d(0, 1, 2), push.u), "u.cols: got 2 numbers, expected 3");
  EXPECT_EQ(call(push.q0, Vector2d(0.5, 1), push.u), "times[0]: got 0.5, expected 0");
  EXPECT_EQ(call(push.q0, Vector2d(0, 0), push.u), "times[1]: got 0, expected more than 0");
  EXPECT_EQ(call(push.q0, push.times, Eigen::MatrixXd::Constant(2, 2, NAN)), "u: got a number that is not finite, expected finite numbers");
  Workspace stranger(Plant::make(load_task("planar_hand")));
  EXPECT_EQ(message([&] { return push.run(stranger, r); }), "work: got a workspace of another plant, expected one of this plant");
}

/// x'' = −x'/τ: an object on a joint coasts v₀ τ (1 − e^(−t/τ)); a free one goes on.
TEST(Simulate, ObjectsOnJoints_ComeToRestInTheRestTime) {
  PlantOptions options;
  options.rest_time = 0.1;
  world::Scene scene = empty_scene(Eigen::Vector3d::Zero());
  scene.objects.push_back(solid(world::ObjectJoint::PlanarXY, world::Box{{0.1, 0.1, 0.1}}, 2.0, 0.5));
  scene.robots.push_back(pusher(100));
  Rig rig(scene, options);
  VectorXd q0 = VectorXd::Zero(5), v0 = VectorXd::Zero(5);
  q0.head<2>() << 5, 5;  // out of reach
  v0.head<3>() << 0.3, -0.2, 0.5;
  ASSERT_EQ(rig.hold(q0, VectorXd::Zero(2), 0.25, &v0), Status::Solved) << rig.result.message;
  const double coasted = 0.1 * (1 - std::exp(-2.5));
  // The implicit step of 0.2 ms is of first order in h/τ = 0.002.
  EXPECT_NEAR(rig.q_end()[0] - 5, 0.3 * coasted, 2e-3 * 0.3 * coasted);
  EXPECT_NEAR(rig.q_end()[2], 0.5 * coasted, 2e-3 * 0.5 * coasted);

  scene.objects[0].joint = world::ObjectJoint::Free;
  Rig free(scene, options);
  q0 = VectorXd::Zero(9), v0 = VectorXd::Zero(8);
  q0.head<3>() << 5, 5, 5;
  q0[6] = 1;
  v0[0] = 0.3;
  ASSERT_EQ(free.hold(q0, VectorXd::Zero(2), 0.25, &v0), Status::Solved);
  EXPECT_NEAR(free.q_end()[0] - 5, 0.3 * 0.25, 1e-9);

  options.rest_time = 0;
  EXPECT_NE(stiction::test::message_of([&] { (void)Plant::make(rig.model, options); }).find("rest_time"), std::string::npos);
}

}  // namespace
}  // namespace stiction::simulation::test
