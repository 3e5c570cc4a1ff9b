#include "stiction/trajopt/optimize.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <functional>
#include <limits>
#include <vector>

#include "dynamics/systems.hpp"
#include "stiction/core/invalid_input.hpp"
#include "stiction/tasks/task.hpp"

namespace stiction::trajopt::test {
namespace {

using core::Status;
using Eigen::VectorXd;

/// A ball on two springs and nothing else: q_{t+1} = u_t.
std::shared_ptr<const world::Model> lone_pusher() {
  world::Scene scene = dynamics::test::empty_scene();
  scene.robots.push_back(dynamics::test::pusher());
  return world::Model::make(scene);
}

/// (T.1) for q_{t+1} = u_t as a linear system in u: every input is tied to its reference and to the one before it.
VectorXd chain(double Q, double Qd, double R, double u_before, double goal, Eigen::Index T) {
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(T, T);
  VectorXd h = VectorXd::Zero(T);
  for (Eigen::Index t = 0; t < T; ++t) {
    const double w = t + 1 < T ? Q : Qd;
    H(t, t) += w + R;
    h[t] += w * goal;
    if (t > 0)
      H(t - 1, t - 1) += R, H(t, t - 1) -= R, H(t - 1, t) -= R;
    else
      h[t] += R * u_before;
  }
  return H.ldlt().solve(h);
}

struct Run {
  OptimizeResult result;
  Status status;
};

Run run_task(const tasks::Task& task, OptimizeOptions options, const core::RunControl& control = {}) {
  OptimizeWorkspace work(task.model, options.threads);
  Run out;
  const auto input = tasks::make_optimize_input(task);
  out.status = optimize(*task.model, input, options, control, work, out.result);
  return out;
}

class Inner : public ::testing::TestWithParam<InnerSolver> {};
INSTANTIATE_TEST_SUITE_P(Solvers, Inner, ::testing::Values(InnerSolver(SweepSolver{}), InnerSolver(RecedingSolver{})),
                         [](const auto& p) { return p.param.index() == 0 ? "Sweep" : "Receding"; });

TEST_P(Inner, NoContact_IsTheLinearQuadraticClosedForm) {
  const auto model = lone_pusher();
  OptimizeOptions options;
  options.step.regularisation = dynamics::FixedEpsilon{1};
  options.solver = GetParam();
  options.weights = {VectorXd::Constant(1, 2.0), VectorXd::Constant(1, 50.0), VectorXd::Constant(1, 7.0)};
  options.input_bound.setConstant(10);
  options.iterations = 1;
  options.qp_tolerance = 1e-12;
  for (const int T : {1, 2, 12}) {
    VectorXd goal(2);
    goal << 0.4, -0.3;
    const VectorXd q0 = VectorXd::Constant(2, 0.1);
    OptimizeWorkspace work(model, 1);
    OptimizeResult out;
    ASSERT_EQ(optimize(*model, {q0, constant_inputs(*model, q0, T), constant_reference(goal, T), nullptr}, options, {}, work, out),
              Status::Solved);
    ASSERT_EQ(out.u.size(), static_cast<std::size_t>(T));
    for (int i = 0; i < 2; ++i) {
      const VectorXd u = chain(2, 50, 7, q0[i], goal[i], T);
      for (int t = 0; t < T; ++t) {
        const auto s = static_cast<std::size_t>(t);
        EXPECT_NEAR(out.u[s][i], u[t], 1e-5) << "T " << T << " t " << t;
        EXPECT_NEAR(out.q[s + 1][i], u[t], 1e-5);
      }
    }
  }
}

TEST_P(Inner, InputBound_HoldsAroundTheTrajectoryBefore) {
  const auto model = lone_pusher();
  OptimizeOptions options;
  options.step.regularisation = dynamics::FixedEpsilon{1};
  options.solver = GetParam();
  options.input_bound.setConstant(0.03);
  options.iterations = 1;
  const VectorXd q0 = VectorXd::Zero(2), goal = VectorXd::Ones(2);
  OptimizeWorkspace work(model, 1);
  OptimizeResult out;
  ASSERT_EQ(optimize(*model, {q0, constant_inputs(*model, q0, 5), constant_reference(goal, 5), nullptr}, options, {}, work, out),
            Status::Solved);
  for (const auto& u : out.u) EXPECT_NEAR(u.maxCoeff(), 0.03, 1e-5);  // the guess rests at 0
}

TEST(OptimizeInput, StartTurnedByWholeTurns_CostIsTheSame) {
  auto task = tasks::load_task(dynamics::test::source_dir() / "tasks" / "impc_planar_pushing.yaml");
  const double angle = task.problem.q_start[2], goal = tasks::make_optimize_input(task).reference.back()[2];
  for (const int turns : {-2, -1, 1, 3}) {
    task.problem.q_start[2] = angle + 2 * M_PI * turns;
    EXPECT_NEAR(tasks::make_optimize_input(task).reference.back()[2] - task.problem.q_start[2], goal - angle, 1e-12) << turns;
  }
}

TEST(OptimizeInput, HingeBeyondOneTurn_KeepsItsTurns) {
  auto task = tasks::load_task(dynamics::test::source_dir() / "tasks" / "allegro_door.yaml");
  task.optimize = tasks::load_task(dynamics::test::source_dir() / "tasks" / "impc_planar_pushing.yaml").optimize;
  const int hinge = task.model->objects()[static_cast<std::size_t>(task.problem.goal.object)].q_begin;
  task.problem.q_goal[hinge] += 2 * M_PI;  // the pose is the same
  EXPECT_EQ(tasks::make_optimize_input(task).reference.back()[hinge], task.problem.q_goal[hinge]);
}

TEST(Optimize, Cost_NeverRisesAndIsThatOfTheExactDynamics) {
  for (const char* name : {"impc_planar_pushing", "impc_planar_hand", "impc_allegro_ball"}) {
    const tasks::Task task = tasks::load_task(name);
    OptimizeOptions options = task.optimize->options;
    options.iterations = 4;
    const auto [result, status] = run_task(task, options);
    ASSERT_EQ(status, Status::Solved) << name;
    ASSERT_EQ(result.history.size(), 5u);
    for (std::size_t i = 1; i < result.history.size(); ++i) {
      EXPECT_LE(result.history[i].cost.total(), result.history[i - 1].cost.total()) << name << " iteration " << i;
    }
    EXPECT_LT(result.cost.total(), 0.5 * result.history[0].cost.total()) << name;
    // Once more from the commands alone.
    dynamics::StepOptions exact = options.step;
    dynamics::StepWorkspace work(task.model);
    dynamics::StepResult step;
    VectorXd q = task.problem.q_start, difference(task.model->n_v());
    for (std::size_t t = 0; t < result.u.size(); ++t) {
      ASSERT_EQ(dynamics::step(*task.model, {q, result.u[t]}, exact, work, step), Status::Solved);
      world::local(*task.model, step.q_next, result.q[t + 1], difference);
      // What the tolerance of a step leaves open, over two histories of warm starts.
      EXPECT_LE(difference.cwiseAbs().maxCoeff(), 1e-4) << name << " t " << t;
      EXPECT_TRUE((result.u[t].array() >= task.model->lower().array()).all() && (result.u[t].array() <= task.model->upper().array()).all());
      q = result.q[t + 1];
    }
    const auto input = tasks::make_optimize_input(task);
    const CostTerms cost = calc_cost(*task.model, options.weights.expanded(*task.model), input.reference, result.q, result.u,
                                     VectorXd(task.problem.q_start.tail(task.model->n_a())));
    EXPECT_DOUBLE_EQ(cost.total(), result.cost.total());
  }
}

TEST(Optimize, Receding_LowersTheCostAndKeepsTheBest) {
  const tasks::Task task = tasks::load_task("impc_planar_pushing");
  OptimizeOptions options = task.optimize->options;
  options.solver = RecedingSolver{};
  options.iterations = 4;
  const auto [result, status] = run_task(task, options);
  ASSERT_EQ(status, Status::Solved);
  double best = result.history[0].cost.total();
  for (const auto& entry : result.history) {
    best = std::min(best, entry.cost.total());
    EXPECT_EQ(entry.best, best);
  }
  EXPECT_EQ(result.cost.total(), best);
  EXPECT_LT(best, 0.2 * result.history[0].cost.total());
}

TEST(Optimize, EverySchemeLowersTheCost) {
  tasks::Task task = tasks::load_task("impc_planar_pushing");
  for (const auto scheme :
       {tasks::Scheme::Exact, tasks::Scheme::Analytic, tasks::Scheme::RandomizedFirst, tasks::Scheme::RandomizedZeroth}) {
    task.optimize->choose(scheme);
    OptimizeOptions options = task.optimize->options;
    options.iterations = 3;
    // Half a millimetre away from the box the exact dynamics have no gradient at all; the others must find the contact.
    const auto [result, status] = run_task(task, options);
    ASSERT_EQ(status, Status::Solved);
    const double share = result.cost.total() / result.history[0].cost.total();
    EXPECT_LT(share, scheme == tasks::Scheme::Exact ? 1.0 + 1e-12 : 0.9) << tasks::kSchemeNames[static_cast<std::size_t>(scheme)];
  }
}

TEST(Optimize, AnyNumberOfThreads_SameBits) {
  tasks::Task task = tasks::load_task("impc_planar_hand");
  for (const auto scheme : {tasks::Scheme::Analytic, tasks::Scheme::RandomizedFirst}) {
    task.optimize->choose(scheme);
    OptimizeOptions options = task.optimize->options;
    options.iterations = 2;
    options.threads = 1;
    const auto one = run_task(task, options);
    options.threads = 3;
    const auto three = run_task(task, options);
    ASSERT_EQ(one.result.u.size(), three.result.u.size());
    for (std::size_t t = 0; t < one.result.u.size(); ++t) EXPECT_EQ(one.result.u[t], three.result.u[t]);
    EXPECT_EQ(one.result.cost.total(), three.result.cost.total());
  }
}

TEST(Optimize, WorkspaceUsedBefore_SameBits) {
  const tasks::Task task = tasks::load_task("impc_planar_hand");
  OptimizeOptions options = task.optimize->options;
  options.iterations = 2;
  OptimizeWorkspace work(task.model, 1);
  OptimizeResult first, second;
  const auto input = tasks::make_optimize_input(task);
  ASSERT_EQ(optimize(*task.model, input, options, {}, work, first), Status::Solved);
  ASSERT_EQ(optimize(*task.model, input, options, {}, work, second), Status::Solved);
  EXPECT_EQ(first.cost.total(), second.cost.total());
}

TEST(Optimize, CancelledInTheMiddle_KeepsTheBestSoFar) {
  const tasks::Task task = tasks::load_task("impc_planar_pushing");
  OptimizeOptions options = task.optimize->options;
  std::atomic<bool> cancel{false};
  core::RunControl control;
  control.cancel = &cancel;
  control.on_progress = [&](const core::Progress& p) { cancel = p.iteration == 2; };
  const auto [result, status] = run_task(task, options, control);
  EXPECT_EQ(status, Status::Cancelled);
  EXPECT_EQ(result.status, Status::Cancelled);
  ASSERT_EQ(result.history.size(), 3u);
  EXPECT_EQ(result.cost.total(), result.history.back().best);
  EXPECT_LT(result.cost.total(), result.history[0].cost.total());
  EXPECT_EQ(result.q.size(), result.u.size() + 1);
}

TEST(Optimize, DeadlinePassed_ReturnsTheGuess) {
  const tasks::Task task = tasks::load_task("impc_planar_pushing");
  core::RunControl control;
  control.deadline = core::RunControl::Clock::now();
  const auto [result, status] = run_task(task, task.optimize->options, control);
  EXPECT_EQ(status, Status::MaxIterations);
  EXPECT_EQ(result.u, tasks::make_optimize_input(task).u_guess);
  EXPECT_EQ(result.contacts.size(), result.u.size());
}

TEST(Optimize, HorizonOne_MovesTowardsTheGoal) {
  for (const InnerSolver& solver : {InnerSolver(SweepSolver{}), InnerSolver(RecedingSolver{})}) {
    tasks::Task task = tasks::load_task("impc_planar_pushing");
    task.optimize->horizon = 1;
    OptimizeOptions options = task.optimize->options;
    options.solver = solver;
    const auto [result, status] = run_task(task, options);
    ASSERT_EQ(status, Status::Solved);
    ASSERT_EQ(result.u.size(), 1u);
    EXPECT_LT(result.cost.total(), result.history[0].cost.total());
  }
}

TEST(Optimize, WithoutA_StillLowersTheCost) {
  const tasks::Task task = tasks::load_task("impc_planar_pushing");
  OptimizeOptions options = task.optimize->options;
  options.use_A = false;
  options.iterations = 3;
  const auto [result, status] = run_task(task, options);
  ASSERT_EQ(status, Status::Solved);
  EXPECT_LT(result.cost.total(), 0.9 * result.history[0].cost.total());
}

TEST(Optimize, ForceTrustRegion_DoesNotBelieveInPulling) {
  // The box should come towards the ball that touches it: no command does that, and what the model expects shows whether it knows. What is
  // left with (T.7) is the smoothed force, which can be taken away but no more than that.
  tasks::Task task = tasks::load_task("impc_planar_pushing");
  tasks::set_goal(task, std::vector<double>{0.0, 0.0, 0.0});
  OptimizeOptions options = task.optimize->options;
  options.iterations = 1;
  options.weights.Q.tail(2).setZero(), options.weights.Qd.tail(2).setZero();
  const double boxes = run_task(task, options).result.history[1].predicted;
  options.forces.emplace();
  const double forces = run_task(task, options).result.history[1].predicted;
  EXPECT_GE(forces, -1e-6);
  EXPECT_GT(boxes, 1.0);
  EXPECT_LT(forces, 0.5 * boxes);
}

TEST(Optimize, ForceTrustRegion_CostNeverRises) {
  for (const char* name : {"impc_planar_hand", "impc_allegro_ball"}) {
    const tasks::Task task = tasks::load_task(name);
    OptimizeOptions options = task.optimize->options;
    options.iterations = 3;
    options.forces.emplace();
    const auto [result, status] = run_task(task, options);
    ASSERT_EQ(status, Status::Solved);
    for (std::size_t i = 1; i < result.history.size(); ++i) {
      EXPECT_LE(result.history[i].cost.total(), result.history[i - 1].cost.total()) << name << " iteration " << i;
    }
    EXPECT_LT(result.cost.total(), 0.9 * result.history[0].cost.total()) << name;
  }
}

TEST(Cost, RotationsByTheirVectors_ExpansionMatchesDifferences) {
  const auto model = dynamics::test::load_task("allegro_ball");
  core::Random random(3, 0);
  VectorXd q = dynamics::test::sample_task("allegro_ball", *model, random), q_d = q, delta = VectorXd::Zero(model->n_v());
  delta.segment<3>(3) << 0.7, -0.4, 1.1;
  world::retract(*model, q_d, delta, q_d);
  const VectorXd w = VectorXd::LinSpaced(model->n_v(), 1, 3);
  VectorXd gradient;
  Eigen::MatrixXd hessian;
  expand_state_cost(*model, w, q_d, q, gradient, hessian);
  const auto cost = [&](const VectorXd& d) {
    VectorXd moved = q, e(model->n_v());
    world::retract(*model, q, d, moved);
    world::local(*model, q_d, moved, e);
    return e.cwiseAbs2().dot(w);
  };
  const double h = 1e-5;  // error h² times third derivatives of order 10: 1e-9
  for (int i = 0; i < model->n_v(); ++i) {
    const VectorXd d = h * VectorXd::Unit(model->n_v(), i);
    EXPECT_NEAR(gradient[i], (cost(d) - cost(-d)) / (2 * h), 1e-7) << i;
  }
  ASSERT_GT(gradient.segment<3>(3).norm(), 0.1);
  // With the error turned away the expansion is exact: its Hessian is that of the cost.
  expand_state_cost(*model, w, q, q, gradient, hessian);
  EXPECT_LE((hessian - Eigen::MatrixXd((2 * w).asDiagonal())).norm(), 1e-12);
}

void expect_message(const std::function<void(OptimizeOptions&, OptimizeInput&)>& spoil, const std::string& text) {
  const tasks::Task task = tasks::load_task("impc_planar_hand");
  OptimizeOptions options = task.optimize->options;
  OptimizeInput input = tasks::make_optimize_input(task);
  spoil(options, input);
  OptimizeWorkspace work(task.model, 1);
  OptimizeResult out;
  try {
    (void)optimize(*task.model, input, options, {}, work, out);
    FAIL() << "accepted, expected: " << text;
  } catch (const core::InvalidInput& e) {
    EXPECT_NE(std::string(e.what()).find(text), std::string::npos) << e.what();
  }
}

TEST(Optimize, BadInput_IsNamed) {
  using dynamics::Analytic, dynamics::RandomizedFirstOrder, dynamics::RandomizedZerothOrder;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  expect_message([](auto& o, auto&) { o.weights.Q = VectorXd::Constant(1, -1); }, "weights.Q[0]: got -1");
  expect_message([](auto& o, auto&) { o.weights.R = VectorXd::Ones(3); }, "weights.R: got");
  expect_message([&](auto& o, auto&) { o.weights.Qd[2] = nan; }, "weights.Qd[2]");
  expect_message([](auto& o, auto&) { o.scheme = Analytic{0}; }, "scheme.analytic.kappa: got 0");
  expect_message([](auto& o, auto&) { o.scheme = Analytic{-5}; }, "scheme.analytic.kappa: got -5");
  expect_message([](auto& o, auto&) { o.scheme = RandomizedFirstOrder{{.samples = 0}}; }, "scheme.randomized_first.samples: got 0");
  expect_message([](auto& o, auto&) { o.scheme = RandomizedZerothOrder{}; }, "scheme.randomized_zeroth.std_q");
  expect_message([](auto& o, auto&) { o.kappa_growth = 0; }, "kappa_growth: got 0");
  expect_message([](auto& o, auto&) { o.iterations = 0; }, "iterations: got 0");
  expect_message([](auto& o, auto&) { o.input_bound = VectorXd::Constant(1, -0.1); }, "input_bound: got -0.1");
  expect_message([](auto& o, auto&) { o.forces = {.max_distance = -1}; }, "forces.max_distance: got -1");
  expect_message([](auto& o, auto&) { o.forces = {.rays = 3}; }, "forces.rays: got 3");
  expect_message([](auto& o, auto&) { o.forces.emplace(), o.solver = RecedingSolver{}; }, "forces: got the receding solver");
  expect_message([](auto& o, auto&) { o.forces.emplace(), o.scheme = dynamics::Exact{}; }, "expected the analytic scheme");
  expect_message([](auto&, auto& in) { in.u_guess.clear(); }, "u_guess: got no command");
  expect_message([&](auto&, auto& in) { in.u_guess[3][1] = nan; }, "u_guess[3]");
  expect_message([](auto&, auto& in) { in.u_guess[2][0] = 4; }, "u_guess[2][0]: got 4");
  expect_message([](auto&, auto& in) { in.reference.pop_back(); }, "reference: got");
  expect_message([&](auto&, auto& in) { in.reference[5][0] = nan; }, "reference[5][0]");
}

}  // namespace
}  // namespace stiction::trajopt::test
