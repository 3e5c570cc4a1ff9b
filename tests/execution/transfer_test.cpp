#include "stiction/execution/open_loop/transfer.hpp"

#include <atomic>

#include "planning/push_plan.hpp"
#include "stiction/core/invalid_input.hpp"
#include "stiction/world/scales.hpp"
#include "support/message_of.hpp"

namespace stiction::execution::test {
namespace {

using core::Status;
using Eigen::VectorXd;
using planning::test::load_model;
using planning::test::push_plan;
using planning::test::push_up;
using stiction::test::message_of;

// ---- Δ and L

/// States of the ball of allegro_ball: straight along x by `length` while it turns by `angle` about z.
Eigen::MatrixXd ball_path(int n, double length, double angle) {
  Eigen::MatrixXd q = Eigen::MatrixXd::Zero(23, n);
  for (int k = 0; k < n; ++k) {
    const double s = static_cast<double>(k) / (n - 1);
    q(0, k) = s * length;
    q(5, k) = std::sin(0.5 * s * angle), q(6, k) = std::cos(0.5 * s * angle);
  }
  return q;
}

VectorXd even_times(int n, double end) { return VectorXd::LinSpaced(n, 0, end); }

TEST(Measure, PathAgainstItself_IsZero) {
  const auto model = load_model("allegro_ball");
  const auto q = ball_path(11, 0.2, 1.0);
  const PieceError e = measure(*model, 0, even_times(11, 3), q, q, q);
  EXPECT_EQ(e.mean_position, 0);
  EXPECT_NEAR(e.mean_angle, 0, 1e-12);
  EXPECT_NEAR(e.length_position, 0.2, 1e-12);
  EXPECT_NEAR(e.length_angle, 1.0, 1e-12);
  EXPECT_NEAR(*e.normalised_position(), 0, 1e-12);
}

TEST(Measure, ShiftedAndTurnedPath_GivesTheShiftAndTheAngle) {
  const auto model = load_model("allegro_ball");
  const auto plan = ball_path(21, 0.2, 1.0);
  Eigen::MatrixXd sim = plan;
  for (Eigen::Index k = 0; k < sim.cols(); ++k) {
    sim.col(k).head<3>() += Eigen::Vector3d(0.003, 0, -0.004);
    const Eigen::Quaterniond r =
        Eigen::Quaterniond(sim(6, k), sim(3, k), sim(4, k), sim(5, k)) * Eigen::AngleAxisd(0.07, Eigen::Vector3d(1, 2, 2) / 3);
    sim.col(k).segment<4>(3) = -r.coeffs();  // the other quaternion of the same rotation
  }
  const PieceError e = measure(*model, 0, even_times(21, 5), plan, sim, plan);
  EXPECT_NEAR(e.mean_position, 0.005, 1e-12);
  EXPECT_NEAR(e.mean_angle, 0.07, 1e-9);
  EXPECT_NEAR(*e.normalised_position(), 0.025, 1e-9);
  EXPECT_NEAR(*e.normalised_angle(), 0.07, 1e-9);
  EXPECT_NEAR(e.start_position, 0.005, 1e-12);
  EXPECT_NEAR(e.end_angle, 0.07, 1e-9);
}

/// d grows linearly from 0 to 0.1 m, sampled unevenly: the mean is half of it.
TEST(Measure, GrowingError_IsAveragedOverTimeNotOverSamples) {
  const auto model = load_model("allegro_ball");
  const VectorXd times = (VectorXd(5) << 0, 0.1, 0.2, 0.3, 2).finished();
  Eigen::MatrixXd plan = Eigen::MatrixXd::Zero(23, 5);
  plan.row(6).setOnes();
  Eigen::MatrixXd sim = plan;
  sim.row(1) = 0.05 * times.transpose();
  const PieceError e = measure(*model, 0, times, plan, sim, plan);
  EXPECT_NEAR(e.mean_position, 0.05, 1e-12);
  EXPECT_NEAR(e.end_position, 0.1, 1e-12);
  EXPECT_FALSE(e.normalised_position()) << "the plan does not move the object";
}

// ---- the run

struct BoxTransfer {
  explicit BoxTransfer(double rest_time = 0.05) {
    simulation::PlantOptions plant_options;
    plant_options.rest_time = rest_time;
    plant = simulation::Plant::make(model, plant_options);
    options.uniform = SpeedLimits{.prismatic = 0.05};
    options.hold = 4;
  }
  Status run(TransferResult& out) { return transfer(plant, plan, options, control, out); }

