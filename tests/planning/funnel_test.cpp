#include "stiction/planning/funnel.hpp"

#include <atomic>

#include "planning/push_plan.hpp"
#include "stiction/planning/object_space.hpp"

namespace stiction::planning::test {
namespace {

using core::Status;
using Eigen::VectorXd;

/// planar_pushing, the box pushed up to its goal by the hand below it.
struct PushedUp {
  PushedUp() {
    options.substep = dynamics::SubstepLimits{.joint_angle = 0.03, .joint_travel = 0.03, .slide = 2e-3, .max_substeps = 400};
    options.gamma = 1e-2;
    options.funnel = 2;
    refine_options.seed = 7;  // of the first ten seven make a funnel that is kept: one ball pushes the box, at a point
    given.substep = *options.substep;
  }

  Funnel run(Plan& plan, int threads = 1) {
    core::ThreadPool pool(threads);
    plan = given;
    return append_funnel(model, q_end(), options, refine_options, control, pool, plan);
  }

  VectorXd q_end() const { return given.segments.empty() ? given.q_start : given.segments.back().knots.back().q; }

  /// Distance from the goal, in tolerances, of a box that is off by e at the end of the given plan, after the commands of the funnel.
  double follow(const Plan& plan, const VectorXd& e) {
    dynamics::StepWorkspace work(model);
    dynamics::StepResult r;
    VectorXd q = q_end();
    bool home = false;  // the box is off once the robot has left it
    for (std::size_t i = given.segments.size(); i < plan.segments.size(); ++i) {
      for (const auto& knot : plan.segments[i].knots) {
        EXPECT_EQ(dynamics::step(*model, {q, knot.u}, plan.step, work, r), Status::Solved);
        q = r.q_next;
      }
      if (std::exchange(home, true)) continue;
      VectorXd error = VectorXd::Zero(model->n_v());
      error.head(e.size()) = e;
      world::retract(*model, VectorXd(q), error, q);
    }
    const GoalError error = goal_error(*model, q, plan.goal);
    return std::max(error.position / plan.goal.tol_position, error.angle / plan.goal.tol_angle);
  }

