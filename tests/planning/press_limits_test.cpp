// How hard a plan may press on what is fragile.
#include "stiction/planning/press_limits.hpp"

#include <algorithm>

#include "planning/systems.hpp"
#include "stiction/planning/refine.hpp"

namespace stiction::planning::test {
namespace {

using core::Status;

dynamics::ContactImpulse pressed(int pair, double impulse) {
  dynamics::ContactImpulse out;
  out.contact.pair = pair;
  out.lambda[0] = impulse;
  return out;
}

/// planar_hand, its ball as fragile as given [N].
std::shared_ptr<const world::Model> fragile_hand(double max_force) {
  world::Scene scene = load_model("planar_hand")->scene();
  for (auto& geometry : scene.objects[0].geometries) geometry.max_force = max_force;
  return world::Model::make(scene);
}

TEST(PressLimits, ContactsOfAPair_BearTogetherWhatTheWeakerSideBears) {
  const auto model = fragile_hand(4);
  const world::RobotChains chains(*model);
  const PressLimits press(*model, chains, 1);
  int ball = -1, other = -1;
  for (int i = 0; i < static_cast<int>(model->pairs().size()); ++i) (chains.touches_object(i) ? ball : other) = i;
  ASSERT_TRUE(ball >= 0 && other >= 0);
  const std::vector contacts{pressed(ball, 0.2), pressed(other, 5.0), pressed(ball, 0.1)};
  EXPECT_DOUBLE_EQ(press.share(contacts, 0.1), 3.0 / 4);
  EXPECT_TRUE(press.braces(contacts, 0.1));
  EXPECT_FALSE(press.braces(std::vector{pressed(ball, 5.0)}, 0.1));
  const auto sturdy = load_model("planar_hand");
  EXPECT_EQ(PressLimits(*sturdy, chains, 1).share(contacts, 0.1), 0);
}

/// The largest force on the ball at any knot, and at half of the way to it [N].
double largest_force(const world::Model& model, const std::shared_ptr<const world::Model>& shared, const Plan& plan) {
  dynamics::StepWorkspace work(shared);
  dynamics::StepResult result;
  const world::RobotChains chains(model);
  const PressLimits press(model, chains, 1);
  double most = 0;
  Eigen::VectorXd q = plan.q_start, u = plan.u_start;
  for (const auto& segment : plan.segments) {
    for (const auto& knot : segment.knots) {
      most = std::max(most, press.share(knot.contacts, plan.step.h));
      for (const Eigen::VectorXd& command : {Eigen::VectorXd(0.5 * (u + knot.u)), knot.u}) {
        EXPECT_EQ(dynamics::step(model, {q, command}, plan.step, work, result), Status::Solved);
        most = std::max(most, press.share(result.contacts, plan.step.h));
        q = result.q_next;
      }
      u = knot.u;
    }
  }
  return most * model.pairs()[static_cast<std::size_t>(chains.object_pairs(0)[0])].max_force;
}

/// Half of what it takes without a limit, in the tree, in regrasps and after refinement.
TEST(PressLimits, OfTheBallInAHand_AreKeptByPlansAndTheirRefinement) {
  PlanningProblem problem = hand_problem();
  PlannerOptions options = hand_options();
  double free = 0;
  for (const bool limited : {false, true}) {
    problem.model = fragile_hand(limited ? free / 2 : 1e6);
    const double bears = problem.model->geometries()[0].max_force;
    for (std::uint64_t seed = 0; seed < 3; ++seed) {
      options.seed = seed;
      options.max_iterations = 20000;
      PlanResult planned;
      ASSERT_EQ(plan(problem, options, {}, planned), Status::Solved) << limited << seed;
      RefineResult refined;
      ASSERT_EQ(refine(problem.model, planned.plan, options, {}, {}, refined), Status::Solved) << limited << seed;
      for (const Plan& made : {planned.plan, refined.plan}) {
        const double force = largest_force(*problem.model, problem.model, made);
        if (limited) {
          EXPECT_LE(force, bears) << seed;
        } else {
          free = std::max(free, force);
        }
      }
    }
  }
  EXPECT_GT(free, 0);
}

}  // namespace
}  // namespace stiction::planning::test