  std::shared_ptr<const world::Model> model = load_model("planar_pushing");
  std::shared_ptr<const simulation::Plant> plant;
  planning::Plan plan = push_up(model);
  TransferOptions options;
  core::RunControl control;
};

/// Pushed through its centre the box goes where the plan says, once what brings it to rest has worn off: its damping D = M/τ = 100 N s/m is that of
/// a spring-damper of time constant D/K = 1 s. Lag at constant speed: D v / K = 50 mm.
TEST(Transfer, StraightPush_ReachesTheGoalWithTheLagOfTheDamping) {
  BoxTransfer rig;
  TransferResult r;
  ASSERT_EQ(rig.run(r), Status::Solved) << r.message;
  EXPECT_TRUE(r.reached);
  EXPECT_LT(r.error.position, 3e-3);
  ASSERT_EQ(r.pieces.size(), 1u);
  EXPECT_GT(r.pieces[0].in_plan->length_position, 0.15);
  EXPECT_NEAR(r.pieces[0].in_plan->end_position, 0.05, 0.01);
  EXPECT_LT(r.max_depth, 1e-3);
  EXPECT_FALSE(r.dropped);
  ASSERT_TRUE(r.pieces[0].alone);
  EXPECT_NEAR(r.pieces[0].alone->mean_position, r.pieces[0].in_plan->mean_position, 1e-9) << "the first piece starts as the plan does";
}

/// The box lies 1 cm aside and turned, or where the hand is: then it begins beside the hand.
TEST(Transfer, StartError_MovesTheObjectAndNothingOverlaps) {
  BoxTransfer rig;
  rig.options.alone = false;
  rig.options.hold = 0;
  rig.options.start_error = Eigen::Vector3d(0.01, 0.003, 0.02);
  TransferResult r;
  ASSERT_EQ(rig.run(r), Status::Solved) << r.message;
  const VectorXd start = r.q_plan.col(0);
  EXPECT_NEAR((r.q.col(0).head<3>() - start.head<3>() - rig.options.start_error).norm(), 0, 1e-12);
  EXPECT_EQ(r.q.col(0).tail<2>(), start.tail<2>());
  rig.options.start_error = Eigen::Vector3d(0, -0.1, 0);
  ASSERT_EQ(rig.run(r), Status::Solved) << r.message;
  EXPECT_LT(r.max_depth, 2e-3) << "the box begins 0.1 m deep in the hand, had it not been moved away";
  rig.options.start_error = VectorXd::Zero(2);
  EXPECT_EQ(message_of([&] { (void)rig.run(r); }), "start_error: got 2 numbers, expected 3");
}

TEST(Transfer, SlowerRun_HasLessLag) {
  BoxTransfer rig;
  TransferResult fast, slow;
  ASSERT_EQ(rig.run(fast), Status::Solved);
  rig.options.uniform->prismatic = 0.0125;
  rig.options.alone = false;
  ASSERT_EQ(rig.run(slow), Status::Solved);
  EXPECT_LT(slow.pieces[0].in_plan->mean_position, 0.4 * fast.pieces[0].in_plan->mean_position);
  EXPECT_NEAR(slow.duration_s - rig.options.hold, 4 * (fast.duration_s - rig.options.hold), 1e-6);
  EXPECT_FALSE(slow.pieces[0].alone);
}

TEST(Transfer, SameInput_SameBitsForAnyNumberOfThreads) {
  BoxTransfer rig;
  rig.options.hold = 0.1;
  TransferResult a, b;
  rig.options.threads = 1;
  ASSERT_EQ(rig.run(a), Status::Solved);
  rig.options.threads = 3;
  ASSERT_EQ(rig.run(b), Status::Solved);
  EXPECT_EQ(a.q, b.q);
  EXPECT_EQ(a.pieces[0].alone->mean_position, b.pieces[0].alone->mean_position);
  EXPECT_EQ(a.steps, b.steps);
}

TEST(Transfer, PiecesAlone_NeedNoWholeRun) {
  BoxTransfer rig;
  TransferResult both, alone;
  ASSERT_EQ(rig.run(both), Status::Solved);
  rig.options.whole = false;
  ASSERT_EQ(rig.run(alone), Status::Solved);
  ASSERT_EQ(alone.pieces.size(), both.pieces.size());
  EXPECT_FALSE(alone.pieces[0].in_plan);
  EXPECT_FALSE(alone.reached);
  EXPECT_EQ(alone.pieces[0].alone->mean_position, both.pieces[0].alone->mean_position);
  EXPECT_LT(alone.steps, both.steps);
}

TEST(Transfer, StoppedRuns_KeepWhatTheyHave) {
  BoxTransfer rig;
  TransferResult r;
  const std::atomic<bool> cancel{true};
  rig.control.cancel = &cancel;
  EXPECT_EQ(rig.run(r), Status::Cancelled);
  EXPECT_FALSE(r.reached);
  ASSERT_EQ(r.pieces.size(), 1u);
  EXPECT_FALSE(r.pieces[0].in_plan);
  rig.control.cancel = nullptr;
  rig.control.deadline = core::RunControl::Clock::now();
  EXPECT_EQ(rig.run(r), Status::MaxIterations);
  EXPECT_FALSE(r.reached);
}

/// The ball of the Allegro hand, held in the air by nothing, while one finger moves for half a second, in which the plan has the ball sink by so much [m].
struct Falling {
  std::shared_ptr<const world::Model> model = load_model("allegro_ball");
  planning::Plan plan;

