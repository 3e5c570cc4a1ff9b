#include "stiction/execution/closed_loop/run.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <memory>
#include <vector>

#include "dynamics/systems.hpp"
#include "planning/push_plan.hpp"
#include "stiction/execution/closed_loop/object_watch.hpp"
#include "stiction/execution/closed_loop/simulated_plant.hpp"
#include "stiction/execution/open_loop/run_speed.hpp"
#include "stiction/world/scales.hpp"
#include "support/message_of.hpp"

namespace stiction::execution::test {
namespace {

using core::Status;
using Eigen::VectorXd;
using planning::SegmentKind;
using planning::test::load_model;
using stiction::test::message_of;

/// A ball pushes a box of 1 m by so much along y.
struct BoxRun {
  std::shared_ptr<const world::Model> model = load_model("planar_pushing");
  planning::PlanningProblem problem;
  planning::PlannerOptions planner;
  WorldOptions world;
  RunOptions how;
  core::RunControl control;
  RunResult out;

  explicit BoxRun(double way = 0.1) {
    problem.model = model;
    problem.q_start = (VectorXd(5) << 0, 0.6, 0, 0, -0.02).finished();
    problem.goal.X_WG = world::object_pose(*model, problem.q_start, 0);
    problem.goal.X_WG.p.z() += way;
    problem.goal.tol_position = 0.02;
    planner.threads = 2;
    planner.seed = 1;
    how.plan_step_time = 1e-4;  // so that runs are the same wherever the tests run
  }
  Status run(Driver& plant, const planning::Plan* first = nullptr) {
    return execution::run(plant, problem, planner, how, control, out, first);
  }
  Status run() {
    SimulatedPlant plant(model, problem.q_start, world);
    return run(plant);
  }
};

double error_of(const BoxRun& rig, const Eigen::VectorXd& q) {
  return planning::goal_error(*rig.model, q, rig.problem.goal).share(rig.problem.goal);
}

TEST(Run, PushedBox_ReachesItsGoalAndStaysForTheHold) {
  BoxRun rig;
  SimulatedPlant plant(rig.model, rig.problem.q_start, rig.world);
  ASSERT_EQ(rig.run(plant), Status::Solved) << rig.out.message;
  EXPECT_EQ(rig.out.end, RunEnd::Reached);
  EXPECT_LE(error_of(rig, plant.world().q()), 1);
  EXPECT_GE(rig.out.count(SegmentKind::Contact), 1);
  EXPECT_EQ(rig.out.pieces.empty() ? 0 : rig.out.plans.size(), static_cast<std::size_t>(1 + rig.out.replans));
  EXPECT_LE(plant.world().largest_effort(), 1 + 1e-9);
  for (Eigen::Index k = rig.out.q.cols() - 1; rig.out.times[static_cast<std::size_t>(k)] > rig.out.duration_s - rig.how.hold; --k)
    EXPECT_LE(error_of(rig, rig.out.q.col(k)), 1) << k;
  EXPECT_GT(error_of(rig, rig.out.q.col(0)), 4) << "it started elsewhere";
}

TEST(Run, SameSeed_SameRun) {
  BoxRun a, b;
  a.world.pose_noise = b.world.pose_noise = 1e-3;
  a.planner.threads = 1;
  ASSERT_EQ(a.run(), b.run());
  EXPECT_EQ(a.out.times, b.out.times);
  EXPECT_EQ(a.out.q, b.out.q);
  EXPECT_EQ(a.out.u, b.out.u);
}

TEST(Run, ObjectAtItsGoal_IsHeldWithoutAPlan) {
  BoxRun rig(0);
  ASSERT_EQ(rig.run(), Status::Solved) << rig.out.message;
  EXPECT_TRUE(rig.out.plans.empty());
  EXPECT_TRUE(rig.out.pieces.empty());
  EXPECT_GE(rig.out.duration_s, rig.how.hold);
}

/// What the planner computed is charged to the clock, twice as much of it at half of the rate.
TEST(Run, ClockGoesOnByWhatThePlannerTook) {
  for (const double rate : {0.0, 0.5, 1.0}) {
    BoxRun rig;
    rig.how.planning_rate = rate;
    ASSERT_EQ(rig.run(), Status::Solved) << rig.out.message;
    ASSERT_TRUE(rig.out.first_plan);
    const auto steps = static_cast<double>(rig.out.first_plan->steps + rig.out.first_plan->linearisations);
    ASSERT_GT(steps, 100);
    const double expected = rate > 0 ? 1e-4 * steps / rate : 0, clock = rig.out.plans[0].clock_s;
    EXPECT_NEAR(clock, expected, rig.how.tick) << rate;
    EXPECT_GE(rig.out.pieces.at(0).begin_s, rig.out.plans[0].time + clock - 1e-9);
  }
  BoxRun measured;
  measured.how.plan_step_time.reset();
  ASSERT_EQ(measured.run(), Status::Solved) << measured.out.message;
  for (const RunPlan& plan : measured.out.plans) EXPECT_NEAR(plan.clock_s, plan.processor_s, measured.how.tick);
}

/// A planner that takes far longer than it may: the robot holds meanwhile, and the run goes on.
TEST(Run, PlannerThatOverrunsItsTime_TheRobotHoldsMeanwhile) {
  BoxRun rig;
  rig.how.plan_timeout = 5;
  rig.how.plan_step_time = 0.1;
  VectorXd u;
  double held = 0;
  rig.how.on_sample = [&](const RunSample& sample) {
    if (sample.state != RunState::Replan || sample.plans > 0) return;
    if (u.size() == 0) u = sample.u;
    EXPECT_LT((sample.u - u).norm(), 1e-12) << sample.time;
    held = sample.time;
  };
  ASSERT_EQ(rig.run(), Status::Solved) << rig.out.message;
  EXPECT_GT(rig.out.plans[0].clock_s, 2 * rig.how.plan_timeout);
  EXPECT_GT(held, 2 * rig.how.plan_timeout);
}

/// Pushed aside while the planner works: its plan begins where the box no more is.
TEST(Run, BoxThatMovedWhileThePlannerWorked_IsPlannedAnew) {
  BoxRun rig;
  rig.how.plan_step_time = 1e-2;
  rig.world.pushes = {{.object = 0, .begin = 0.8, .duration = 0.5, .force_W = {0, 60, 0}}};
  ASSERT_EQ(rig.run(), Status::Solved) << rig.out.message;
  ASSERT_GE(rig.out.plans.size(), 2U);
  ASSERT_GT(rig.out.plans[0].time + rig.out.plans[0].clock_s, 1.3) << "the push came when the plan was there";
  EXPECT_EQ(rig.out.plans[1].cause, "the object moved while the planner worked");
  EXPECT_GT(rig.out.pieces.at(0).begin_s, rig.out.plans[1].time);
}

/// A ball of radius 0.1 m that rests on the ground at z = 0, and a pusher.
std::shared_ptr<const world::Model> ball_on_ground(double damping) {
  world::Scene scene = dynamics::test::empty_scene();
  scene.gravity = {0, 0, -9.81};
  scene.objects.push_back(dynamics::test::ball(world::ObjectJoint::Free, 1, 0.1, 1));
  scene.objects[0].joint_damping = damping;
  scene.robots.push_back(dynamics::test::pusher(0.1));
  scene.fixed.push_back(dynamics::test::half_space(Eigen::Vector3d::UnitZ(), {0, 0, -0.1}, 1));
  return world::Model::make(scene);
}

/// A ball rolls away all the time. The first plan begins where the ball no more is, and later ones where it will be.
TEST(Run, BallThatRolls_IsMetWhereItWillBe) {
  BoxRun rig;
  rig.model = rig.problem.model = ball_on_ground(0);
  rig.problem.q_start = rig.model->neutral();
  rig.problem.q_start[rig.model->n_qu()] = -0.4;
  rig.problem.goal.X_WG = {Eigen::Matrix3d::Identity(), {0, 0.9, 0}};
  rig.problem.goal.tol_position = 0.03, rig.problem.goal.tol_angle = 3.2;
  rig.how.hold = 0;
  rig.how.plan_step_time = 1e-4;
  rig.world.pushes = {{.object = 0, .begin = 0, .duration = 0.1, .force_W = {0, 0.42, 0}}};  // to 0.03 m/s
  ASSERT_EQ(rig.run(), Status::Solved) << rig.out.message;
  ASSERT_GE(rig.out.plans.size(), 2U);
  EXPECT_EQ(rig.out.plans[1].cause, "the object moved while the planner worked");
  ASSERT_FALSE(rig.out.pieces.empty());
  EXPECT_EQ(rig.out.pieces[0].plan, 1) << "the second plan was carried out";
}

/// A damped ball sinks at 20 mm/s, which counts as rest. The planner, whose objects fall at once, says that it does not rest.
TEST(Run, ObjectThatCreeps_IsWaitedFor) {
  BoxRun rig;
  rig.model = rig.problem.model = ball_on_ground(9.81 / 0.02);
  rig.problem.q_start = rig.model->neutral();
  rig.problem.q_start[2] = 0.1;
  rig.problem.q_start[rig.model->n_qu()] = -0.4;
  rig.problem.goal.X_WG = {};
  rig.problem.goal.tol_position = 0.03, rig.problem.goal.tol_angle = 3.2;
  ASSERT_EQ(rig.run(), Status::Solved) << rig.out.message;
  ASSERT_GE(rig.out.plans.size(), 2U);
  EXPECT_NE(rig.out.plans[0].reason.find("does not rest"), std::string::npos) << rig.out.plans[0].reason;
  EXPECT_TRUE(rig.out.pieces.empty()) << "nothing had to be pushed";
}

/// A plant with a clock of its own is commanded while the planner works.
class OwnClock final : public Driver {
 public:
  explicit OwnClock(const BoxRun& rig) : inner(rig.model, rig.problem.q_start, {}) {}
  bool read(Measurement& out) override { return inner.read(out); }
  bool command(VectorRef u, double period) override { return inner.command(u, period); }
  bool real_time() const override { return true; }
  SimulatedPlant inner;
};

TEST(Run, PlantWithItsOwnClock_IsHeldWhileThePlannerWorks) {
  BoxRun rig;
  rig.how.duration = 1e6;
  OwnClock plant(rig);
  ASSERT_EQ(rig.run(plant), Status::Solved) << rig.out.message;
  EXPECT_GT(rig.out.plans[0].clock_s, 0);

  BoxRun wrong;
  wrong.problem.q_goal = VectorXd::Zero(99);
  OwnClock other(wrong);
  EXPECT_NE(message_of([&] { (void)wrong.run(other); }).find("q_goal: got 99"), std::string::npos)
      << "a mistake is told by the thread of the caller";
}

/// Pushed aside by far more than the tolerance on its way: the piece is given up, and the way planned anew leads to the goal all the same.
TEST(Run, BoxPushedAside_IsPlannedAnewFromWhereItIs) {
  BoxRun rig;
  rig.world.pushes = {{.object = 0, .begin = 0.8, .duration = 0.5, .force_W = {0, 60, 0}}};
  ASSERT_EQ(rig.run(), Status::Solved) << rig.out.message;
  EXPECT_GE(rig.out.replans, 1);
  EXPECT_TRUE(std::any_of(rig.out.pieces.begin(), rig.out.pieces.end(), [](const RunPiece& p) { return p.given_up && p.off > 1; }));
  const Eigen::Index last = rig.out.q.cols() - 1;
  EXPECT_GT((rig.out.q.row(0).array() - rig.out.q(0, 0)).abs().maxCoeff(), 4 * rig.problem.goal.tol_position) << "it was not pushed aside";
  EXPECT_LE(error_of(rig, rig.out.q.col(last)), 1);
}

TEST(Run, GivenPlan_IsCarriedOutBeforeAnythingIsPlanned) {
  BoxRun rig;
  const planning::Plan plan = planning::test::push_up(rig.model);
  rig.problem.goal = plan.goal;
  SimulatedPlant plant(rig.model, plan.q_start, {});
  ASSERT_EQ(rig.run(plant, &plan), Status::Solved) << rig.out.message;
  EXPECT_TRUE(rig.out.plans.empty());
  EXPECT_EQ(rig.out.count(SegmentKind::Contact), 1);

  BoxRun elsewhere;
  elsewhere.problem.goal = plan.goal;
  elsewhere.problem.q_start[1] = 0.7;
  SimulatedPlant other(elsewhere.model, elsewhere.problem.q_start, {});
  ASSERT_EQ(elsewhere.run(other, &plan), Status::Solved) << elsewhere.out.message;
  EXPECT_EQ(elsewhere.out.plans.front().cause, "the given plan starts elsewhere");
}

/// Stops answering, or seeing the objects, after so many seconds, and keeps what it was told last.
class FailingPlant final : public Driver {
 public:
  enum class What {
    Read,
    Command,
    Objects,
    Clock,
    Jump,   ///< the objects are reported elsewhere
    Jumps,  ///< … and elsewhere in every look
    Aside   ///< … farther and farther away, until they are back at once
  };
  FailingPlant(const BoxRun& rig, What what, double after, double until = std::numeric_limits<double>::infinity())
      : inner(rig.model, rig.problem.q_start, {}), what_(what), after_(after), until_(until) {}
  bool read(Measurement& out) override {
    if (!inner.read(out)) return false;
    const bool failed = out.time > after_ && out.time < until_;
    if (failed && what_ == What::Jump) out.q[0] += 5;
    if (failed && what_ == What::Jumps) out.q[0] += 5 * (1 + std::fmod(1e3 * out.time, 7.0));
    if (failed && what_ == What::Aside) out.q[0] += 0.3 * (out.time - after_);
    if (failed && what_ == What::Objects) out.object_time = after_;
    if (failed && what_ == What::Clock) out.time = after_;
    return !(failed && what_ == What::Read);
  }
  bool command(VectorRef u, double period) override {
    if (what_ == What::Command && inner.world().time() > after_) return false;
    return inner.command(u, period);
  }
  std::string message() const override { return "cable unplugged"; }
  SimulatedPlant inner;

