#include "stiction/execution/closed_loop/finger_gait.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <set>

#include "planning/push_plan.hpp"
#include "stiction/execution/closed_loop/run.hpp"
#include "stiction/execution/closed_loop/simulated_plant.hpp"

namespace stiction::execution::test {
namespace {

using core::Status;
using Eigen::VectorXd;
using planning::test::allegro_start;
using planning::test::load_model;

constexpr double kPeriod = 0.01;

/// The ball in the open hand, to be turned by so much about the vertical.
struct BallInHand {
  std::shared_ptr<const world::Model> model = load_model("allegro_ball");
  VectorXd q = allegro_start();
  planning::Goal goal;
  SimulatedPlant plant{model, q, {}};

  explicit BallInHand(double angle = 0.5) {
    goal.X_WG = world::object_pose(*model, q, 0);
    goal.X_WG.R = Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()).toRotationMatrix() * goal.X_WG.R;
  }
  VectorXd u() const { return q.tail(16); }
};

TEST(FingerGait, AppliesToWhatRollsOutOfAnOpenHandAndToNothingElse) {
  BallInHand ball;
  EXPECT_TRUE(FingerGait(ball.model, ball.goal, 0.7).applies(ball.q));
  VectorXd touched = ball.q;
  touched[0] += 0.004;
  touched[1] -= 0.004;
  EXPECT_TRUE(FingerGait(ball.model, ball.goal, 0.7).applies(touched)) << "fingers that touch it are no support";
  planning::Goal far = ball.goal;
  far.X_WG.p.x() += 0.1;
  EXPECT_FALSE(FingerGait(ball.model, far, 0.7).applies(ball.q)) << "it is not to be turned where it is";
  planning::Goal region = ball.goal;
  region.region.emplace();
  EXPECT_FALSE(FingerGait(ball.model, region, 0.7).applies(ball.q));

  const auto cubes = load_model("allegro_cube");
  VectorXd q = cubes->neutral();
  q.head(7) << -0.065, 0, 0.0411, 0, 0, 0, 1;
  planning::Goal turned;
  turned.X_WG = world::object_pose(*cubes, q, 0);
  EXPECT_FALSE(FingerGait(cubes, turned, 0.7).applies(q)) << "it lies on a face";

  const auto arms = load_model("iiwa_bimanual");
  planning::Goal anywhere;
  EXPECT_FALSE(FingerGait(arms, anywhere, 0.7).applies(arms->neutral()));
}

/// What became of a gait in the simulation: fingers in the order in which they went back.
struct Gait {
  std::vector<int> returned;
  bool turned = false;
  double most_aside = 0;  ///< of the ball [m]
};

Gait carry_out(BallInHand& rig, double duration) {
  FingerGait gait(rig.model, rig.goal, 0.7);
  gait.start(rig.q);
  Gait out;
  VectorXd u = rig.u();
  Measurement measured;
  while (rig.plant.world().time() < duration && !out.turned) {
    EXPECT_TRUE(rig.plant.read(measured));
    EXPECT_EQ(gait.update(measured.q, kPeriod, u), Status::Solved);
    if (gait.finger() >= 0 && (out.returned.empty() || out.returned.back() != gait.finger())) out.returned.push_back(gait.finger());
    EXPECT_TRUE(rig.plant.command(u, kPeriod));
    const VectorXd& q = rig.plant.world().q();
    out.most_aside = std::max(out.most_aside, (q.head<3>() - rig.q.head<3>()).norm());
    out.turned = gait.has_turned() && planning::goal_error(*rig.model, q, rig.goal).share(rig.goal) <= 0.85;
  }
  return out;
}

TEST(FingerGait, BallIsTurnedEitherWay_FingersGoBackOneByOne) {
  for (const double angle : {0.8, -0.8}) {
    BallInHand rig(angle);
    ASSERT_GT(planning::goal_error(*rig.model, rig.q, rig.goal).share(rig.goal), 7);
    const Gait gait = carry_out(rig, 15);
    EXPECT_TRUE(gait.turned) << angle;
    EXPECT_LT(gait.most_aside, 0.02);
    ASSERT_GE(gait.returned.size(), 4U) << "one turn was enough: the test would say nothing";
    EXPECT_EQ(std::vector<int>(gait.returned.begin(), gait.returned.begin() + 4), (std::vector<int>{0, 1, 2, 3}));
  }
}

/// While one finger goes back its commands are those of its path, which ends where it first touched the ball, and those of the others keep to the rate of a
/// hold.
TEST(FingerGait, FingerThatGoesBack_ComesToItsFirstCommandWhileOthersHold) {
  BallInHand rig(1.5);
  FingerGait gait(rig.model, rig.goal, 0.7);
  const Fingers fingers = find_fingers(*rig.model, 0);
  ASSERT_EQ(fingers.chains.size(), 4U);
  gait.start(rig.q);
  VectorXd u = rig.u(), home;
  Measurement measured;
  bool lifted = false;
  for (int last = -1; last < 3;) {
    ASSERT_LT(rig.plant.world().time(), 6);
    ASSERT_TRUE(rig.plant.read(measured));
    const VectorXd before = u;
    ASSERT_EQ(gait.update(measured.q, kPeriod, u), Status::Solved);
    if (home.size() == 0 && (gait.reference() - rig.q).head(7).norm() > 1e-9) home = before;  // the first turn begins
    if (gait.finger() != last && last >= 0) {
      const std::vector<int>& came = fingers.chains[static_cast<std::size_t>(last)];
      for (const int joint : came) EXPECT_NEAR(before[joint], home[joint], 1e-9) << last;
    }
    last = gait.finger();
    for (std::size_t f = 0; f < fingers.chains.size(); ++f) {
      double most = 0;
      for (const int joint : fingers.chains[f]) most = std::max(most, std::abs(u[joint] - before[joint]));
      if (static_cast<int>(f) == gait.finger()) {
        lifted = lifted || most > 0.006;
      } else {
        EXPECT_LE(most, 0.5 * kPeriod + 1e-12);
      }
    }
    ASSERT_TRUE(rig.plant.command(u, kPeriod));
  }
  EXPECT_TRUE(lifted);
}

TEST(FingerGait, TurnsThatBringNothing_AreTold) {
  BallInHand rig(2);
  FingerGait gait(rig.model, rig.goal, 0.7);
  gait.start(rig.q);
  VectorXd u = rig.u();
  int ticks = 0;
  for (; ticks < 3000 && !gait.stalls(); ++ticks) ASSERT_EQ(gait.update(rig.q, kPeriod, u), Status::Solved);  // the ball does not follow
  EXPECT_TRUE(gait.stalls());
  EXPECT_GT(ticks, 300) << "it is given two turns";
  EXPECT_LT(ticks, 600) << "and no more";
}

TEST(ActiveHold, FingerThatIsLeft_KeepsItsCommands) {
  BallInHand rig;
  ActiveHold hold(rig.model, 0, 0.7);
  VectorXd aside = rig.q;
  aside[0] += 0.005;
  hold.start(rig.q);
  hold.leave(1);
  VectorXd u = rig.u();
  ASSERT_EQ(hold.update(aside, kPeriod, u), Status::Solved);
  EXPECT_EQ(VectorXd(u.segment(4, 4)), VectorXd(rig.u().segment(4, 4)));
  EXPECT_GT((u - rig.u()).cwiseAbs().maxCoeff(), 1e-4);
  hold.leave(-1);
  u = rig.u();
  ASSERT_EQ(hold.update(aside, kPeriod, u), Status::Solved);
  EXPECT_GT((u - rig.u()).segment(4, 4).cwiseAbs().maxCoeff(), 1e-5);
}

/// A whole run: the goal holds, and nothing was planned.
TEST(Run, BallInAnOpenHand_IsTurnedByItsFingers) {
  BallInHand rig;
  planning::PlanningProblem problem{rig.model, rig.q, rig.goal, {}};
  planning::PlannerOptions planner;
  planner.threads = 1;
  RunOptions how;
  how.duration = 15;
  core::RunControl control;
  RunResult out;
  ASSERT_EQ(run(rig.plant, problem, planner, how, control, out), Status::Solved) << out.message;
  EXPECT_TRUE(out.plans.empty());
  EXPECT_EQ(out.replans, 0);
  EXPECT_GE(out.count(planning::SegmentKind::Contact), 2);
  EXPECT_GE(out.count(planning::SegmentKind::Regrasp), 4);
  for (const RunPiece& piece : out.pieces) EXPECT_EQ(piece.plan, -1);
  EXPECT_LE(planning::goal_error(*rig.model, rig.plant.world().q(), rig.goal).share(rig.goal), 1);

  how.finger_gait = false;
  how.duration = 1;
  how.plan_timeout = 0.2;
  BallInHand again;
  (void)run(again.plant, problem, planner, how, control, out);
  EXPECT_FALSE(out.plans.empty()) << "without it a plan is asked for";
}

}  // namespace
}  // namespace stiction::execution::test