  explicit Falling(double sinks) {
    plan.q_start = VectorXd::Zero(23);
    plan.q_start.head<3>() << 0.5, 0, 0.3;
    plan.q_start[6] = 1;
    plan.q_start[7 + 12] = 0.3;
    plan.u_start = plan.q_start.tail(16);
    VectorXd u = plan.u_start, q = plan.q_start;
    u[1] += 0.05, q[8] += 0.05, q[2] -= sinks;
    plan.segments = {{planning::SegmentKind::Contact, {{.u = u, .q = q, .contacts = {}}}}};
    plan.goal.X_WG = world::object_pose(*model, plan.q_start, 0);
    plan.goal.tol_position = 0.02;
  }

  TransferResult run(double hold) const {
    TransferOptions options;
    options.uniform.emplace();
    options.hold = hold;
    TransferResult r;
    EXPECT_EQ(transfer(simulation::Plant::make(model), plan, options, {}, r), Status::Solved) << r.message;
    return r;
  }
};

TEST(Transfer, ObjectThatFalls_IsReportedAsDropped) {
  const auto [model, plan] = Falling(0);
  TransferOptions options;
  options.uniform.emplace();
  options.hold = 0;
  TransferResult r;
  ASSERT_EQ(transfer(simulation::Plant::make(model), plan, options, {}, r), Status::Solved) << r.message;
  EXPECT_FALSE(r.reached);
  ASSERT_TRUE(r.dropped);
  EXPECT_EQ(*r.dropped, 0);
  const double L = model->scales().object(0).length;
  EXPECT_NEAR(r.dropped_s, std::sqrt(2 * L / 10), 0.02) << "free fall through the length of the ball";
  EXPECT_EQ(r.duration_s, r.dropped_s) << "and the run ends";
  ASSERT_EQ(r.pieces.size(), 1u);
  EXPECT_FALSE(r.pieces[0].in_plan);
  EXPECT_TRUE(r.pieces[0].alone);

  EXPECT_FALSE(r.lost) << "nobody asked";
  options.lost_factor = 1;  // 20 mm, before it has fallen by its length
  ASSERT_EQ(transfer(simulation::Plant::make(model), plan, options, {}, r), Status::Solved) << r.message;
  EXPECT_TRUE(r.lost);
  EXPECT_FALSE(r.reached || r.dropped);
  EXPECT_NEAR(r.duration_s, std::sqrt(2 * 0.02 / 10), 0.02);
  options.lost_factor = 2 * L / plan.goal.tol_position;
  ASSERT_EQ(transfer(simulation::Plant::make(model), plan, options, {}, r), Status::Solved) << r.message;
  EXPECT_TRUE(r.dropped) << "what comes first";
  EXPECT_FALSE(r.lost);
  options.lost_factor = 0;
  EXPECT_EQ(message_of([&] { (void)transfer(simulation::Plant::make(model), plan, options, {}, r); }),
            "lost_factor: got 0, expected a number > 0");
}

TEST(Transfer, ObjectThatComesDownSoonerThanPlanned_IsNotDropped) {
  const TransferResult early = Falling(2).run(0);
  EXPECT_FALSE(early.dropped) << "the plan has it farther down at the end of the piece";
  EXPECT_NEAR(early.duration_s, 0.5, 0.1);
  const TransferResult late = Falling(0.2).run(1);
  ASSERT_TRUE(late.dropped);
  const Falling falling(0.2);
  EXPECT_NEAR(late.dropped_s, std::sqrt(2 * (0.2 + falling.model->scales().object(0).length) / 10), 0.02)
      << "its length below the lowest place that it was to have";
}

TEST(Transfer, BadOptions_NameTheField) {
  BoxTransfer rig;
  TransferResult r;
  rig.options.hold = -1;
  EXPECT_NE(message_of([&] { (void)rig.run(r); }).find("hold"), std::string::npos);
  rig.options.hold = 1;
  rig.plan.goal.object = 4;
  EXPECT_NE(message_of([&] { (void)rig.run(r); }).find("plan.goal.object"), std::string::npos);
}

}  // namespace
}  // namespace stiction::execution::test