  std::shared_ptr<const world::Model> model = load_model("planar_pushing");
  PlannerOptions options;
  RefineOptions refine_options;
  core::RunControl control;
  Plan given = push_up(model);
};

TEST(Funnel, BoxOnAPlane_ComesToTheGoalFromWhereverItIs) {
  PushedUp p;
  Plan plan;
  const Funnel funnel = p.run(plan);
  ASSERT_GE(funnel.pushes, 3);
  EXPECT_NEAR(funnel.before, p.options.funnel, 0.1);
  EXPECT_LE(funnel.after, 0.5 * funnel.before);
  EXPECT_EQ(funnel.failed_steps, 0);
  // Simulated here: along each coordinate, and at once in all.
  const Goal& goal = plan.goal;
  const Eigen::Vector3d most = p.options.funnel * Eigen::Vector3d(goal.tol_position, goal.tol_position, goal.tol_angle);
  EXPECT_LE(p.follow(plan, VectorXd::Zero(3)), 1);
  for (int i = 0; i < 3; ++i) {
    for (const double sign : {1.0, -1.0}) EXPECT_LE(p.follow(plan, sign * most[i] * VectorXd::Unit(3, i)), funnel.after + 0.1) << i;
  }
  core::Random random(3, 0);
  int nearer = 0, near = 0;  // places that nobody looked at: the robot may run into a box there, and throws it far away
  for (int k = 0; k < 20; ++k) {
    const Eigen::Vector3d s(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
    const double before = p.options.funnel * std::max(s.head<2>().norm(), std::abs(s[2])), after = p.follow(plan, s.cwiseProduct(most));
    nearer += after < before;
    near += after <= 1;
  }
  EXPECT_GE(nearer, 15);
  EXPECT_GE(near, 13);
}

TEST(Funnel, Plan_StaysOneInItsOwnSteps) {
  PushedUp p;
  Plan plan;
  const Funnel funnel = p.run(plan);
  ASSERT_GT(funnel.pushes, 0);
  ASSERT_EQ(plan.segments.size(), p.given.segments.size() + 2 * static_cast<std::size_t>(funnel.pushes) + 1) << "the way home comes first";
  const GoalError error = goal_error(*p.model, plan.segments.back().knots.back().q, plan.goal);
  EXPECT_EQ(error.position, plan.error.position);
  EXPECT_LE(std::max(error.position / plan.goal.tol_position, error.angle / plan.goal.tol_angle), funnel.after);
  dynamics::StepWorkspace work(p.model);
  dynamics::StepResult r;
  GeometryWorkspace geometry(*p.model);
  const RobotChains chains(*p.model);
  VectorXd q = p.q_end();
  for (std::size_t i = p.given.segments.size(); i < plan.segments.size(); ++i) {
    const Segment& segment = plan.segments[i];
    const std::size_t number = i - p.given.segments.size();
    EXPECT_EQ(segment.kind == SegmentKind::Regrasp, number == 0 || number % 2 == 1);
    if (segment.kind == SegmentKind::Regrasp) {
      EXPECT_TRUE(is_free_on_its_way(*p.model, chains, segment.knots, geometry));
    }
    for (const auto& knot : segment.knots) {
      ASSERT_EQ(dynamics::step(*p.model, {q, knot.u}, plan.step, work, r), Status::Solved);
      EXPECT_LT((r.q_next - knot.q).cwiseAbs().maxCoeff(), 1e-9);
      q = knot.q;
    }
  }
}

TEST(Funnel, NumberOfThreads_ChangesNothing) {
  PushedUp p;
  Plan one, three;
  const Funnel a = p.run(one, 1), b = p.run(three, 3);
  EXPECT_EQ(a.pushes, b.pushes);
  EXPECT_EQ(a.steps, b.steps);
  ASSERT_EQ(one.segments.size(), three.segments.size());
  for (std::size_t i = 0; i < one.segments.size(); ++i) {
    ASSERT_EQ(one.segments[i].knots.size(), three.segments[i].knots.size());
    for (std::size_t k = 0; k < one.segments[i].knots.size(); ++k) EXPECT_EQ(one.segments[i].knots[k].q, three.segments[i].knots[k].q);
  }
}

TEST(Funnel, WhereNothingComesOfIt_ThePlanIsAsItWas) {
  PushedUp p;
  Plan plan;
  const std::atomic<bool> cancel{true};
  p.control.cancel = &cancel;
  EXPECT_EQ(p.run(plan).pushes, 0) << "cancelled";
  EXPECT_EQ(plan.segments.size(), p.given.segments.size());
  p.control.cancel = nullptr;
  p.options.funnel = 0.1;  // all places are at the goal by the tolerance_fraction
  p.options.tolerance_fraction = 0.9;
  EXPECT_EQ(p.run(plan).pushes, 0);
  EXPECT_EQ(plan.segments.size(), p.given.segments.size());
  p.options.funnel = 2;
  p.refine_options.seed = 0;
  const Funnel poor = p.run(plan);
  EXPECT_GT(poor.after, 0.5 * poor.before);
  EXPECT_LT(poor.after, poor.before);
  EXPECT_EQ(poor.pushes, 0) << "the farthest place is left at more than half of the distance";
  EXPECT_EQ(plan.segments.size(), p.given.segments.size());
  p.given.segments.clear();
  EXPECT_EQ(p.run(plan).pushes, 0) << "no plan";
}

/// A ball on an open hand that the fingers hold up: it falls when they leave.
TEST(Funnel, ObjectThatFallsWithoutTheRobot_IsLeftInItsGrip) {
  const auto model = load_model("planar_hand");
  PlannerOptions options;
  options.funnel = 1;
  Plan plan;
  plan.q_start = model->neutral();
  plan.u_start = plan.q_start.tail(model->n_a());
  plan.goal.tol_position = 1e-3;  // farther than that is out of the hand
  plan.step = options.step_options();
  plan.substep = *options.substep;
  plan.segments = {{SegmentKind::Contact, {{.u = plan.u_start, .q = plan.q_start, .contacts = {}}}}};
  plan.goal.X_WG = world::object_pose(*model, plan.q_start, 0);
  core::ThreadPool pool(1);
  EXPECT_EQ(append_funnel(model, plan.q_start, options, {}, {}, pool, plan).pushes, 0);
  EXPECT_EQ(plan.segments.size(), 1u);
}

TEST(Refine, Funnel_IsAppendedAndReported) {
  PushedUp p;
  for (const double funnel : {0.0, 2.0}) {
    p.options.funnel = funnel;
    RefineResult r;
    ASSERT_EQ(refine(p.model, p.given, p.options, p.refine_options, p.control, r), Status::Solved);
    EXPECT_EQ(r.funnel.pushes > 0, funnel > 0);
    EXPECT_EQ(r.regrasps, r.funnel.pushes) << "the way home and the way to the first push are one";
  }
}

}  // namespace
}  // namespace stiction::planning::test
