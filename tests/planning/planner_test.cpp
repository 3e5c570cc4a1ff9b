#include "stiction/planning/planner.hpp"

#include "planning/simulated_plan.hpp"
#include "planning/systems.hpp"
#include "stiction/core/invalid_input.hpp"
#include "stiction/planning/thresholds.hpp"
#include "stiction/world/object_space.hpp"
#include "support/message_of.hpp"

namespace stiction::planning::test {
namespace {

using core::Status;

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
        EXPECT_LE((knot.u - u).cwiseAbs().maxCoeff(), result.plan.substep.joint_angle * (1 + 1e-9));
        u = knot.u;
      }
    }
  }
}

/// Whole and half sub-steps agree on every edge of a plan.
TEST(Planner, Edges_AgreeAtBothResolutions) {
  const PlanningProblem problem = hand_problem();
  PlannerOptions options = hand_options();
  const world::ObjectSpace space(*problem.model);
  for (options.seed = 0; options.seed < 3; ++options.seed) {
    PlanResult result;
    ASSERT_EQ(plan(problem, options, {}, result), Status::Solved);
    Plan part = result.plan;
    part.segments.clear();
    Eigen::VectorXd before = Eigen::VectorXd::Zero(3), after(3);
    for (const Segment& segment : result.plan.segments) {
      part.segments.push_back(segment);
      space.error(segment.knots.back().q.data(), simulate(problem, part, 2).data(), after.data());
      const auto share = [&](const Eigen::VectorXd& e) {
        return world::largest_share(*problem.model, e, problem.goal.tol_position, problem.goal.tol_angle);
      };
      EXPECT_LE(share(after - before), threshold::kFidelityEdge * (1 + 1e-3)) << "edge " << part.segments.size();
      EXPECT_LE(share(after), threshold::kFidelityPath * (1 + 1e-3)) << "edge " << part.segments.size();
      before = after;
    }
  }
}

/// (P.11): however far a push has strained the springs, the next one starts from there, or from as much of it as the preload leaves.
TEST(Planner, Preload_APushStartsWithTheGripOfTheOneBefore) {
  const PlanningProblem problem = hand_problem();
  const auto& model = *problem.model;
  const double grip = SceneThresholds(model, 0).preload;
  PlannerOptions options = hand_options();
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
      EXPECT_LE((end - start).norm(), threshold::kLength * (1 + 1e-9)) << "seed " << options.seed << ", segment " << s;
      kept += (end - q_a).norm() > threshold::kLength * (1 + 1e-9);
      ++pushes;
    }
  }
  EXPECT_GT(pushes, 10);
  EXPECT_GT(kept, 0) << "some push goes farther than it could from the joints";
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
  for (const std::uint64_t seed : {3U, 4U, 5U}) {
    std::vector<PlanResult> results(3);
    for (int i = 0; i < 3; ++i) {
      PlannerOptions options = hand_options();
      options.seed = seed;
      options.threads = 1 + i;
      ASSERT_EQ(plan(problem, options, {}, results[static_cast<std::size_t>(i)]), Status::Solved) << seed;
    }
    for (int i = 1; i < 3; ++i) {
      const PlanResult &a = results[0], &b = results[static_cast<std::size_t>(i)];
      EXPECT_EQ(a.iterations, b.iterations) << seed;
      EXPECT_EQ(a.nodes, b.nodes);
      EXPECT_EQ(a.steps, b.steps);
      EXPECT_EQ(a.regrasps.tried, b.regrasps.tried);
      ASSERT_EQ(a.refused.size(), b.refused.size());
      for (std::size_t k = 0; k < a.refused.size(); ++k) EXPECT_EQ(a.refused[k].q, b.refused[k].q);
      expect_same_bits(a.plan, b.plan);
    }
  }
}

/// Every move that was refused is counted once, at the node that it began from, also of trees that stalled.
TEST(Planner, RefusedMoves_AreThoseThatWereCounted) {
  PlanningProblem problem = hand_problem();
  problem.goal.tol_position = 1e-4;
  problem.goal.tol_angle = 1e-3;
  PlannerOptions options = hand_options();
  options.max_iterations = 3000;
  PlanResult result;
  ASSERT_EQ(plan(problem, options, {}, result), Status::MaxIterations);
  RegraspCounts sum;
  for (const auto& [q, counts] : result.refused) {
    ASSERT_EQ(q.size(), problem.model->n_q());
    EXPECT_GT(counts.tried, counts.accepted) << "a node from which nothing was refused is not there";
    EXPECT_EQ(counts.no_sample + counts.no_path + counts.object_moved + counts.failed_step, counts.tried - counts.accepted);
    sum += counts;
  }
  const RegraspCounts& all = result.regrasps;
  EXPECT_FALSE(result.refused.empty());
  EXPECT_EQ(sum.tried - sum.accepted, all.tried - all.accepted);
  EXPECT_EQ(sum.no_sample, all.no_sample);
  EXPECT_EQ(sum.no_path, all.no_path);
  EXPECT_EQ(sum.object_moved, all.object_moved);
  EXPECT_EQ(sum.failed_step, all.failed_step);
}

/// An edge that verification refuses is not the best one, and an unsolved plan does not end with it.
TEST(Planner, PlanOfAnUnsolvedRun_EndsWhereHalfStepsDo) {
  PlanningProblem problem = hand_problem();
  problem.goal.tol_position = 1e-4;  // close, so that many edges at the goal are refused
  problem.goal.tol_angle = 1e-3;
  PlannerOptions options = hand_options();
  options.max_iterations = 400;
  int unsolved = 0;
  for (options.seed = 0; options.seed < 6; ++options.seed) {
    PlanResult result;
    if (plan(problem, options, {}, result) == Status::Solved) continue;
    ++unsolved;
    EXPECT_GT(result.plan.error.share(problem.goal), options.tolerance_fraction)
        << "a plan at its goal would be solved, seed " << options.seed;
  }
  EXPECT_GT(unsolved, 0);
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
  PlanningProblem problem = hand_problem();
  PlannerOptions options = hand_options();
  options.max_iterations = 200;
  problem.goal.X_WG.p += Eigen::Vector3d(0, 0, 3);  // out of reach
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
  ASSERT_LE(static_cast<long>(result.tree.size()), result.nodes) << "the better one of two trees";
  ASSERT_GT(result.tree.size(), 10U);
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

TEST(Planner, ProgressAndBudget_AreReported) {
  PlanningProblem problem = hand_problem();
  problem.goal.X_WG.p += Eigen::Vector3d(0, 0, 3);  // out of reach
  PlannerOptions options = hand_options();
  options.max_iterations = 100;
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
  EXPECT_EQ(calls, (100 + threshold::kBatch - 1) / threshold::kBatch) << "one for each round";
}

TEST(Planner, CancelledTreesSideBySide_TheNearestIsKept) {
  PlanningProblem problem = hand_problem();
  problem.goal.X_WG.p += Eigen::Vector3d(0, 0, 3);  // out of reach
  for (std::uint64_t seed = 0; seed < 8; ++seed) {
    PlannerOptions options = hand_options();
    options.seed = seed;
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

}  // namespace
}  // namespace stiction::planning::test