 private:
  What what_;
  double after_, until_;
};

TEST(Run, PlantThatStopsAnswering_EndsTheRunWithItsReason) {
  const std::pair<FailingPlant::What, std::string> cases[] = {{FailingPlant::What::Read, "does not answer: cable unplugged"},
                                                              {FailingPlant::What::Command, "takes no commands: cable unplugged"},
                                                              {FailingPlant::What::Objects, "objects were last seen"},
                                                              {FailingPlant::What::Clock, "clock of the plant stands still"},
                                                              {FailingPlant::What::Jumps, "reported where they cannot have got to"}};
  for (const auto& [what, words] : cases) {
    BoxRun rig;
    rig.how.absence = rig.how.silence;
    FailingPlant plant(rig, what, 0.7);
    EXPECT_EQ(rig.run(plant), Status::NumericalFailure);
    EXPECT_EQ(rig.out.end, RunEnd::Silent);
    EXPECT_NE(rig.out.message.find(words), std::string::npos) << rig.out.message;
    EXPECT_FALSE(rig.out.times.empty()) << "what was seen until then is kept";
    EXPECT_LT(plant.inner.world().time(), 0.7 + rig.how.silence + 0.01) << "no command after it";
  }
}

/// A tracker that loses the box for a tenth of a second, and says that it is 5 m aside.
TEST(Run, PoseThatJumpsForAMoment_IsNotBelieved) {
  BoxRun plain, rig;
  FailingPlant plant(rig, FailingPlant::What::Jump, 0.8, 0.9);
  ASSERT_EQ(plain.run(), Status::Solved);
  ASSERT_EQ(rig.run(plant), Status::Solved) << rig.out.message;
  EXPECT_EQ(rig.out.replans, plain.out.replans);
  EXPECT_LT((rig.out.q.row(0).array() - rig.out.q(0, 0)).abs().maxCoeff(), 1);
}

/// A person takes the box away on its way and puts it down elsewhere: a world with the box there goes on from the joints as they are then.
class PersonsPlant final : public Driver {
 public:
  /// @param away  for so long it is unseen [s]
  PersonsPlant(const BoxRun& rig, double taken, double away) : rig_(rig), taken_(taken), away_(away), plant_(make(rig.problem.q_start)) {}
  bool read(Measurement& out) override {
    if (!plant_->read(out)) return false;
    out.time += shift_, out.object_time += shift_;
    if (out.time > taken_ && out.time < taken_ + away_) out.object_time = taken_;
    return true;
  }
  bool command(VectorRef u, double period) override {
    if (!put_ && plant_->world().time() >= taken_ + away_) {
      put_ = true;
      shift_ = plant_->world().time();
      VectorXd q = plant_->world().q();
      q.head(3) << 1.2, 0.9, 0.3;
      plant_ = make(q);
    }
    largest_ = std::max(largest_, plant_->world().time() + shift_ > taken_ + rig_.how.silence + 0.01 && !put_ ? (u - last_).norm() : 0);
    last_ = u;
    return plant_->command(u, period);
  }
  double largest_ = 0;  ///< change of a command while the box was away

