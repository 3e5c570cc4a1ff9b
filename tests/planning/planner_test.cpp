#include "stiction/planning/planner.hpp"

#include "planning/systems.hpp"
#include "stiction/core/invalid_input.hpp"
#include "stiction/world/object_space.hpp"
#include "support/message_of.hpp"

namespace stiction::planning::test {
namespace {

using core::Status;

/// Commands of a plan simulated from its start, each sub-step in `parts`.
Eigen::VectorXd simulate(const PlanningProblem& problem, const Plan& plan, int parts) {
  dynamics::StepWorkspace work(problem.model);
  dynamics::StepResult result;
  Eigen::VectorXd q = plan.q_start, u = plan.u_start;
  for (const auto& segment : plan.segments) {
    for (const auto& knot : segment.knots) {
      for (int k = 1; k <= parts; ++k) {
        const double s = static_cast<double>(k) / parts;
        const Eigen::VectorXd command = (1 - s) * u + s * knot.u;
        EXPECT_EQ(dynamics::step(*problem.model, {q, command}, plan.step, work, result), Status::Solved);
        q = result.q_next;
      }
      u = knot.u;
    }
  }
  return q;
}

TEST(Planner, PlanarHand_ReachesTheGoalAtBothResolutions) {
  const PlanningProblem problem = hand_problem();
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    PlannerOptions options = hand_options();
    options.seed = seed;
    options.max_iterations = 20000;
    PlanResult result;
    ASSERT_EQ(plan(problem, options, {}, result), Status::Solved) << "seed " << seed;
    EXPECT_TRUE(result.plan.error.within(problem.goal));
    for (const int parts : {1, 2}) {
      const GoalError error = goal_error(*problem.model, simulate(problem, result.plan, parts), problem.goal);
      EXPECT_TRUE(error.within(problem.goal)) << "in " << parts << " parts: " << error.position << " m " << error.angle << " rad";
    }
    Eigen::VectorXd u = result.plan.u_start;
    SegmentKind last = SegmentKind::Settle;
    for (const auto& segment : result.plan.segments) {
      EXPECT_FALSE(segment.kind == SegmentKind::Regrasp && last == SegmentKind::Regrasp) << "consecutive regrasps";
      last = segment.kind;
      for (const auto& knot : segment.knots) {
        EXPECT_LE((knot.u - u).cwiseAbs().maxCoeff(), options.substep->joint_angle * (1 + 1e-9));
        u = knot.u;
      }
    }
  }
}

// Half of all edges disagree somewhere at a hundredth of the tolerances: what is left of them has to carry the search.
/// What rests on the sixth digit of a command is no plan: at half the sub-step, with other errors than those that the planner tried.
TEST(Planner, Plan_SurvivesNoiseInItsCommands) {
  const PlanningProblem problem = hand_problem();
  PlannerOptions options = hand_options();
  for (options.seed = 0; options.seed < 4; ++options.seed) {
    PlanResult result;
    ASSERT_EQ(plan(problem, options, {}, result), Status::Solved);
    core::Random random(99, options.seed);
    for (auto& segment : result.plan.segments) {
      for (auto& knot : segment.knots) {
        for (double& value : knot.u) value += random.uniform(-1e-6, 1e-6);
      }
    }
    EXPECT_TRUE(goal_error(*problem.model, simulate(problem, result.plan, 2), problem.goal).within(problem.goal))
        << "seed " << options.seed;
  }
}

TEST(Planner, RefinedFraction_IsWhereHalfTheSubStepsMayEnd) {
  const PlanningProblem problem = hand_problem();
  PlannerOptions options = hand_options();
  options.tolerance_fraction = 0.02;
  options.refined_fraction = 0.3;
  int farther = 0;
  for (options.seed = 0; options.seed < 6; ++options.seed) {
    PlanResult result;
    ASSERT_EQ(plan(problem, options, {}, result), Status::Solved) << "seed " << options.seed;
    const auto share = [&](int parts) {
      return goal_error(*problem.model, simulate(problem, result.plan, parts), problem.goal).share(problem.goal);
    };
    EXPECT_LE(share(1), options.tolerance_fraction + 1e-9);
    EXPECT_LE(share(2), *options.refined_fraction);
    farther += share(2) > options.tolerance_fraction;
  }
  EXPECT_GT(farther, 0);
}

TEST(Planner, EdgesThatDisagree_AreBuiltOnUpToWhereTheyDo) {
  const PlanningProblem problem = hand_problem();
  PlannerOptions options = hand_options();
  options.fidelity_edge = 0.01;
  PlanResult result;
  ASSERT_EQ(plan(problem, options, {}, result), Status::Solved);
  EXPECT_GT(result.distrusted, 0);
  const world::ObjectSpace space(*problem.model);
  Plan part = result.plan;
  part.segments.clear();
  Eigen::VectorXd before = Eigen::VectorXd::Zero(3), after(3);
  for (const Segment& segment : result.plan.segments) {
    part.segments.push_back(segment);
    space.error(segment.knots.back().q.data(), simulate(problem, part, 2).data(), after.data());
    const double share = world::largest_share(*problem.model, after - before, problem.goal.tol_position, problem.goal.tol_angle);
    EXPECT_LE(share, options.fidelity_edge * (1 + 1e-3)) << "edge " << part.segments.size();
    before = after;
  }
}

/// (P.11): however far a push has strained the springs, the next one starts from there, or from as much of it as grip_force leaves.
TEST(Planner, GripForce_APushStartsWithTheGripOfTheOneBefore) {
  const PlanningProblem problem = hand_problem();
  const auto& model = *problem.model;
  for (const double grip : {0.5, 1e6}) {
    PlannerOptions options = hand_options();
    options.grip_force = grip;
    const double length = std::get<CappedLength>(options.length).length;
    int kept = 0, pushes = 0;
    for (options.seed = 0; options.seed < 4; ++options.seed) {
      PlanResult result;
      ASSERT_EQ(plan(problem, options, {}, result), Status::Solved);
      const auto& segments = result.plan.segments;
      for (std::size_t s = 1; s < segments.size(); ++s) {
        if (segments[s].kind != SegmentKind::Contact) continue;
        const auto& before = segments[s - 1].knots.back();
        const Eigen::VectorXd q_a = before.q.tail(model.n_a()), strain = before.u - q_a;
        const double force = strain.cwiseProduct(model.stiffness()).cwiseQuotient(model.reach()).cwiseAbs().maxCoeff();
        const Eigen::VectorXd start = q_a + std::min(1.0, grip / force) * strain, end = segments[s].knots.back().u;
        EXPECT_LE((end - start).norm(), length * (1 + 1e-9)) << "grip " << grip << ", seed " << options.seed << ", segment " << s;
        kept += (end - q_a).norm() > length * (1 + 1e-9);
        ++pushes;
      }
    }
    EXPECT_GT(pushes, 20);
    EXPECT_GT(kept, 0) << "some push goes farther than it could from the joints";
  }
}

/// Pushes that start with the object somewhere else, by errors that the planner has not drawn, end near enough all the same.
TEST(Planner, StartNoise_PlansForgiveErrorsOfThePushesBefore) {
  const PlanningProblem problem = hand_problem();
  PlannerOptions options = hand_options();
  options.start_noise = 0.25;
  dynamics::StepWorkspace work(problem.model);
  dynamics::StepResult r;
  core::Random random(99, 0);
  int runs = 0, reached = 0;
  for (std::uint64_t seed = 0; seed < 4; ++seed) {
    options.seed = seed;
    PlanResult result;
    ASSERT_EQ(plan(problem, options, {}, result), Status::Solved);
    for (int draw = 0; draw < 5; ++draw) {
      Eigen::VectorXd q = problem.q_start, delta = Eigen::VectorXd::Zero(problem.model->n_v());
      SegmentKind before = SegmentKind::Settle;
      for (const auto& segment : result.plan.segments) {
        if (segment.kind == SegmentKind::Contact && before != SegmentKind::Contact) {
          const double e = options.start_noise, x = e * problem.goal.tol_position, angle = e * problem.goal.tol_angle;
          delta.head<3>() << random.uniform(-x, x), random.uniform(-x, x), random.uniform(-angle, angle);
          world::retract(*problem.model, q, delta, q);
        }
        before = segment.kind;
        for (const auto& knot : segment.knots) {
          ASSERT_EQ(dynamics::step(*problem.model, {q, knot.u}, result.plan.step, work, r), Status::Solved);
          q = r.q_next;
        }
      }
      ++runs;
      reached += goal_error(*problem.model, q, problem.goal).within(problem.goal);
    }
  }
  EXPECT_GE(reached, 0.8 * runs) << "of " << runs;
}

/// A body of 0.5 kg on a floor of friction 0.5, that the pusher on two sliders is to push by 0.2 m.
PlanningProblem floor_problem(const world::Shape& shape) {
  world::Scene scene = load_model("planar_pushing")->scene();
  scene.gravity = Eigen::Vector3d(0, 0, -9.8);
  scene.objects[0].joint = world::ObjectJoint::Free;
  scene.objects[0].mass = 0.5;
  scene.objects[0].inertia = 0.013 * Eigen::Matrix3d::Identity();
  scene.objects[0].geometries = {{.name = "body", .shape = shape, .X_BG = {}, .friction = 0.5}};
  scene.fixed.push_back(
      {.name = "ground", .X_WB = {}, .geometries = {{.name = "floor", .shape = world::HalfSpace{}, .X_BG = {}, .friction = 0.5}}});
  PlanningProblem problem;
  problem.model = world::Model::make(scene);
  problem.q_start.resize(9);
  problem.q_start << 0, 0.35, 0.2, 0, 0, 0, 1, 0, 0.2;
  problem.goal.X_WG.p = Eigen::Vector3d(0, 0.55, 0.2);
  problem.goal.region = GoalRegion{Eigen::VectorXd::Constant(6, -std::numeric_limits<double>::infinity()),
                                   Eigen::VectorXd::Constant(6, std::numeric_limits<double>::infinity())};
  problem.goal.region->lower[1] = problem.goal.region->upper[1] = 0.55;
  return problem;
}

Status push_over_the_floor(const PlanningProblem& problem, double edge_tilt, double friction_noise) {
  PlannerOptions options;
  options.threads = 1;
  options.max_iterations = 2000;  // seeds 0 to 19 push the cube there in 36 to 1152, half of them in more than 240
  options.grasp_probability = 0.1;
  options.goal_bias = 0.7;
  options.edge_tilt = edge_tilt;
  options.friction_noise = friction_noise;
  world::SampleBox box;
  box.lower = (Eigen::VectorXd(6) << -0.1, 0.3, 0.2, 0, 0, 0).finished();
  box.upper = (Eigen::VectorXd(6) << 0.1, 0.6, 0.2, 0, 0, 0).finished();
  options.sample_boxes.push_back(box);
  PlanResult result;
  return plan(problem, options, {}, result);
}

/// A cube stays on a slope up to atan μ; a ball that nothing holds stays on none.
TEST(Planner, EdgeTilt_WhatDoesNotStayOnASlopeIsNotBuiltOn) {
  const PlanningProblem cube = floor_problem(world::Box{Eigen::Vector3d::Constant(0.2)}), ball = floor_problem(world::Sphere{0.2});
  EXPECT_EQ(push_over_the_floor(cube, 0, 0), Status::Solved);
  EXPECT_EQ(push_over_the_floor(cube, 0.03, 0), Status::Solved);
  EXPECT_EQ(push_over_the_floor(cube, 0.6, 0), Status::MaxIterations) << "above atan 0.5";
  EXPECT_EQ(push_over_the_floor(ball, 0, 0), Status::Solved);
  EXPECT_EQ(push_over_the_floor(ball, 0.03, 0), Status::MaxIterations);
}

/// On a slope of 1 : 5 a cube stays with a μ of 0.5 or nine tenths of it, and not with a fifth.
TEST(Planner, FrictionNoise_WhatNeedsItsFrictionIsNotBuiltOn) {
  PlanningProblem cube = floor_problem(world::Box{Eigen::Vector3d::Constant(0.2)});
  world::Scene scene = cube.model->scene();
  scene.gravity = Eigen::Vector3d(0, 2, -10);
  cube.model = world::Model::make(scene);
  cube.goal.tol_position = 0.03;  // the spring that pushes is shorter by some millimetres where there is less friction
  EXPECT_EQ(push_over_the_floor(cube, 0, 0), Status::Solved);
  EXPECT_EQ(push_over_the_floor(cube, 0, 0.1), Status::Solved);
  EXPECT_EQ(push_over_the_floor(cube, 0, 0.8), Status::MaxIterations);
}

TEST(Planner, Friction_IsThatOfEveryStepOfThePlan) {
  const PlanningProblem problem = hand_problem();
  PlannerOptions options = hand_options();
  options.friction = 0.7;
  PlanResult result;
  ASSERT_EQ(plan(problem, options, {}, result), Status::Solved);
  EXPECT_EQ(result.plan.step.friction_scale, 0.7);
  for (const auto& segment : result.plan.segments) {
    for (const auto& knot : segment.knots) {
      for (const auto& c : knot.contacts) EXPECT_LE(c.lambda.tail<2>().norm(), 0.7 * c.contact.friction * c.lambda[0] * (1 + 1e-6) + 1e-9);
    }
  }
}

void expect_same_bits(const Plan& a, const Plan& b) {
  ASSERT_EQ(a.segments.size(), b.segments.size());
  for (std::size_t s = 0; s < a.segments.size(); ++s) {
    ASSERT_EQ(a.segments[s].knots.size(), b.segments[s].knots.size());
    for (std::size_t k = 0; k < a.segments[s].knots.size(); ++k) {
      EXPECT_EQ(a.segments[s].knots[k].u, b.segments[s].knots[k].u);
      EXPECT_EQ(a.segments[s].knots[k].q, b.segments[s].knots[k].q);
    }
  }
}

TEST(Planner, SameSeed_SameBitsForAnyNumberOfThreads) {
  const PlanningProblem problem = hand_problem();
  for (const int trees : {1, 2, 3}) {
    std::vector<PlanResult> results(3);
    for (int i = 0; i < 3; ++i) {
      PlannerOptions options = hand_options();
      options.seed = 3;
      options.threads = 1 + i;
      options.trees = trees;
      ASSERT_EQ(plan(problem, options, {}, results[static_cast<std::size_t>(i)]), Status::Solved) << trees;
    }
    for (int i = 1; i < 3; ++i) {
      const PlanResult &a = results[0], &b = results[static_cast<std::size_t>(i)];
      EXPECT_EQ(a.iterations, b.iterations) << trees;
      EXPECT_EQ(a.nodes, b.nodes);
      EXPECT_EQ(a.steps, b.steps);
      EXPECT_EQ(a.regrasps.tried, b.regrasps.tried);
      expect_same_bits(a.plan, b.plan);
    }
  }
}

/// The first tree grows as it would alone; it is either done first, or another one was with less.
TEST(Planner, TreesSideBySide_TheFirstThatIsDoneGivesThePlan) {
  const PlanningProblem problem = hand_problem();
  PlannerOptions options = hand_options();
  int first = 0;
  constexpr int kSeeds = 12;
  for (int seed = 0; seed < kSeeds; ++seed) {
    PlanResult alone, both;
    options.seed = static_cast<std::uint64_t>(seed);
    options.trees = 1;
    options.batch = 4;
    ASSERT_EQ(plan(problem, options, {}, alone), Status::Solved);
    options.trees = 2;
    options.batch = 8;
    ASSERT_EQ(plan(problem, options, {}, both), Status::Solved);
    if (both.nodes > alone.nodes && both.cost == alone.cost) {
      ++first;
      expect_same_bits(both.plan, alone.plan);
    } else {
      EXPECT_LT(both.steps, 2 * alone.steps) << "two trees that have cost as much";
    }
  }
  EXPECT_GT(first, 0);
  EXPECT_LT(first, kSeeds);
}

TEST(Planner, UnreachableGoal_KeepsTheBestPath) {
  PlanningProblem problem = hand_problem();
  problem.goal.X_WG.p += Eigen::Vector3d(0, 0, 3);
  PlannerOptions options = hand_options();
  options.max_iterations = 300;
  PlanResult result;
  EXPECT_EQ(plan(problem, options, {}, result), Status::MaxIterations);
  EXPECT_EQ(result.iterations, 300);
  EXPECT_FALSE(result.plan.segments.empty());
  EXPECT_LT(result.plan.error.position, 3.0 + 1e-9);
}

TEST(Planner, Tree_LeadsFromEveryNodeToTheStart) {
  const PlanningProblem problem = hand_problem();
  PlannerOptions options = hand_options();
  options.max_iterations = 200;
  options.stop_at_goal = false;
  options.threads = 1;  // which takes all turns: it is the calling one that reports
  long reports = 0;
  double fraction = 0, elapsed_s = 0;
  core::RunControl control;
  control.deadline = core::RunControl::Clock::now() + std::chrono::hours(1);
  control.on_progress = [&](const core::Progress& p) {
    ++reports;
    EXPECT_GE(p.fraction, fraction);
    EXPECT_GE(p.elapsed_s, elapsed_s);
    fraction = p.fraction;
    elapsed_s = p.elapsed_s;
  };
  PlanResult result;
  (void)plan(problem, options, control, result);
  ASSERT_EQ(static_cast<long>(result.tree.size()), result.nodes);
  ASSERT_GT(result.nodes, 20);
  EXPECT_EQ(result.tree[0].parent, -1);
  const world::Pose start = world::object_pose(*problem.model, problem.q_start, problem.goal.object);
  EXPECT_LT((result.tree[0].X_WB.p - start.p).norm(), 1e-2);
  for (std::size_t i = 1; i < result.tree.size(); ++i) {
    EXPECT_GE(result.tree[i].parent, 0);
    EXPECT_LT(result.tree[i].parent, static_cast<int>(i));
  }
  EXPECT_GT(reports, 10);
  EXPECT_EQ(fraction, 1.0) << "all iterations are used up";
  EXPECT_GT(elapsed_s, 0.0);
}

TEST(Planner, CancelledAtOnce_ReturnsTheStart) {
  const PlanningProblem problem = hand_problem();
  const std::atomic<bool> cancel{true};
  core::RunControl control;
  control.cancel = &cancel;
  PlanResult result;
  EXPECT_EQ(plan(problem, hand_options(), control, result), Status::Cancelled);
  EXPECT_EQ(result.iterations, 0);
  EXPECT_NEAR(result.plan.error.angle, 1.5, 0.01);
}

TEST(Planner, DeadlineInThePast_EndsBeforeTheFirstRound) {
  const PlanningProblem problem = hand_problem();
  core::RunControl control;
  control.deadline = core::RunControl::Clock::now();
  PlanResult result;
  EXPECT_EQ(plan(problem, hand_options(), control, result), Status::MaxIterations);
  EXPECT_EQ(result.iterations, 0);
}

/// A ball that a pusher on two sliders may push along a slide, on a floor or not.
PlanningProblem slide_problem(bool gravity, double reach) {
  world::Scene scene = load_model("planar_pushing")->scene();
  scene.objects[0].joint = world::ObjectJoint::Slider;
  scene.objects[0].axis = Eigen::Vector3d::UnitZ();
  scene.objects[0].limits = {{-reach, reach}};
  scene.gravity = Eigen::Vector3d(0, 0, gravity ? -10 : 0);
  PlanningProblem problem;
  problem.model = world::Model::make(scene);
  problem.q_start = Eigen::Vector3d(0.5, 0, -0.2);
  problem.goal.X_WG.p = Eigen::Vector3d(0, 0, 0.8);
  return problem;
}

PlannerOptions slide_options() {
  PlannerOptions options;
  options.threads = 1;
  options.sample_boxes.push_back({0, Eigen::VectorXd::Constant(1, -1), Eigen::VectorXd::Constant(1, 1)});
  return options;
}

TEST(Planner, GoalOutsideTheRange_IsRefused) {
  PlanResult result;
  const auto problem = slide_problem(false, 0.7);
  EXPECT_EQ(stiction::test::message_of([&] { (void)plan(problem, slide_options(), {}, result); }),
            "goal: got box/position = 0.8, expected a value in its range [-0.7, 0.7]");
  auto region = problem;
  region.goal.region = GoalRegion{Eigen::VectorXd::Constant(1, 0.8), Eigen::VectorXd::Constant(1, 0.9)};
  EXPECT_EQ(stiction::test::message_of([&] { (void)plan(region, slide_options(), {}, result); }),
            "goal: got box/position in [0.8, 0.9], expected a value in its range [-0.7, 0.7]");
}

TEST(Planner, GoalInsideAFixedBody_IsRefused) {
  PlanningProblem problem = slide_problem(false, 2);
  world::Scene scene = problem.model->scene();
  scene.fixed.push_back({.name = "wall", .X_WB = {}, .geometries = {{.name = "ball", .shape = world::Sphere{0.1}, .X_BG = {}}}});
  scene.fixed[0].X_WB.p.z() = 1.2;
  problem.model = world::Model::make(scene);
  PlanResult result;
  EXPECT_EQ(stiction::test::message_of([&] { (void)plan(problem, slide_options(), {}, result); }),
            "goal: got a pose in which 'box/box' is 0.2 m inside 'wall/ball', expected one outside everything that cannot move");
}

TEST(Planner, ObjectThatFalls_IsReported) {
  PlanningProblem problem = slide_problem(true, 1e3);
  problem.q_start[1] = 5;  // the pusher is not below
  PlannerOptions options = slide_options();
  options.max_iterations = 100;
  PlanResult result;
  EXPECT_EQ(planning::plan(problem, options, {}, result), core::Status::NumericalFailure);
  EXPECT_NE(result.reason.find("do not come to rest"), std::string::npos) << result.reason;
  EXPECT_GT(result.start_moved, 1);
}

TEST(Planner, RobotThatCannotReach_EndsWithTheReason) {
  PlanningProblem problem = slide_problem(false, 2);
  world::Scene scene = problem.model->scene();
  scene.filters.push_back({"hand", "box", std::nullopt});
  problem.model = world::Model::make(scene);
  PlanResult result;
  EXPECT_EQ(plan(problem, slide_options(), {}, result), core::Status::MaxIterations);
  EXPECT_NE(result.reason.find("cannot touch an object"), std::string::npos) << result.reason;

  problem = hand_problem();  // the ball is farther away than the arms are long
  problem.q_start[1] = 3;
  problem.goal.X_WG.p.z() = 3;
  EXPECT_EQ(plan(problem, hand_options(), {}, result), core::Status::MaxIterations);
  EXPECT_NE(result.reason.find("cannot touch an object"), std::string::npos) << result.reason;
  EXPECT_LT(result.iterations, 20000);
}

TEST(Planner, StartAtTheGoal_IsSolvedWithoutMoving) {
  PlanningProblem problem = hand_problem();
  problem.goal.X_WG = world::object_pose(*problem.model, problem.q_start, 0);
  PlanResult result;
  EXPECT_EQ(plan(problem, hand_options(), {}, result), Status::Solved);
  EXPECT_EQ(result.iterations, 0);
}

TEST(Planner, StartInPenetration_IsProjectedAndReported) {
  PlanningProblem problem = hand_problem();
  problem.q_start[1] = 0.28;  // the ball deep in the arms
  PlannerOptions options = hand_options();
  options.max_iterations = 1;
  PlanResult result;
  (void)plan(problem, options, {}, result);
  EXPECT_GT(result.start_penetration, 0.01);
  EXPECT_TRUE(result.start_projected);
  ASSERT_FALSE(result.plan.segments.empty());
  EXPECT_EQ(result.plan.segments.front().kind, SegmentKind::Settle);
}

TEST(Planner, ProgressAndBudget_AreReported) {
  const PlanningProblem problem = hand_problem();
  PlannerOptions options = hand_options();
  options.stop_at_goal = false;
  options.max_iterations = 100;
  options.threads = 1;  // which takes all turns: it is the calling one that reports
  long calls = 0, last = 0;
  core::RunControl control;
  control.on_progress = [&](const core::Progress& p) {
    ++calls;
    EXPECT_GT(p.iteration, last);
    last = p.iteration;
  };
  PlanResult result;
  EXPECT_EQ(plan(problem, options, control, result), Status::MaxIterations);
  EXPECT_EQ(result.iterations, 100);
  EXPECT_EQ(last, 100);
  EXPECT_EQ(calls, 13);  // rounds of 8
}

TEST(Planner, CancelledTreesSideBySide_TheNearestIsKept) {
  PlanningProblem problem = hand_problem();
  problem.goal.X_WG.p += Eigen::Vector3d(0, 0, 3);  // out of reach
  for (std::uint64_t seed = 0; seed < 8; ++seed) {
    PlannerOptions options = hand_options();
    options.seed = seed;
    options.threads = 1;
    std::atomic<bool> stop = false;
    double best = 0;
    core::RunControl control;
    control.cancel = &stop;
    control.on_progress = [&](const core::Progress& p) {
      best = p.best;  // of all trees
      stop = p.iteration >= 80;
    };
    PlanResult result;
    EXPECT_EQ(plan(problem, options, control, result), Status::Cancelled);
    const double share = std::max(result.plan.error.position / problem.goal.tol_position, result.plan.error.angle / problem.goal.tol_angle);
    EXPECT_LE(share, best * (1 + 1e-6)) << "seed " << seed;  // a round under way may have come nearer since
  }
}

TEST(Planner, BadOptions_NameTheField) {
  const PlanningProblem problem = hand_problem();
  const auto message = [&](auto&& change) -> std::string {
    PlannerOptions options = hand_options();
    change(options);
    PlanResult result;
    try {
      (void)plan(problem, options, {}, result);
    } catch (const core::InvalidInput& e) {
      return e.what();
    }
    return "no error";
  };
  EXPECT_EQ(message([](auto& o) { o.goal_bias = 1.5; }), "planner.goal_bias: got 1.5, expected a probability in [0, 1]");
  EXPECT_EQ(message([](auto& o) { o.gamma = 0; }), "planner.gamma: got 0, expected a finite number > 0");
  EXPECT_EQ(message([](auto& o) { o.brace_force = 0; }), "planner.brace_force: got 0, expected a number > 0");
  EXPECT_EQ(message([](auto& o) { o.grasp_trials = -1; }), "planner.grasp_trials: got -1, expected 0 or more");
  EXPECT_EQ(message([](auto& o) { o.sampler.whole_probability = -0.1; }),
            "planner.sampler.whole_probability: got -0.1, expected a probability in [0, 1]");
  EXPECT_EQ(message([](auto& o) { o.sampler.near_probability = 2; }),
            "planner.sampler.near_probability: got 2, expected a probability in [0, 1]");
  EXPECT_EQ(message([](auto& o) { o.sampler.near_std = 0; }), "planner.sampler.near_std: got 0, expected a finite number > 0");
  EXPECT_EQ(message([](auto& o) { o.sampler.tries = 0; }), "planner.sampler.tries: got 0, expected at least 1");
  EXPECT_EQ(message([](auto& o) { o.batch = 0; }), "planner.batch: got 0, expected at least 1");
  EXPECT_EQ(message([](auto& o) { o.trees = 0; }), "planner.trees: got 0, expected at least 1");
  EXPECT_EQ(message([](auto& o) { o.sample_boxes[0].lower.resize(2); }), "planner.sample_box.lower: got 2 numbers, expected 3");
  EXPECT_EQ(message([](auto& o) { o.start_noise = -1; }), "planner.start_noise: got -1, expected a finite number ≥ 0");
  EXPECT_EQ(message([](auto& o) { o.friction_noise = 1; }), "planner.friction_noise: got 1, expected a share in [0, 1)");
  EXPECT_EQ(message([](auto& o) { o.refined_fraction = 0.5; }),
            "planner.refined_fraction: got 0.5, expected a number in [0.9, 1]: tolerance_fraction or more");
  EXPECT_EQ(message([](auto& o) { o.edge_tilt = -1; }), "planner.edge_tilt: got -1, expected an angle in [0, π/2) [rad]");
  EXPECT_EQ(message([](auto& o) { o.friction_law = dynamics::FrictionLaw::Coulomb; }),
            "planner.friction_law: got coulomb, expected anitescu for a planar model");
  EXPECT_EQ(message([](auto& o) { o.friction = 0; }), "planner.friction: got 0, expected a number in (0, 1]");
  EXPECT_EQ(message([](auto& o) { o.grip_force = -1; }), "planner.grip_force: got -1, expected a finite number ≥ 0");
  EXPECT_EQ(message([](auto& o) { o.regrasp_friction = 0; }), "planner.regrasp_friction: got 0, expected a number in (0, 1]");
}

}  // namespace
}  // namespace stiction::planning::test
