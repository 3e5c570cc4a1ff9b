#include "stiction/planning/tools.hpp"

#include "planning/simulated_plan.hpp"
#include "planning/systems.hpp"
#include "stiction/planning/expansion.hpp"

namespace stiction::planning::test {
namespace {

std::shared_ptr<const world::Model> load_test_model(const std::string& task) {
  return world::Model::make(world::load_scene(stiction::test::source_dir() / "tests/tasks/data" / (task + ".yaml")));
}

/// tests/tasks/data/stick.yaml: the hand passes through the box (object 0), and moves it with the stick (object 1).
PlanningProblem stick_problem() {
  PlanningProblem problem;
  problem.model = load_test_model("stick");
  problem.q_start = (Eigen::VectorXd(8) << 0, 1.2, 0, 0.8, 0.2, 1.2, 0, -0.4).finished();
  problem.goal = {.object = 0, .X_WG = {.R = Eigen::Matrix3d::Identity(), .p = {0, 0, 1.8}}, .tol_position = 0.05, .tol_angle = 0.2};
  return problem;
}

struct Stick {
  PlanningProblem problem = stick_problem();
  PlannerOptions options{};
  Setting setting{problem, options};
  Tools tools{setting};
  core::RunControl control{};
  ThreadScratch scratch{problem.model, control};
};

/// The box has to go up: all places are below it, touch it, and are in nothing.
TEST(Tools, PlacesBehind_TouchTheBoxFromBelow) {
  Stick s;
  const world::Model& model = *s.problem.model;
  core::Random random(1, 0);
  int found = 0;
  for (int k = 0; k < 50; ++k) {
    Eigen::VectorXd q = s.problem.q_start, q_u = q.head(6);
    if (!s.tools.draw_behind(1, q, random, s.scratch.geometry, q_u)) continue;
    ++found;
    EXPECT_EQ(q_u.head<3>(), q.head<3>()) << "the box stays";
    q.head(6) = q_u;
    contact::GeometryWorkspace work(model);
    world::calc_kinematics(model, q, work.kinematics_work, work.kinematics);
    contact::query(model, work.kinematics, {}, work.contact_work, work.contacts);
    double gap = 1;
    for (const auto& c : work.contacts) {
      const auto& pair = model.pairs()[static_cast<std::size_t>(c.pair)];
      const bool with_box = model.geometries()[static_cast<std::size_t>(pair.geometry_a)].body == model.objects()[0].body;
      if (!with_box || model.geometries()[static_cast<std::size_t>(pair.geometry_b)].body != model.objects()[1].body) continue;
      gap = std::min(gap, c.phi);
      EXPECT_TRUE(c.phi > 0.004 || c.nhat_BA_W.z() > 0.29) << q_u.transpose();
    }
    EXPECT_GE(gap, -1e-9);
    EXPECT_LT(gap, 0.004) << q_u.transpose();
  }
  EXPECT_GT(found, 25);
}

TEST(Tools, RobotsTakeHoldOfTheStick_ForTheBoxOnceItIsNear) {
  Stick s;
  Eigen::VectorXd q = s.problem.q_start;
  EXPECT_TRUE(s.tools.touchable({0}, q, s.scratch.geometry).empty()) << "the stick is beside the box";
  const auto pairs_of_stick = s.tools.touchable({1}, q, s.scratch.geometry);
  ASSERT_FALSE(pairs_of_stick.empty());
  q.segment<3>(3) << 0, 0.601, 0;  // 1 mm below the box
  EXPECT_EQ(s.tools.touchable({0}, q, s.scratch.geometry), pairs_of_stick);
  for (std::size_t i = 0; i < pairs_of_stick.size(); ++i) {
    const auto& pair = s.problem.model->pairs()[i];
    const int body = s.problem.model->geometries()[static_cast<std::size_t>(pair.geometry_a)].body;
    EXPECT_EQ(pairs_of_stick[i] != 0,
              body == s.problem.model->objects()[1].body && s.setting.chains.mask_of_pair(static_cast<int>(i)) != 0);
  }
}

/// The stick may be anywhere, so that the goal does not pull it back; where the hand can touch the box there is no tool, and nothing changes.
TEST(Tools, GoalIsNotAboutTheTool) {
  Stick s;
  Eigen::VectorXd q = s.problem.q_start;
  EXPECT_NEAR(s.setting.goal.distance(q), 0.6 / 0.05, 1e-12);
  q.segment<3>(3) << 5, 5, 1;
  EXPECT_NEAR(s.setting.goal.distance(q), 0.6 / 0.05, 1e-12);
  EXPECT_EQ(s.setting.goal.bounded(), (Eigen::VectorXd(6) << 1, 1, 1, 0, 0, 0).finished());

  PlanningProblem touchable;
  touchable.model = load_test_model("two_boxes");
  touchable.q_start = (Eigen::VectorXd(8) << -0.6, 0.5, 0, 0.6, 0.5, 0, 0, -0.2).finished();
  touchable.goal = {.object = 0, .X_WG = {.R = Eigen::Matrix3d::Identity(), .p = {0, -0.6, 1}}};
  const Setting setting(touchable, s.options);
  const Tools none(setting);
  EXPECT_FALSE(none.any());
  core::Random drawn(2, 0), fresh(2, 0);
  EXPECT_EQ(none.draw(drawn), -1);
  EXPECT_EQ(drawn.bits(), fresh.bits());
  EXPECT_EQ(setting.goal.bounded(), Eigen::VectorXd::Ones(6));
}

TEST(Plan, BoxThatOnlyAStickCanMove_ComesToItsGoal) {
  const PlanningProblem problem = stick_problem();
  for (const std::uint64_t seed : {1, 2, 4}) {
    PlannerOptions options;
    options.seed = seed;
    options.threads = 2;
    options.max_iterations = 5000;
    PlanResult result;
    ASSERT_EQ(plan(problem, options, {}, result), core::Status::Solved) << seed;
    const Eigen::VectorXd q = simulate(problem, result.plan, 2);
    EXPECT_TRUE(goal_error(*problem.model, q, problem.goal).within(problem.goal)) << seed;
    EXPECT_GT((q - problem.q_start).segment<3>(3).norm(), 0.3) << "with the stick";
  }
}

/// The hand carries the stick about while it looks for a way to the box; as a bystander the stick stays within its limits in all nodes.
TEST(Plan, Bystanders_StayWithinTheirLimits) {
  PlanningProblem problem = stick_problem();
  PlannerOptions options;
  options.threads = 2;
  options.max_iterations = 300;
  const auto farthest = [&] {
    double most = 0;
    const GrowthSink see = [&](const Growth& growth) {
      for (const auto& q : growth.q.colwise()) most = std::max(most, (q - problem.q_start).segment<2>(3).norm());
    };
    PlanResult result;
    (void)plan_watched(problem, {}, options, {}, see, result);
    EXPECT_GT(result.nodes, 20);
    return most;
  };
  EXPECT_GT(farthest(), 0.3);
  problem.goal.bystanders = Bystanders{{1}, problem.q_start.head(6), 0.2, std::numeric_limits<double>::infinity()};
  const double held = farthest();
  EXPECT_LE(held, 0.2);
  EXPECT_GT(held, 0.1) << "it moves at all";
}

}  // namespace
}  // namespace stiction::planning::test