 private:
  std::unique_ptr<SimulatedPlant> make(const VectorXd& q) const { return std::make_unique<SimulatedPlant>(rig_.model, q, WorldOptions{}); }
  const BoxRun& rig_;
  double taken_, away_, shift_ = 0;
  bool put_ = false;
  std::unique_ptr<SimulatedPlant> plant_;
  VectorXd last_ = VectorXd::Zero(2);
};

TEST(Run, BoxThatAPersonTakesAwayAndPutsElsewhere_IsPushedFromThere) {
  for (const double away : {1e-3, 3.0}) {
    BoxRun rig;
    PersonsPlant plant(rig, 0.8, away);
    ASSERT_EQ(rig.run(plant), Status::Solved) << rig.out.message;
    const auto told = std::count_if(rig.out.plans.begin(), rig.out.plans.end(),
                                    [](const RunPlan& plan) { return plan.cause == "the object was put elsewhere"; });
    EXPECT_EQ(told, 1);
    ASSERT_GE(rig.out.plans.size(), 2U);
    EXPECT_GE(rig.out.plans[1].time, 0.8 + std::max(away, rig.how.silence)) << "nothing is planned from where it no more is";
    EXPECT_GT(rig.out.q.row(0).maxCoeff(), 1.1) << "it was put there";
    EXPECT_EQ(plant.largest_, 0) << "the robot holds while the box is away";
  }
}

/// A plant whose clock is not ours: a command of a tick takes it longer, or less long.
class OddClock final : public Driver {
 public:
  OddClock(const BoxRun& rig, double factor) : inner(rig.model, rig.problem.q_start, {}), factor_(factor) {}
  bool read(Measurement& out) override { return inner.read(out); }
  bool command(VectorRef u, double period) override { return inner.command(u, factor_ * period); }
  SimulatedPlant inner;

 private:
  double factor_;
};

TEST(Run, PlantWhoseClockIsFasterOrSlower_ReachesItsGoalInItsOwnTime) {
  for (const double factor : {0.6, 1.4}) {
    BoxRun rig;
    OddClock plant(rig, factor);
    ASSERT_EQ(rig.run(plant), Status::Solved) << factor << " " << rig.out.message;
    const auto& pieces = rig.out.pieces;
    BoxRun same;
    ASSERT_EQ(same.run(), Status::Solved);
    EXPECT_NEAR(pieces[0].end_s - pieces[0].begin_s, same.out.pieces[0].end_s - same.out.pieces[0].begin_s, 0.1) << factor;
  }
}

/// Something holds the robot for a while, so that its commands do nothing.
class HeldRobot final : public Driver {
 public:
  HeldRobot(const BoxRun& rig, double begin, double duration)
      : inner(rig.model, rig.problem.q_start, {}), begin_(begin), end_(begin + duration) {}
  bool read(Measurement& out) override {
    const bool there = inner.read(out);
    now_ = out.time;
    if (now_ < begin_) last_ = out.u;
    return there;
  }
  bool command(VectorRef u, double period) override {
    const bool held = now_ >= begin_ && now_ < end_;
    return inner.command(held ? VectorRef(last_) : u, period);
  }
  SimulatedPlant inner;

