#include "stiction/dynamics/rollout_batch.hpp"

#include "dynamics/systems.hpp"
#include "support/message_of.hpp"

namespace stiction::dynamics::test {
namespace {

using core::Status;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// A function of a trajectory with a derivative of its own at every configuration.
struct Loss {
  Loss(Index n, core::Random& random) : weights(n) {
    for (double& weight : weights) weight = random.normal();
  }
  double value(const VectorXd& q) const { return weights.dot(q) + 0.5 * q.squaredNorm(); }
  VectorXd derivative(const VectorXd& q) const { return weights + q; }
  VectorXd weights;
};

struct Rollouts {
  Rollouts(std::shared_ptr<const world::Model> given, Index steps, Index n, core::Random& random)
      : model(std::move(given)), q(model->n_q(), n), u(model->n_a() * steps, n) {
    for (Index i = 0; i < n; ++i) {
      q.col(i) = sample_task(model->scene().name, *model, random);
      VectorXd command = q.col(i).tail(model->n_a());
      for (Index t = 0; t < steps; ++t) {
        for (double& c : command) c += 0.02 * random.normal();
        u.col(i).segment(t * model->n_a(), model->n_a()) = command;
      }
    }
  }
  RolloutBatchResult run(const StepOptions& options, int threads = 1) const {
    StepBatchWorkspace work(model, threads);
    RolloutBatchResult out;
    (void)rollout_batch(*model, {q, u}, options, work, out);
    return out;
  }
  RolloutGradient pull_back(const RolloutBatchResult& rolled, const MatrixXd& g, const StepOptions& options, int threads = 1) const {
    StepBatchWorkspace work(model, threads);
    RolloutGradient out;
    (void)pull_back_rollout(*model, {q, u}, rolled, g, options, work, out);
    return out;
  }
  std::shared_ptr<const world::Model> model;
  MatrixXd q, u;
};

std::shared_ptr<const world::Model> pusher_alone() {
  world::Scene scene = empty_scene();
  scene.robots.push_back(pusher());
  return world::Model::make(scene);
}

TEST(RolloutBatch, WithoutContact_JointsAreWhereTheyAreCommanded) {
  const auto model = pusher_alone();
  MatrixXd q(2, 1), u(6, 1), g(8, 1);
  q << 0.01, 0.02;
  u << 0.1, 0.2, 0.3, 0.4, 0.5, 0.6;
  g << 1, 2, 3, 4, 5, 6, 7, 8;
  StepBatchWorkspace work(model, 1);
  RolloutBatchResult rolled;
  ASSERT_EQ(rollout_batch(*model, {q, u}, {}, work, rolled), Status::Solved);
  EXPECT_TRUE(rolled.q.col(0).tail(6).isApprox(u.col(0), 1e-12));
  EXPECT_EQ(rolled.steps[0], 3);
  RolloutGradient gradient;
  EXPECT_EQ(pull_back_rollout(*model, {q, u}, rolled, g, {}, work, gradient), Status::Solved);
  EXPECT_TRUE(gradient.u.col(0).isApprox(g.col(0).tail(6), 1e-9));        // each command places its own configuration …
  EXPECT_TRUE(gradient.q_start.col(0).isApprox(g.col(0).head(2), 1e-9));  // … and the start only itself
}

TEST(RolloutBatch, EqualsSteps_BitForBitForAnyNumberOfThreads) {
  core::Random random(5, 0);
  const Rollouts rollouts(load_task("planar_pushing"), 4, 7, random);
  const RolloutBatchResult one = rollouts.run({}, 1), three = rollouts.run({}, 3);
  EXPECT_EQ(one.q, three.q);
  StepWorkspace work(rollouts.model);
  StepResult result;
  const int n_q = rollouts.model->n_q(), n_a = rollouts.model->n_a();
  for (Index i = 0; i < 7; ++i) {
    VectorXd q = rollouts.q.col(i);
    for (Index t = 0; t < 4; ++t) {
      work.forget();
      ASSERT_EQ(step(*rollouts.model, {q, rollouts.u.col(i).segment(t * n_a, n_a)}, {}, work, result), Status::Solved);
      q = result.q_next;
      EXPECT_EQ(q, one.q.col(i).segment((t + 1) * n_q, n_q));
    }
  }
  const MatrixXd g = MatrixXd::Ones(one.q.rows(), one.q.cols());
  EXPECT_EQ(rollouts.pull_back(one, g, {}, 1).u, rollouts.pull_back(one, g, {}, 3).u);
}

class RolloutGradientOf : public testing::TestWithParam<const char*> {};

/// Along random directions of commands and starts, against fourth-order differences of the whole rollout.
TEST_P(RolloutGradientOf, Smoothed_MatchesCentralDifferences) {
  core::Random random(11, 0);
  const auto model = load_task(GetParam());
  const StepOptions options{.smoothing = Analytic{}, .tol_complementarity = 1e-12};
  const Rollouts rollouts(model, 8, 3, random);
  const RolloutBatchResult rolled = rollouts.run(options);
  ASSERT_EQ(rolled.failed, 0);
  const Loss loss(rolled.q.rows(), random);
  MatrixXd g(rolled.q.rows(), 3);
  for (Index i = 0; i < 3; ++i) g.col(i) = loss.derivative(rolled.q.col(i));
  const RolloutGradient gradient = rollouts.pull_back(rolled, g, options);
  for (Index i = 0; i < 3; ++i) {
    VectorXd along_u(rollouts.u.rows()), along_q(model->n_v()), moved(model->n_q());
    for (double& v : along_u) v = random.normal();
    for (double& v : along_q) v = random.normal();
    along_q.tail(model->n_a()).setZero();  // one at a joint limit would have two derivatives
    const double step_size = 1e-5;
    double by_u = 0, by_q = 0;
    for (const auto& [offset, weight] : {std::pair{-2.0, 1.0}, std::pair{-1.0, -8.0}, std::pair{1.0, 8.0}, std::pair{2.0, -1.0}}) {
      Rollouts other = rollouts;
      other.u.col(i) += offset * step_size * along_u;
      by_u += weight * loss.value(other.run(options).q.col(i)) / (12 * step_size);
      other = rollouts;
      world::retract(*model, rollouts.q.col(i), offset * step_size * along_q, moved);
      other.q.col(i) = moved;
      by_q += weight * loss.value(other.run(options).q.col(i)) / (12 * step_size);
    }
    ASSERT_GT(std::abs(by_u), 1e-2);
    EXPECT_NEAR(gradient.u.col(i).dot(along_u), by_u, 1e-5 * std::abs(by_u));
    VectorXd ahead(model->n_q()), behind(model->n_q());  // of the configuration itself, by δ
    world::retract(*model, rollouts.q.col(i), 1e-5 * along_q, ahead);
    world::retract(*model, rollouts.q.col(i), -1e-5 * along_q, behind);
    EXPECT_NEAR(gradient.q_start.col(i).dot(ahead - behind) / 2e-5, by_q, 1e-5 * std::max(1.0, std::abs(by_q)));
  }
}

INSTANTIATE_TEST_SUITE_P(Tasks, RolloutGradientOf, testing::Values("planar_pushing", "planar_hand", "allegro_ball"));

TEST(RolloutBatch, StepThatFails_LeavesTheTrajectoryThereAndPassesItsGradient) {
  world::Scene scene = empty_scene();
  scene.robots.push_back(pusher());
  scene.fixed.push_back(half_space(Eigen::Vector3d::UnitZ(), {0, 0, 0.2}, 0.3));  // no room between the two
  scene.fixed.push_back(half_space(-Eigen::Vector3d::UnitZ(), {0, 0, -0.2}, 0.3));
  scene.fixed[1].name = "ceiling";
  const auto model = world::Model::make(scene);
  const MatrixXd q = MatrixXd::Zero(2, 1), u = MatrixXd::Constant(4, 1, 0.1);
  StepBatchWorkspace work(model, 1);
  RolloutBatchResult rolled;
  EXPECT_EQ(rollout_batch(*model, {q, u}, {}, work, rolled), Status::Infeasible);
  EXPECT_EQ(rolled.failed, 1);
  EXPECT_EQ(rolled.steps[0], 0);
  EXPECT_EQ(rolled.q, MatrixXd::Zero(6, 1));
  RolloutGradient gradient;
  EXPECT_EQ(pull_back_rollout(*model, {q, u}, rolled, MatrixXd::Ones(6, 1), {}, work, gradient), Status::Solved);
  EXPECT_EQ(gradient.q_start, MatrixXd::Constant(2, 1, 3));
  EXPECT_EQ(gradient.u, MatrixXd::Zero(4, 1));
}

TEST(RolloutBatch, BadInput_IsNamed) {
  const auto model = pusher_alone();
  StepBatchWorkspace work(model, 1);
  RolloutBatchResult out;
  const auto message = [&](const MatrixXd& q, const MatrixXd& u) {
    return stiction::test::message_of([&] { (void)rollout_batch(*model, {q, u}, {}, work, out); });
  };
  EXPECT_EQ(message(MatrixXd::Zero(2, 3), MatrixXd::Zero(5, 3)),
            "u: got 5 numbers a trajectory, expected a multiple of 2, a command for each step");
  EXPECT_EQ(message(MatrixXd::Zero(2, 3), MatrixXd::Zero(4, 2)), "u: got 2 trajectories, expected 3, one for each start");
  MatrixXd u = MatrixXd::Zero(4, 3);
  u(3, 1) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(message(MatrixXd::Zero(2, 3), u).substr(0, 23), "trajectory 1, step 1: u");
}

TEST(RolloutBatch, Cancelled_StaysWhereItIs) {
  const auto model = pusher_alone();
  const MatrixXd q = MatrixXd::Zero(2, 1), u = MatrixXd::Constant(10, 1, 0.01);
  int asked = 0;
  core::RunControl control;
  control.abandoned = [&asked] { return ++asked > 3; };
  StepBatchWorkspace work(model, 1);
  RolloutBatchResult out;
  EXPECT_EQ(rollout_batch(*model, {q, u}, {}, work, out, control), Status::Cancelled);
  EXPECT_EQ(out.steps[0], 3);
  EXPECT_EQ(out.q.col(0).segment(6, 2), out.q.col(0).tail(2));
  ASSERT_EQ(rollout_batch(*model, {q, u}, {}, work, out), Status::Solved);
  RolloutGradient gradient;
  asked = 0;
  EXPECT_EQ(pull_back_rollout(*model, {q, u}, out, MatrixXd::Ones(12, 1), {}, work, gradient, control), Status::Cancelled);
  core::RunControl late;
  late.deadline = core::RunControl::Clock::now();
  EXPECT_EQ(pull_back_rollout(*model, {q, u}, out, MatrixXd::Ones(12, 1), {}, work, gradient, late), Status::MaxIterations);
  EXPECT_EQ(rollout_batch(*model, {q, u}, {}, work, out, late), Status::MaxIterations);
  EXPECT_EQ(out.steps[0], 0);
}

}  // namespace
}  // namespace stiction::dynamics::test
