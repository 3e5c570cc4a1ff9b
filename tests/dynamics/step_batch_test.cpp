#include "stiction/dynamics/step_batch.hpp"

#include <algorithm>
#include <atomic>
#include <limits>

#include "dynamics/systems.hpp"
#include "stiction/core/random.hpp"
#include "support/message_of.hpp"

namespace stiction::dynamics::test {
namespace {

using core::Status;
using Eigen::MatrixXd;

/// A pusher before a wall, from N places to N commands on both sides of it.
struct Pushes {
  explicit Pushes(int n) : q(2, n), u(2, n) {
    world::Scene scene = empty_scene();
    scene.robots.push_back(pusher(0));
    scene.fixed.push_back(half_space(Eigen::Vector3d::UnitZ(), {0, 0, -0.1}, 0.3));
    model = world::Model::make(scene);
    core::Random random(7, 0);
    for (int i = 0; i < n; ++i) {
      q.col(i) << 0.1 * random.normal(), 0.005 * std::abs(random.normal());
      u.col(i) << 0.1 * random.normal(), 0.02 * random.normal();
    }
  }
  StepBatchResult run(const StepOptions& options, int threads) const {
    StepBatchWorkspace work(model, threads);
    StepBatchResult out;
    EXPECT_EQ(step_batch(*model, {q, u}, options, work, out), Status::Solved);
    return out;
  }
  std::shared_ptr<const world::Model> model;
  MatrixXd q, u;
};

TEST(StepBatch, EqualsSingleSteps_BitForBitForAnyNumberOfThreads) {
  const Pushes pushes(77);  // not a multiple of what a thread takes at once
  const StepOptions options{.smoothing = Analytic{}, .with_B = true, .with_A = true};
  const StepBatchResult batch = pushes.run(options, 1), threaded = pushes.run(options, 3);
  StepWorkspace work(pushes.model);
  StepResult single;
  bool pushed = false;
  for (Eigen::Index i = 0; i < pushes.q.cols(); ++i) {
    work.forget();
    ASSERT_EQ(step(*pushes.model, {pushes.q.col(i), pushes.u.col(i)}, options, work, single), Status::Solved);
    EXPECT_EQ(batch.q_next.col(i), single.q_next) << i;
    EXPECT_EQ(batch.torque.col(i), single.torque) << i;
    const Eigen::Index n_v = single.A.rows(), n_a = single.B.cols();
    for (Eigen::Index r = 0; r < n_v; ++r) {
      for (Eigen::Index c = 0; c < n_v; ++c) EXPECT_EQ(batch.A(r * n_v + c, i), single.A(r, c));
      for (Eigen::Index c = 0; c < n_a; ++c) EXPECT_EQ(batch.B(r * n_a + c, i), single.B(r, c));
    }
    pushed = pushed || single.B(1, 1) < 0.9;
  }
  EXPECT_TRUE(pushed) << "no push met the wall";
  EXPECT_EQ(batch.q_next, threaded.q_next);
  EXPECT_EQ(batch.A, threaded.A);
  EXPECT_EQ(batch.B, threaded.B);
}

TEST(StepBatch, ExternalForce_MovesAsThatOfOneStep) {
  const Pushes pushes(33);
  MatrixXd tau(pushes.model->n_v(), pushes.q.cols());
  core::Random random(9, 0);
  for (double& value : tau.reshaped()) value = random.normal();
  StepBatchWorkspace batch_work(pushes.model, 2);
  StepBatchResult batch;
  ASSERT_EQ(step_batch(*pushes.model, {pushes.q, pushes.u, &tau}, {}, batch_work, batch), Status::Solved);
  StepWorkspace work(pushes.model);
  StepResult single;
  for (Eigen::Index i = 0; i < pushes.q.cols(); ++i) {
    work.forget();
    const Eigen::VectorXd one = tau.col(i);
    ASSERT_EQ(step(*pushes.model, {pushes.q.col(i), pushes.u.col(i), &one}, {}, work, single), Status::Solved);
    EXPECT_EQ(batch.q_next.col(i), single.q_next) << i;
  }
  EXPECT_NE(batch.q_next, pushes.run({}, 1).q_next) << "the forces did nothing";
  tau.conservativeResize(Eigen::NoChange, 5);
  EXPECT_EQ(stiction::test::message_of([&] {
              (void)step_batch(*pushes.model, {pushes.q, pushes.u, &tau}, {}, batch_work, batch);
            }),
            "tau_ext: got 5 forces, expected 33, one for each q");
}

TEST(StepBatch, WithoutDerivativesOrSteps_IsEmpty) {
  const Pushes pushes(5), none(0);
  const StepBatchResult plain = pushes.run({}, 2), empty = none.run({.with_B = true}, 2);
  EXPECT_EQ(plain.A.size(), 0);
  EXPECT_EQ(plain.B.size(), 0);
  EXPECT_EQ(empty.q_next.cols(), 0);
  EXPECT_TRUE(empty.status.empty());
}

TEST(StepBatch, BadInput_IsNamedWithItsStep) {
  Pushes pushes(40);
  StepBatchWorkspace work(pushes.model, 2);
  StepBatchResult out;
  const auto message = [&](const MatrixXd& q, const MatrixXd& u) {
    return stiction::test::message_of([&] { (void)step_batch(*pushes.model, {q, u}, {}, work, out); });
  };
  EXPECT_EQ(message(pushes.q, pushes.u.leftCols(39)), "u: got 39 commands, expected 40, one for each q");
  EXPECT_EQ(message(pushes.q.topRows(1), pushes.u), "q: got 1 numbers, expected 2");
  pushes.u(1, 33) = std::numeric_limits<double>::quiet_NaN();
  pushes.u(1, 38) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(message(pushes.q, pushes.u).find("step 33: u"), std::string::npos) << message(pushes.q, pushes.u);
  EXPECT_NE(stiction::test::message_of([&] { StepBatchWorkspace bad(pushes.model, -1); }).find("threads: got -1"), std::string::npos);
}

TEST(StepBatch, Cancelled_LeavesTheStepsThatAreNotDone) {
  const Pushes pushes(40);
  std::atomic<bool> cancel = true;
  core::RunControl control;
  control.cancel = &cancel;
  StepBatchWorkspace work(pushes.model, 2);
  StepBatchResult out;
  const StepOptions options{.smoothing = Analytic{}, .with_B = true, .with_A = true};
  EXPECT_EQ(step_batch(*pushes.model, {pushes.q, pushes.u}, options, work, out, control), Status::Cancelled);
  EXPECT_EQ(out.failed, 40);
  EXPECT_EQ(out.q_next, pushes.q);
  EXPECT_TRUE(out.A.isZero(0) && out.B.isZero(0) && out.torque.isZero(0));
  core::RunControl late;
  late.deadline = core::RunControl::Clock::now();
  EXPECT_EQ(step_batch(*pushes.model, {pushes.q, pushes.u}, options, work, out, late), Status::MaxIterations) << "as all that runs";
  EXPECT_EQ(out.failed, 40);
  int asked = 0;
  core::RunControl later;
  later.abandoned = [&asked] { return ++asked > 7; };
  StepBatchWorkspace single(pushes.model, 1);
  EXPECT_EQ(step_batch(*pushes.model, {pushes.q, pushes.u}, options, single, out, later), Status::Cancelled);
  EXPECT_EQ(std::ranges::count(out.status, Status::Solved), 7);
}

TEST(StepBatch, TooManyThreads_AreRefused) {
  const Pushes pushes(1);
  EXPECT_EQ(stiction::test::message_of([&] { const StepBatchWorkspace work(pushes.model, 1000000); }),
            "threads: got 1000000, expected 0 for all cores, or a number up to 1024");
}

}  // namespace
}  // namespace stiction::dynamics::test