 private:
  double begin_, end_, now_ = 0;
  VectorXd last_;
};

/// Farthest that the plan goes from one look to the next [m].
double largest_stride(const RunResult& run) {
  double most = 0;
  for (const RunPiece& piece : run.pieces) {
    for (Eigen::Index k = 1; k < run.q_plan.cols(); ++k) {
      if (run.times[static_cast<std::size_t>(k - 1)] <= piece.begin_s || run.times[static_cast<std::size_t>(k)] >= piece.end_s) continue;
      most = std::max(most, (run.q_plan.col(k) - run.q_plan.col(k - 1)).norm());
    }
  }
  return most;
}

TEST(Run, RobotThatIsHeld_IsWaitedForAndSoIsWhatFollows) {
  const auto beside = [](BoxRun& rig) { rig.problem.q_start.tail<2>() << 1.0, 0.6; };  // it goes below the box first
  BoxRun free;
  beside(free);
  ASSERT_EQ(free.run(), Status::Solved);
  const RunPiece& move = free.out.pieces.at(0);
  const double begin = 0.75 * move.begin_s + 0.25 * move.end_s;

  BoxRun rig;
  beside(rig);
  HeldRobot plant(rig, begin, 1.5);
  ASSERT_EQ(rig.run(plant), Status::Solved) << rig.out.message;
  EXPECT_EQ(rig.out.replans, free.out.replans);
  EXPECT_GT(rig.out.pieces.at(1).end_s, free.out.pieces.at(1).end_s + 0.5);
  EXPECT_LT(largest_stride(rig.out), 1.5 * largest_stride(free.out)) << "what follows begins later by as much";

  BoxRun longer;
  beside(longer);
  HeldRobot stuck(longer, begin, 4);
  ASSERT_EQ(longer.run(stuck), Status::Solved) << longer.out.message;
  EXPECT_EQ(longer.out.plans.at(1).cause, "something held the robot up");
}

/// An object that is out of its goal for a while and comes back needs no plan, and no grip that is let go.
TEST(Run, ObjectThatComesBackToItsGoal_IsHeldOn) {
  BoxRun rig(0);
  FailingPlant plant(rig, FailingPlant::What::Aside, 0.5, 1.2);
  const VectorXd u = plant.inner.world().u();
  ASSERT_EQ(rig.run(plant), Status::Solved) << rig.out.message;
  double farthest = 0;
  for (Eigen::Index k = 0; k < rig.out.q.cols(); ++k) farthest = std::max(farthest, error_of(rig, rig.out.q.col(k)));
  EXPECT_GT(farthest, 2) << "it never left the goal: the test would say nothing";
  EXPECT_TRUE(rig.out.plans.empty());
  EXPECT_EQ(rig.out.replans, 0);
  EXPECT_GE(rig.out.duration_s, 1.2 + rig.how.hold) << "held for as long as asked, once it was back";
  EXPECT_LT((plant.inner.world().u() - u).cwiseAbs().maxCoeff(), 1e-12) << "the robot never moved";
}

/// A world in which something pushes the box out of its goal whenever the robot has brought it there.
class HostilePlant final : public Driver {
 public:
  explicit HostilePlant(const BoxRun& rig) : plant_(make_world(rig.model, {})), rig_(rig) {
    plant_.reset(rig.problem.q_start, rig.problem.q_start.tail(rig.model->n_a()));
  }
  bool read(Measurement& out) override {
    out.time = out.object_time = plant_.time();
    out.q = plant_.q(), out.u = plant_.u();
    return true;
  }
  bool command(VectorRef u, double period) override {
    const bool pushes = holds && error_of(rig_, plant_.q()) < 3;
    plant_.set_pushes(std::array{simulation::Push{.body = rig_.model->objects()[0].body, .force_W = {0, pushes ? 60.0 : 0.0, 0}}});
    return plant_.advance(u, period) == Status::Solved;
  }
  bool holds = false;  ///< the goal is being held

 private:
  simulation::SteppedPlant plant_;
  const BoxRun& rig_;
};

TEST(Run, PlansAfterTheFirst_AreBoundedWhateverCallsForThem) {
  for (const int replans : {0, 2}) {
    BoxRun rig;
    HostilePlant plant(rig);
    rig.how.replans = replans;
    rig.how.duration = 200;
    rig.how.on_sample = [&](const RunSample& sample) {
      plant.holds = sample.plans > 0 && sample.state == RunState::Hold && sample.goal_share <= 1;
    };
    EXPECT_EQ(rig.run(plant), Status::MaxIterations);
    EXPECT_EQ(rig.out.end, RunEnd::Replans) << rig.out.message;
    EXPECT_EQ(rig.out.replans, replans);
    EXPECT_EQ(std::count_if(rig.out.plans.begin(), rig.out.plans.end(), [](const RunPlan& p) { return p.cause[0] != 'n'; }), 1 + replans)
        << "plans, those that were asked for again because they were refused aside";
  }
}

// ---- goals in a row

/// The same goal, so much farther along y.
planning::PlanningProblem farther(const BoxRun& rig, double way) {
  planning::PlanningProblem out = rig.problem;
  out.goal.X_WG.p.z() += way;
  return out;
}

TEST(RunInARow, Goals_AreReachedAndHeldOneAfterAnother) {
  BoxRun rig;
  const std::vector<planning::PlanningProblem> goals{rig.problem, farther(rig, 0.1)};
  std::vector<int> seen;
  std::vector<double> shares;
  rig.how.on_sample = [&](const RunSample& sample) { seen.push_back(sample.goal), shares.push_back(sample.goal_share); };
  SimulatedPlant plant(rig.model, rig.problem.q_start, rig.world);
  ASSERT_EQ(execution::run(plant, goals, rig.planner, rig.how, rig.control, rig.out), Status::Solved) << rig.out.message;
  EXPECT_TRUE(rig.out.reached());
  EXPECT_EQ(rig.out.goals_reached(), 2);
  ASSERT_EQ(rig.out.goals.size(), 2U);
  const RunGoal &one = rig.out.goals[0], &two = rig.out.goals[1];
  EXPECT_EQ(one.begin_s, 0);
  EXPECT_EQ(two.begin_s, one.end_s);
  EXPECT_NEAR(two.end_s, rig.out.duration_s, rig.how.watch_interval);
  EXPECT_EQ(one.replans + two.replans, rig.out.replans);
  EXPECT_LE(planning::goal_error(*rig.model, plant.world().q(), goals[1].goal).share(goals[1].goal), 1);
  EXPECT_GT(planning::goal_error(*rig.model, plant.world().q(), goals[0].goal).share(goals[0].goal), 4)
      << "the goals are one: the test would say nothing";
  EXPECT_TRUE(std::is_sorted(seen.begin(), seen.end()));
  for (std::size_t k = 0; k < seen.size(); ++k) {
    const RunGoal& goal = rig.out.goals[static_cast<std::size_t>(seen[k])];
    const bool holds = rig.out.times[k] > goal.end_s - rig.how.hold && rig.out.times[k] < goal.end_s;
    EXPECT_TRUE(!holds || shares[k] <= 1) << k;
  }
  const auto next =
      std::find_if(rig.out.plans.begin(), rig.out.plans.end(), [](const RunPlan& plan) { return plan.cause == "the next goal"; });
  ASSERT_NE(next, rig.out.plans.end());
  EXPECT_GE(next->time, one.end_s);
  EXPECT_FALSE(next->joined) << "the plan before led to another goal";
}

TEST(RunInARow, GivenPlan_IsToTheFirstOfThem) {
  BoxRun rig;
  const planning::Plan plan = planning::test::push_up(rig.model);
  rig.problem.goal = plan.goal;
  const std::vector<planning::PlanningProblem> goals{rig.problem, farther(rig, 0.1)};
  SimulatedPlant plant(rig.model, plan.q_start, {});
  ASSERT_EQ(execution::run(plant, goals, rig.planner, rig.how, rig.control, rig.out, &plan), Status::Solved) << rig.out.message;
  ASSERT_FALSE(rig.out.plans.empty());
  EXPECT_EQ(rig.out.pieces.front().plan, -1);
  EXPECT_GE(rig.out.plans.front().time, rig.out.goals[0].end_s) << "nothing was planned for the first";
}

/// Plans after the first one count for each goal by itself, and each goal has a first one.
TEST(RunInARow, GoalThatIsNotReached_EndsTheRunAfterTheOneBefore) {
  BoxRun rig;
  const std::vector<planning::PlanningProblem> goals{rig.problem, farther(rig, 1e3), farther(rig, 0.1)};
  rig.planner.max_iterations = 100;
  rig.how.replans = 1;
  rig.how.refusals = 1;
  SimulatedPlant plant(rig.model, rig.problem.q_start, rig.world);
  EXPECT_EQ(execution::run(plant, goals, rig.planner, rig.how, rig.control, rig.out), Status::MaxIterations);
  EXPECT_FALSE(rig.out.reached());
  EXPECT_EQ(rig.out.goals_reached(), 1);
  ASSERT_EQ(rig.out.goals.size(), 2U) << "the third was not begun";
  EXPECT_TRUE(rig.out.goals[0].reached);
  EXPECT_FALSE(rig.out.goals[1].reached);
  EXPECT_GT(rig.out.goals[1].error.position, 100);
  EXPECT_EQ(rig.out.error.position, rig.out.goals[1].error.position) << "of the goal on the way to which the run ended";
  EXPECT_EQ(rig.out.message.rfind("goal 2 of 3: ", 0), 0U) << rig.out.message;
}

TEST(RunInARow, TimeIsThatOfAllGoals) {
  BoxRun whole;
  const std::vector<planning::PlanningProblem> goals{whole.problem, farther(whole, 0.1)};
  SimulatedPlant plant(whole.model, whole.problem.q_start, whole.world);
  ASSERT_EQ(execution::run(plant, goals, whole.planner, whole.how, whole.control, whole.out), Status::Solved) << whole.out.message;
  BoxRun rig;
  rig.how.duration = whole.out.goals[0].end_s + 0.3;
  SimulatedPlant other(rig.model, rig.problem.q_start, rig.world);
  EXPECT_EQ(execution::run(other, goals, rig.planner, rig.how, rig.control, rig.out), Status::MaxIterations);
  EXPECT_EQ(rig.out.end, RunEnd::TimeUp);
  EXPECT_EQ(rig.out.goals_reached(), 1);
  EXPECT_EQ(rig.out.goals[0].end_s, whole.out.goals[0].end_s) << "the same as without the limit";
  EXPECT_EQ(rig.out.message, fmt::format("goal 2 of 2: not reached within {:g} s", rig.how.duration));
}

/// A ball that lies at the first goal is held there, and then a blow throws it out of the hand while the planner works on the second.
TEST(RunInARow, ObjectThatFallsInBetween_EndsTheRunWithTheGoalsBefore) {
  BoxRun rig;
  rig.model = load_model("allegro_ball");
  rig.problem.model = rig.model;
  rig.problem.q_start = planning::test::allegro_start();
  rig.problem.goal.X_WG = world::object_pose(*rig.model, rig.problem.q_start, 0);
  rig.planner = {};
  rig.planner.max_iterations = 20;
  rig.how.plan_step_time = 1;  // the clock goes on for long
  rig.how.finger_gait = false;
  planning::PlanningProblem turned = rig.problem;
  turned.goal.X_WG.R = Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitZ()).toRotationMatrix() * turned.goal.X_WG.R;
  rig.world.pushes = {{.object = 0, .begin = 1.5, .duration = 0.1, .force_W = {0.3, 0, 0}}};
  SimulatedPlant plant(rig.model, rig.problem.q_start, rig.world);
  EXPECT_EQ(execution::run(plant, std::vector{rig.problem, turned}, rig.planner, rig.how, rig.control, rig.out), Status::MaxIterations);
  EXPECT_EQ(rig.out.end, RunEnd::Dropped) << rig.out.message;
  EXPECT_EQ(rig.out.goals_reached(), 1);
  EXPECT_EQ(rig.out.dropped, 0);
  EXPECT_EQ(rig.out.message, fmt::format("goal 2 of 2: '{}' fell", rig.model->objects()[0].name));
}

/// Without a hold a goal counts as soon as the object is seen there, on its way as well; what it has still to be pushed is left.
TEST(RunInARow, GoalThatNeedNotBeHeld_CountsOnTheWay) {
  BoxRun held, rig;
  held.how.hold = 0.5, rig.how.hold = 0;
  const std::vector<planning::PlanningProblem> goals{rig.problem, farther(rig, 0.1)};
  for (BoxRun* each : {&held, &rig}) {
    SimulatedPlant plant(each->model, each->problem.q_start, each->world);
    ASSERT_EQ(execution::run(plant, goals, each->planner, each->how, each->control, each->out), Status::Solved) << each->out.message;
    for (const RunGoal& goal : each->out.goals) EXPECT_LE(goal.error.share(each->problem.goal), 1);
  }
  EXPECT_LT(rig.out.goals[0].end_s, held.out.goals[0].end_s - held.how.hold);
  const auto first_inside = [&](std::size_t goal) {
    for (std::size_t k = 0; k < rig.out.times.size(); ++k) {
      if (goal > 0 && rig.out.times[k] <= rig.out.goals[goal - 1].end_s) continue;
      if (planning::goal_error(*rig.model, rig.out.q.col(static_cast<Eigen::Index>(k)), goals[goal].goal).within(goals[goal].goal))
        return rig.out.times[k];
    }
    return -1.0;
  };
  EXPECT_EQ(rig.out.goals[0].end_s, first_inside(0));
  EXPECT_EQ(rig.out.goals[1].end_s, first_inside(1));
  EXPECT_LE(rig.out.duration_s, held.out.duration_s - 2 * held.how.hold);
}

TEST(RunInARow, Mistakes_AreNamed) {
  BoxRun rig;
  SimulatedPlant plant(rig.model, rig.problem.q_start, {});
  const auto complaint = [&](const std::vector<planning::PlanningProblem>& goals) {
    return message_of([&] { (void)execution::run(plant, goals, rig.planner, rig.how, rig.control, rig.out); });
  };
  EXPECT_EQ(complaint({}), "goals: got none, expected at least one");
  planning::PlanningProblem wrong = rig.problem;
  wrong.goal.object = 7;
  EXPECT_EQ(complaint({rig.problem, wrong}), "goals[1].object: got 7, expected the index of an object");
  wrong.model = load_model("allegro_ball");
  EXPECT_EQ(complaint({rig.problem, wrong}), "goals[1]: got another model, expected that of the first one");
}

// ---- pushes from outside

/// The box of BoxRun after 1 s with its robot at rest.
VectorXd after_pushes(std::vector<OutsidePush> pushes, double tick = 1e-3) {
  BoxRun rig;
  rig.world.pushes = std::move(pushes);
  SimulatedPlant plant(rig.model, rig.problem.q_start, rig.world);
  const VectorXd u = plant.world().u();
  while (plant.world().time() < 1 - 0.5 * tick) EXPECT_TRUE(plant.command(u, tick)) << plant.message();
  return plant.world().q();
}

TEST(OutsidePushes, EachActsInItsTimeWhateverOthersThereAre) {
  const OutsidePush first{.object = 0, .begin = 0.1, .duration = 0.3, .force_W = {0, 30, 0}};
  const OutsidePush later{.object = 0, .begin = 5, .duration = 1, .force_W = {0, 0, 30}};
  const VectorXd still = after_pushes({}), alone = after_pushes({first});
  ASSERT_GT((alone - still).norm(), 0.02) << "the push does nothing: the test would say nothing";
  EXPECT_EQ(after_pushes({first, later}), alone);
  EXPECT_EQ(after_pushes({later, first}), alone);
}

TEST(OutsidePushes, HeldWhileTheLoopRuns_AreThoseOfTheOptions) {
  const OutsidePush known{.object = 0, .begin = 0.1, .duration = 0.3, .force_W = {0, 30, 0}};
  BoxRun rig;
  SimulatedPlant plant(rig.model, rig.problem.q_start, rig.world);
  const VectorXd u = plant.world().u();
  simulation::Push hand{.body = rig.model->objects()[0].body, .p_BP = rig.model->scene().objects[0].p_BCom, .force_W = known.force_W};
  const auto advance = [&](double until) {
    while (plant.world().time() < until - 0.5e-3) ASSERT_TRUE(plant.command(u, 1e-3)) << plant.message();
  };
  advance(0.1);
  plant.hold_push(hand);
  advance(0.4);
  hand.force_W.setZero();
  plant.hold_push(hand);
  advance(1);
  EXPECT_EQ(plant.world().q(), after_pushes({known}));
  hand.body = 1000;
  EXPECT_THROW(plant.hold_push(hand), core::InvalidInput);
}

TEST(OutsidePushes, ThatOverlap_AddUp) {
  OutsidePush push{.object = 0, .begin = 0.1, .duration = 0.3, .force_W = {0, 15, 0}};
  OutsidePush twice = push, back = push;
  twice.force_W *= 2, back.force_W *= -1;
  EXPECT_LT((after_pushes({push, push}) - after_pushes({twice})).norm(), 1e-12);
  EXPECT_LT((after_pushes({push, back}) - after_pushes({})).norm(), 1e-12);
  back.begin = 0.25, back.duration = 0.15;
  push.duration = 0.15;
  EXPECT_LT((after_pushes({push, push, back, back}) - after_pushes({push, back, push, back})).norm(), 1e-12) << "in any order";
  EXPECT_GT((after_pushes({push, back}) - after_pushes({push})).norm(), 1e-3);
}

TEST(OutsidePushes, ThatAreShorterThanATick_GiveTheirMomentum) {
  const OutsidePush blow{.object = 0, .begin = 0.1003, .duration = 0.0005, .force_W = {0, 2000, 0}};
  const OutsidePush same{.object = 0, .begin = 0.1, .duration = 0.001, .force_W = {0, 1000, 0}};
  EXPECT_LT((after_pushes({blow}) - after_pushes({same})).norm(), 1e-12);
  EXPECT_GT((after_pushes({blow}) - after_pushes({})).norm(), 1e-3);
}

TEST(Run, InterruptedRun_HoldsTheLastCommand) {
  BoxRun rig;
  std::atomic<bool> cancel{false};
  rig.control.cancel = &cancel;
  VectorXd last;
  rig.how.on_sample = [&](const RunSample& sample) {
    last = sample.u;
    if (sample.state == RunState::Push && sample.time > 0.8) cancel = true;
  };
  SimulatedPlant plant(rig.model, rig.problem.q_start, rig.world);
  EXPECT_EQ(rig.run(plant), Status::Cancelled);
  EXPECT_EQ(rig.out.end, RunEnd::Cancelled);
  EXPECT_LT((plant.world().u() - last).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_EQ(rig.out.q.cols(), static_cast<Eigen::Index>(rig.out.times.size()));
}

TEST(Run, BudgetsThatAreUsedUp_AreTold) {
  BoxRun rig;
  rig.how.duration = 0.5;
  EXPECT_EQ(rig.run(), Status::MaxIterations);
  EXPECT_EQ(rig.out.end, RunEnd::TimeUp);
  BoxRun late;
  late.control.deadline = core::RunControl::Clock::now();
  EXPECT_EQ(late.run(), Status::MaxIterations);
  EXPECT_EQ(late.out.end, RunEnd::Deadline);
}

/// A ball that lies in the open hand at its goal is pushed aside: it stays where fingers close on it, and rolls out where commands rest.
TEST(Run, FreeObjectThatMovesWhileNothingIsCarriedOut_IsCaught) {
  for (const bool active : {true, false}) {
    BoxRun rig;
    rig.model = load_model("allegro_ball");
    rig.problem.model = rig.model;
    rig.problem.q_start = planning::test::allegro_start();
    rig.problem.goal.X_WG = world::object_pose(*rig.model, rig.problem.q_start, 0);
    rig.problem.goal.tol_position = 0.01;
    rig.planner = {};
    rig.how.active_hold = active;
    rig.how.hold = 3;
    rig.how.plan_processor_time = 1e-9;
    rig.world.pushes = {{.object = 0, .begin = 0.3, .duration = 0.1, .force_W = {0.15, 0, 0}}};
    const Status status = rig.run();
    EXPECT_EQ(status, active ? Status::Solved : Status::MaxIterations) << rig.out.message;
    EXPECT_TRUE(!active || rig.out.plans.empty());
    const double farthest = (rig.out.q.topRows<3>().colwise() - rig.problem.q_start.head<3>()).colwise().norm().maxCoeff();
    EXPECT_EQ(farthest < 0.01, active) << farthest;
  }
}

/// A plan that begins elsewhere: it leads on from where the box is, and nothing is searched.
TEST(Run, PlanThatLeadsOnFromWhereThingsAre_IsGoneOnWith) {
  for (const bool join : {true, false}) {
    BoxRun rig;
    const planning::Plan plan = planning::test::push_up(rig.model);
    rig.problem.goal = plan.goal;
    rig.how.join = join;
    rig.how.friction = 1;  // of the given plan
    VectorXd lower = plan.q_start;
    lower[1] -= 0.015, lower[4] -= 0.015;
    SimulatedPlant plant(rig.model, lower, rig.world);
    ASSERT_EQ(rig.run(plant, &plan), Status::Solved) << rig.out.message;
    ASSERT_FALSE(rig.out.plans.empty());
    EXPECT_EQ(rig.out.plans[0].cause, "the given plan starts elsewhere");
    EXPECT_EQ(rig.out.plans[0].joined, join);
    EXPECT_EQ(rig.out.first_plan.has_value(), !join || rig.out.plans.size() > 1);
  }
}

/// A ball in the air over a hand falls, and nobody plans for what falls.
TEST(Run, FallingObject_EndsTheRun) {
  BoxRun rig;
  rig.model = load_model("allegro_ball");
  rig.problem.model = rig.model;
  rig.problem.q_start = planning::test::allegro_start();
  rig.problem.q_start[0] = 0.4;  // beside it
  rig.problem.goal.X_WG = world::object_pose(*rig.model, rig.problem.q_start, 0);
  rig.problem.goal.X_WG.p.x() = -0.08;
  rig.planner = {};
  EXPECT_EQ(rig.run(), Status::MaxIterations);
  EXPECT_EQ(rig.out.end, RunEnd::Dropped) << rig.out.message;
  EXPECT_EQ(rig.out.dropped, 0);
  EXPECT_TRUE(rig.out.plans.empty()) << "it fell before anything was planned";
  const double L = rig.model->scales().object(0).length, fallen = rig.out.q(2, 0) - rig.out.q(2, rig.out.q.cols() - 1);
  EXPECT_GE(fallen, L);
  EXPECT_LT(fallen, 1.5 * L) << "and the run ended at once";
}

/// A ball that hangs three lengths above the ground comes down first, and the run goes on with it there.
TEST(Run, ObjectAboveItsSupport_ComesDownAndIsNotDropped) {
  BoxRun rig;
  world::Scene scene = load_model("allegro_ball")->scene();
  Eigen::VectorXd q = planning::test::allegro_start();
  q[0] = 0.4;  // beside the hand
  const double radius = std::get<world::Sphere>(scene.objects[0].geometries[0].shape).radius;
  world::FixedSpec ground;
  ground.name = "ground";
  ground.X_WB.p.z() = q[2] - 4 * radius;
  ground.geometries.push_back({.name = "plane", .shape = world::HalfSpace{}, .X_BG = {}, .friction = 1.0});
  scene.fixed.push_back(ground);
  rig.model = rig.problem.model = world::Model::make(scene);
  rig.problem.q_start = q;
  rig.problem.goal.X_WG = world::object_pose(*rig.model, q, 0);
  rig.problem.goal.X_WG.p += Eigen::Vector3d(-0.2, 0, 0.1);
  rig.planner = {};
  rig.planner.max_iterations = 3;
  rig.how.duration = 2;
  EXPECT_EQ(rig.run(), Status::MaxIterations);
  EXPECT_NE(rig.out.end, RunEnd::Dropped) << rig.out.message;
  EXPECT_FALSE(rig.out.plans.empty());
  EXPECT_NEAR(rig.out.q(2, rig.out.q.cols() - 1), q[2] - 3 * radius, 1e-3);
}

/// A plan without the time for one is a plan that found nothing, and nobody's wish to stop.
TEST(Run, PlansHaveTheirTimeOfProcessorsAndNoMore) {
  BoxRun rig;
  rig.how.plan_processor_time = 1e-9;
  EXPECT_EQ(rig.run(), Status::MaxIterations);
  EXPECT_EQ(rig.out.end, RunEnd::NoPlan) << rig.out.message;
  ASSERT_EQ(rig.out.plans.size(), static_cast<std::size_t>(rig.how.refusals));
  for (const RunPlan& plan : rig.out.plans) EXPECT_EQ(plan.status, Status::MaxIterations);

  BoxRun enough;
  enough.how.plan_processor_time = 1e3;
  ASSERT_EQ(enough.run(), Status::Solved) << enough.out.message;
  EXPECT_GT(enough.out.plans.front().processor_s, 0);
}

TEST(Run, Mistakes_AreNamed) {
  BoxRun rig;
  SimulatedPlant plant(rig.model, rig.problem.q_start, {});
  const auto complaint = [&](auto change) {
    BoxRun wrong;
    change(wrong);
    return message_of([&] { (void)wrong.run(plant); });
  };
  EXPECT_EQ(complaint([](BoxRun& r) { r.how.tick = 0; }), "tick: got 0, expected a finite number > 0");
  EXPECT_EQ(complaint([](BoxRun& r) { r.how.watch_interval = 1e-4; }), "watch_interval: got 0.0001 s, expected at least a tick of 0.001 s");
  EXPECT_EQ(complaint([](BoxRun& r) { r.how.plan_fraction = 1.5; }), "plan_fraction: got 1.5, expected a number in (0, 1]");
  EXPECT_EQ(complaint([](BoxRun& r) { r.how.friction = 0; }), "friction: got 0, expected a number in (0, 1]");
  EXPECT_EQ(complaint([](BoxRun& r) { r.how.plan_processor_time = 0; }), "plan_processor_time: got 0, expected a finite number > 0");
  EXPECT_EQ(complaint([](BoxRun& r) { r.how.absence = 0.1; }), "absence: got 0.1 s, expected at least the silence of 0.5 s");
  EXPECT_EQ(complaint([](BoxRun& r) { r.how.planning_rate = -1; }), "planning_rate: got -1, expected a finite number ≥ 0");
  EXPECT_EQ(complaint([](BoxRun& r) { r.how.plan_step_time = 0; }), "plan_step_time: got 0, expected a finite number > 0");
  EXPECT_EQ(complaint([](BoxRun& r) { r.how.replans = -1; }), "replans: got -1, expected 0 or more");
  EXPECT_EQ(complaint([](BoxRun& r) { r.problem.goal.object = 3; }), "goal.object: got 3, expected the index of an object");
  const auto world = [&](const WorldOptions& options) { return message_of([&] { (void)make_world(rig.model, options); }); };
  EXPECT_EQ(world({.mass = 0}), "world.mass: got 0, expected a finite number > 0");
  EXPECT_EQ(world({.pushes = {{.object = 2, .duration = 1}}}), "world.push.object: got 2, expected the index of an object");
  EXPECT_EQ(world({.pushes = {{.object = 0, .duration = 0}}}), "world.push.duration: got 0, expected a finite number > 0");
}

// ---- parts

/// v² = 2 μ g s_L L, and no joint faster than its motor (E.13).
TEST(RunSpeed, FollowsFromFrictionAndSizeAndTheFileOfTheRobot) {
  const auto cube = load_model("allegro_cube");
  const RunSpeeds speed = calc_run_speeds(*cube, 0);
  const double L = cube->scales().object(0).length;
  EXPECT_NEAR(speed.object, std::sqrt(2 * 1.0 * 9.81 * 0.05 * L), 1e-12);
  EXPECT_NEAR(speed.push[0] * cube->reach()[0], speed.object, 1e-12);
  EXPECT_EQ(speed.most, VectorXd::Constant(16, 10.0)) << "velocity in models/allegro_hand.urdf";
  EXPECT_EQ(calc_follow_time(*cube, 0), 0);

  const auto box = load_model("planar_pushing");  // 5 kg, damped by m/τ, at the end of a spring of 100 N/m
  EXPECT_NEAR(calc_follow_time(*box, 0), 5 / (0.05 * 100), 1e-12);
  EXPECT_NEAR(calc_run_speeds(*box, 0).push[0], 0.05 * box->scales().object(0).length / (0.05 + 0.3 * 1), 1e-12);
  EXPECT_EQ(load_model("iiwa_bimanual")->speed_limit()[0], 1.71);
}

TEST(ObjectWatch, MovingObject_DoesNotRestAndItsMeanIsInTheMiddle) {
  BoxRun rig;
  ObjectWatch still(*rig.model, rig.problem.goal, 0.1, 0.05), moving(*rig.model, rig.problem.goal, 0.1, 0.1);
  VectorXd q = rig.problem.q_start;
  for (int k = 0; k <= 10; ++k) {
    still.add(0.01 * k, rig.problem.q_start);
    q[0] = 0.01 * k;
    moving.add(0.01 * k, q);
    EXPECT_EQ(still.rests(), k >= 5) << "only once the least window is full";
  }
  EXPECT_FALSE(moving.rests());
  EXPECT_NEAR(moving.mean()[0], 0.05, 1e-12);
}

TEST(ObjectWatch, MovingObject_IsExpectedWhereItsSpeedTakesIt) {
  BoxRun rig;
  ObjectWatch watch(*rig.model, rig.problem.goal, 0.1, 0.1);
  VectorXd q = rig.problem.q_start;
  watch.add(0, q);
  EXPECT_EQ(watch.expected(1), q) << "one look tells no speed";
  for (int k = 1; k <= 40; ++k) {
    q[0] = rig.problem.q_start[0] + 0.002 * k, q[2] = rig.problem.q_start[2] - 0.005 * k, q[3] = 0.01 * k;
    watch.add(0.01 * k, q);
  }
  const VectorXd ahead = watch.expected(2);
  EXPECT_NEAR(ahead[0] - watch.mean()[0], 0.2 * 2, 1e-9);
  EXPECT_NEAR(ahead[2] - watch.mean()[2], -0.5 * 2, 1e-9);
  EXPECT_EQ(ahead.tail(2), q.tail(2)) << "joints stay where they are";
}

/// What is too slow to be seen in a short window, or hidden by noise, is seen in a long one.
TEST(ObjectWatch, SpeedThatMattersIsLookedForInLongerWindows) {
  BoxRun rig;
  const double tolerance = rig.problem.goal.tol_position;
  for (const double speed : {0.0, 0.5, 2.0}) {  // tolerances in a second
    ObjectWatch watch(*rig.model, rig.problem.goal, 0.1, 0.05);
    VectorXd q = rig.problem.q_start;
    for (int k = 0; k <= 80; ++k) {
      const double noise = (k % 4 < 2 ? 0.3 : -0.3) * tolerance;  // whose mean is none over four looks
      q[0] = rig.problem.q_start[0] + speed * tolerance * 0.01 * k + (speed < 2 ? noise : 0);
      watch.add(0.01 * k, q);
    }
    EXPECT_EQ(watch.rests(1.0), speed < 1) << speed;
    EXPECT_EQ(watch.rests(0.1), speed == 0) << speed;
    EXPECT_FALSE(watch.is_carried());
  }
}

/// T_f makes windows that are no multiple of the time between looks.
TEST(ObjectWatch, WindowBetweenTwoLooks_IsCovered) {
  BoxRun rig;
  for (const double window : {0.1, 0.1002, 0.1099}) {
    ObjectWatch watch(*rig.model, rig.problem.goal, window, 0.05);
    VectorXd q = rig.problem.q_start;
    for (int k = 0; k <= 100; ++k) {
      EXPECT_EQ(watch.is_carried(), 0.01 * (k - 1) < window) << k << " looks, window of " << window;
      q[0] = rig.problem.q_start[0] + 0.5 * rig.problem.goal.tol_position * 0.01 * k;
      watch.add(0.01 * k, q);
    }
    EXPECT_FALSE(watch.rests(0.1)) << "it creeps";
    EXPECT_TRUE(watch.rests(1)) << "slowly enough";
  }
}

TEST(ObjectWatch, ObjectThatCameToRest_IsWhereItRestsAndNotWhereItCameThrough) {
  BoxRun rig;
  ObjectWatch watch(*rig.model, rig.problem.goal, 0.2, 0.05);
  VectorXd q = rig.problem.q_start;
  for (int k = 0; k <= 15; ++k) {
    q[0] = k < 10 ? 0.1 - 0.01 * k : 0;
    watch.add(0.01 * k, q);
    EXPECT_EQ(watch.rests(), k == 15) << k;
  }
  EXPECT_GT(watch.mean()[0], 0.02);
  watch.forget_motion();
  EXPECT_NEAR(watch.mean()[0], 0, 1e-12);
}

TEST(ShareOffPath, LaggingObject_IsOnThePathAndOneAsideIsNot) {
  BoxRun rig;
  const execution::Trajectory path = execution::make_trajectory(*rig.model, planning::test::push_up(rig.model), execution::SpeedLimits{});
  const double end = path.duration();
  VectorXd q(5);
  execution::interpolate(*rig.model, path, 0.7 * end, q);
  EXPECT_LT(share_off_path(*rig.model, path, 0.5 * end, end, 0.01, q, rig.problem.goal), 0.1) << "late, but on its way";
  q[0] += 0.15;
  EXPECT_NEAR(share_off_path(*rig.model, path, 0.5 * end, end, 0.01, q, rig.problem.goal), 3, 0.05) << "shares of 0.05 L";
  rig.problem.goal.tol_position = 0.1;
  EXPECT_NEAR(share_off_path(*rig.model, path, 0.5 * end, end, 0.01, q, rig.problem.goal), 1.5, 0.05);
}

}  // namespace
}  // namespace stiction::execution::test
