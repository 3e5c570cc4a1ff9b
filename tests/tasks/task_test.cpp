#include "stiction/tasks/task.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <numbers>

#include "stiction/contact/contact.hpp"
#include "stiction/core/invalid_input.hpp"
#include "stiction/core/sha256.hpp"
#include "stiction/dynamics/step.hpp"
#include "stiction/tasks/options.hpp"
#include "stiction/world/object_space.hpp"
#include "stiction/world/yaml.hpp"
#include "support/paths.hpp"
#include "support/temporary_folder.hpp"

namespace stiction::tasks {
namespace {

namespace fs = std::filesystem;

const fs::path kTasks = stiction::test::source_dir() / "tasks";

void expect_refused(const std::function<void()>& call, const std::vector<std::string>& parts) {
  try {
    call();
    ADD_FAILURE() << "accepted, expected a message with '" << parts.front() << "'";
  } catch (const core::InvalidInput& e) {
    for (const auto& part : parts) EXPECT_NE(std::string(e.what()).find(part), std::string::npos) << "no '" << part << "' in: " << e.what();
  }
}

/// Writes a task that is built on a built-in one.
class TaskFile : public testing::Test {
 protected:
  fs::path write(const std::string& base, const std::string& text) const {
    const fs::path file = dir_ / "mine.yaml";
    std::ofstream(file) << "base: " << (kTasks / (base + ".yaml")).string() << "\n" << text;
    return file;
  }

  const stiction::test::TemporaryFolder temporary_;
  const std::filesystem::path& dir_ = temporary_.path();
};

/// The base says the start as a quaternion and the goal as angles.
TEST_F(TaskFile, RotationOfTheBase_IsSpelledAnewTheOtherWay) {
  const Task task = load_task(write("allegro_cube", R"(
start: {objects: {cube: {rpy: [0, 0, 0.2]}}}
goal: {objects: {cube: {quaternion_wxyz: [0.955336489125606, 0, 0, 0.29552020666133955]}}}
)")
                                  .string());
  const double yaw = 2 * std::atan2(task.problem.q_start[5], task.problem.q_start[6]);
  EXPECT_NEAR(yaw, 0.2, 1e-12);
  EXPECT_NEAR(std::atan2(task.problem.goal.X_WG.R(1, 0), task.problem.goal.X_WG.R(0, 0)), 0.6, 1e-12);
  EXPECT_NEAR(task.problem.q_start[0], -0.065, 1e-15) << "the position of the base stays";
}

/// What a planar object is turned to is a rotation; the reference takes the nearest turn.
TEST(Tasks, ReferenceOfOptimize_IsTheSameAfterAFullTurnOfAPlanarObject) {
  Task task = load_task("impc_planar_pushing");
  const int theta = task.model->objects()[0].q_begin + 2;
  const double turn = 2 * std::numbers::pi, start = task.problem.q_start[theta];
  const auto reference = [&] { return make_optimize_input(task).reference.back()[theta]; };
  const double same = reference();
  task.problem.q_goal[theta] += 2 * turn;
  EXPECT_NEAR(reference(), same, 1e-14);
  task.problem.q_start[theta] = start + turn;
  EXPECT_NEAR(reference(), same + turn, 1e-14);
}

TEST(Tasks, BuiltIn_AllLoadAndAreComplete) {
  const auto names = list_tasks(default_data_dirs());
  EXPECT_GE(names.size(), 6u);
  for (const auto& name : names) {
    SCOPED_TRACE(name);
    const Task task = load_task(name);
    EXPECT_EQ(task.name, name);
    EXPECT_TRUE(task.builtin);
    EXPECT_FALSE(task.description.empty());
    EXPECT_EQ(task.problem.q_start.size(), task.model->n_q());
    EXPECT_EQ(task.scene_sha256, core::sha256(task.scene_text));
    EXPECT_EQ(task.scene_text.find(stiction::test::source_dir().string()), std::string::npos) << "an absolute path";
  }
}

bool is_variant(const std::string& name) { return name.ends_with("_table_3_2"); }

TEST(Tasks, BuiltIn_StartWithoutDeepPenetration) {
  for (const auto& name : list_tasks(default_data_dirs())) {
    SCOPED_TRACE(name);
    const Task task = load_task(name);
    const world::Model& model = *task.model;
    world::KinematicsWorkspace kinematics_work(model);
    world::Kinematics kinematics;
    contact::Workspace work(model);
    world::calc_kinematics(model, task.problem.q_start, kinematics_work, kinematics);
    std::vector<contact::Contact> contacts;
    contact::query(model, kinematics, {}, work, contacts);
    for (const auto& c : contacts) {
      const auto& pair = model.pairs()[static_cast<std::size_t>(c.pair)];
      EXPECT_GT(c.phi, -3e-4) << model.geometries()[static_cast<std::size_t>(pair.geometry_a)].name << " and "
                              << model.geometries()[static_cast<std::size_t>(pair.geometry_b)].name;
    }
  }
}

TEST(Tasks, BuiltIn_ObjectsRestWhereTheyStart) {
  for (const auto& name : list_tasks(default_data_dirs())) {
    if (is_variant(name)) continue;
    SCOPED_TRACE(name);
    const Task task = load_task(name);
    const world::Model& model = *task.model;
    dynamics::StepWorkspace work(task.model);
    dynamics::StepResult result;
    dynamics::StepOptions options;
    options.h = task.options.step_options(*task.model).h;
    options.regularisation = task.options.step_options(*task.model).regularisation;
    const world::ObjectSpace space(model);
    Eigen::VectorXd q = task.problem.q_start;
    const Eigen::VectorXd u = q.tail(model.n_a());
    for (int k = 0; k < 100; ++k) {
      ASSERT_EQ(dynamics::step(model, {q, u}, options, work, result), core::Status::Solved);
      q = result.q_next;
    }
    EXPECT_TRUE(world::objects_agree(model, space, task.problem.q_start, q, 2e-3, 0.02));
  }
}

TEST(Tasks, Table32Variants_AreTheThesis) {
  struct Published {
    const char* name;
    double length, gravity;
    int n_vu, n_a;
    std::size_t pairs;
  };
  // reference counts: objects, joints and pairs of the published systems (a box of 1 m has 8 corner balls there and one box here; one of 163 pairs of the
  // ball never meets)
  for (const auto& [name, length, gravity, n_vu, n_a, pairs] :
       {Published{"planar_pushing", 0.3, 0, 3, 2, 1}, Published{"planar_hand", 0.3, 0, 3, 4, 51},
        Published{"allegro_ball", 0.3, 0, 6, 16, 162}, Published{"allegro_pen", 0.2, 0, 6, 19, 258},
        Published{"allegro_plate", 0.2, 10, 6, 19, 641}, Published{"allegro_door", 0.2, 0, 2, 19, 263}}) {
    SCOPED_TRACE(name);
    const Task task = load_task(std::string(name) + "_table_3_2");
    ASSERT_TRUE(task.options.thesis.has_value());
    EXPECT_EQ(task.options.thesis->length, length);
    EXPECT_EQ(task.model->scene().gravity.norm(), gravity);
    EXPECT_EQ(task.model->n_vu(), n_vu);
    EXPECT_EQ(task.model->n_a(), n_a);
    EXPECT_EQ(task.model->pairs().size(), pairs);
  }
}

TEST(Tasks, SceneText_KnowsTheSceneAndNothingElse) {
  EXPECT_EQ(load_task("planar_pushing").scene_text, load_task("planar_pushing_table_3_2").scene_text);
  EXPECT_NE(load_task("allegro_ball").scene_text, load_task("allegro_ball_table_3_2").scene_text);  // gravity
}

TEST(Tasks, OptionsAsJson_ReadBackTheSame) {
  for (const auto& name : list_tasks(default_data_dirs())) {
    const Task task = load_task(name);
    const std::string text = planner_options_json(task.options, *task.model);
    const auto again = read_planner_options(world::YamlNode::parse(text, "options"), *task.model);
    EXPECT_EQ(planner_options_json(again, *task.model), text);
  }
}

TEST(Tasks, SettingsOfTheThesis_AreAddedToThoseOfABase) {
  const Task task = load_task("planar_pushing_table_3_2");
  const auto read = [&](const char* text) {
    return read_planner_options(world::YamlNode::parse(text, "options"), *task.model, task.options);
  };
  ASSERT_TRUE(read("{}").thesis);
  EXPECT_EQ(read("{thesis: {h: 0.05}}").thesis->h, 0.05);
  EXPECT_EQ(read("{thesis: {h: 0.05}}").thesis->gamma, task.options.thesis->gamma) << "kept";
  EXPECT_TRUE(std::holds_alternative<dynamics::FixedEpsilon>(read("{thesis: {h: 0.05}}").thesis->regularisation));
  const Task plain = load_task("planar_pushing");
  EXPECT_FALSE(plain.options.thesis);
}

/// Files of 0.2 are read: options that are none any more are ignored, and named.
TEST(Tasks, OptionsThatWent_AreNotedAndIgnored) {
  const Task task = load_task("planar_pushing");
  std::vector<std::string> notes;
  const auto node = world::YamlNode::parse("{goal_bias: 0.2, gamma: 0.5, advanced: {substep: {slide: 0.002}, trees: 3}}", "options");
  const auto options = read_planner_options(node, *task.model, {}, &notes);
  EXPECT_EQ(options.goal_bias, 0.2);
  ASSERT_EQ(notes.size(), 3U);
  EXPECT_NE(notes[0].find("gamma: no option any more"), std::string::npos) << notes[0];
  EXPECT_NE((notes[1] + notes[2]).find("advanced.substep"), std::string::npos) << notes[1];
}

/// What users get is what PlannerOptions says.
TEST(Tasks, OptionsOfATaskWithoutAny_AreTheDefaultsOfTheLibrary) {
  const Task task = load_task("allegro_cube");
  EXPECT_EQ(planner_options_json(task.options, *task.model, WhichOptions::All),
            planner_options_json(planning::PlannerOptions{}, *task.model, WhichOptions::All));
}

TEST(Tasks, GoalOfAnObjectOnAnother_IsTheWholeChain) {
  Task task = load_task("allegro_door");
  const int handle = task.model->object_index("handle");
  EXPECT_EQ(task.problem.goal.object, handle);
  EXPECT_EQ(task.problem.q_goal.size(), 2);
  EXPECT_LT((task.problem.goal.X_WG.p - Eigen::Vector3d(0.391, -0.318, 0)).norm(), 1e-3);  // the published place of the knob
  set_goal(task, std::vector<double>{-0.5, 0.25});
  EXPECT_EQ(task.problem.q_goal, Eigen::Vector2d(-0.5, 0.25));
  expect_refused([&] { set_goal(task, std::vector<double>{0.1}); }, {"goal", "1 numbers", "2 (the coordinates of 'door' and 'handle')"});
}

TEST(Tasks, SetGoal_TakesSixNumbersOrCoordinates) {
  Task ball = load_task("allegro_ball");
  set_goal(ball, std::vector<double>{-0.08, 0, 0.07, 0, 0, 1.5});
  EXPECT_NEAR(ball.problem.goal.X_WG.R(1, 0), std::sin(1.5), 1e-15);
  EXPECT_TRUE(ball.goal_from_command_line);
  Task box = load_task("planar_pushing");
  set_goal(box, std::vector<double>{0.1, -0.2, 0});
  EXPECT_NEAR(box.problem.goal.X_WG.p.z(), -0.2, 1e-15);
  expect_refused([&] { set_goal(ball, std::vector<double>{1, 2, 3}); }, {"goal", "3 numbers", "6"});
  expect_refused([&] { set_goal(box, std::vector<double>{1, 2, std::nan("")}); }, {"goal", "nan"});
}

TEST(Tasks, SetGoal_WithAnyValues_MakesARegion) {
  Task box = load_task("planar_pushing");
  set_goal(box, std::vector<std::optional<double>>{std::nullopt, -0.2, std::nullopt});
  ASSERT_TRUE(box.problem.goal.region);
  EXPECT_EQ(box.problem.goal.region->lower[1], -0.2);
  EXPECT_EQ(box.problem.goal.region->upper[1], -0.2);
  EXPECT_TRUE(std::isinf(box.problem.goal.region->upper[0]) && std::isinf(box.problem.goal.region->lower[2]));
  set_goal(box, std::vector<double>{0.1, -0.2, 0});
  EXPECT_FALSE(box.problem.goal.region) << "a pose again";
}

/// What has physics is in the text, and so in the hash; nothing is where nothing is said.
TEST(TaskInMemory, FrictionOfJointsAndLargestForces_AreInTheSceneText) {
  const auto text = [](const std::string& keys) {
    return parse_task(
               "name: t\nscene:\n  objects:\n    - {name: flap, joint: hinge, axis: [1, 0, 0], mass: 1, shapes: [{sphere: {radius: 0.1}}]" +
                   keys +
                   "}\nstart: {objects: {flap: {coordinates: [0]}}}\ngoal: {objects: {flap: {coordinates: [1]}}}\ntolerance: {position: "
                   "0.01, angle: 0.1}\n",
               kTasks)
        .scene_text;
  };
  const std::string plain = text("");
  EXPECT_EQ(plain.find("max_force"), std::string::npos);
  EXPECT_EQ(plain, text(", joint_friction: 0, joint_damping: 0"));
  EXPECT_EQ(plain, text(", torsional_friction: 0"));
  for (const char* keys :
       {", joint_friction: 0.1", ", joint_damping: 0.1", ", max_force: 3", ", torsional_friction: 0.1", ", rolling_friction: 0.1"})
    EXPECT_NE(text(keys), plain) << keys;
  EXPECT_NE(text(", joint_friction: 0.1").find("friction: 0.1, damping: 0}"), std::string::npos);
  EXPECT_NE(text(", max_force: 3").find(", max_force: 3}"), std::string::npos);
}

TEST(TaskInMemory, TextOfAFile_GivesTheTaskOfTheFile) {
  const Task in_file = load_task("planar_pushing");
  std::ifstream in(in_file.file);
  const std::string text(std::istreambuf_iterator<char>(in), {});
  const Task in_memory = parse_task(text, kTasks);
  EXPECT_EQ(in_memory.scene_text, in_file.scene_text);
  EXPECT_EQ(in_memory.name, in_file.name);
  EXPECT_EQ(in_memory.text, text);
  EXPECT_EQ(in_memory.problem.q_start, in_file.problem.q_start);
  EXPECT_EQ(in_memory.problem.q_goal, in_file.problem.q_goal);
}

TEST(TaskInMemory, Base_IsFoundInTheFolder) {
  const Task task = parse_task(R"({"base": "planar_pushing.yaml", "tolerance": {"position": 0.25}})", kTasks);
  EXPECT_EQ(task.problem.goal.tol_position, 0.25);
  EXPECT_EQ(task.scene_sha256, load_task("planar_pushing").scene_sha256);
}

TEST(TaskInMemory, Mistake_IsNamedByItsPathAlone) {
  const auto message = [](const std::string& text) {
    try {
      (void)parse_task(text, kTasks);
    } catch (const core::InvalidInput& e) {
      return std::string(e.what());
    }
    return std::string("accepted");
  };
  EXPECT_EQ(message(R"({"base": "planar_pushing.yaml", "tolerance": {"position": -1}})"),
            "tolerance.position: got -1, expected a number > 0");
  EXPECT_EQ(message(R"({"base": "planar_pushing.yaml", "tolerance": {"positon": 1}})"),
            "tolerance.positon: got an unknown key, expected one of position, angle; did you mean 'position'?");
  EXPECT_EQ(message("{}"),
            "tolerance: got nothing, expected this key\nscene: got nothing, expected this key\ngoal: got nothing, expected this key");
  EXPECT_EQ(message("[]"), "top level: got a list of 0, expected a map");
  EXPECT_EQ(message("{"), "file: got malformed YAML (end of map flow not found), expected valid YAML");
}

TEST_F(TaskFile, GoalRegion_IsReadAndItsNearestPoseIsTheGoal) {
  const Task box = load_task(write("planar_pushing", "goal: {objects: {box: {coordinates: [~, [-0.6, -0.4], 1.5]}}}\n").string());
  ASSERT_TRUE(box.problem.goal.region);
  const auto& region = *box.problem.goal.region;
  EXPECT_TRUE(std::isinf(region.lower[0]) && std::isinf(region.upper[0]));
  EXPECT_EQ(region.lower.tail<2>(), Eigen::Vector2d(-0.6, 1.5));
  EXPECT_EQ(region.upper.tail<2>(), Eigen::Vector2d(-0.4, 1.5));
  EXPECT_LT((box.problem.goal.X_WG.p - Eigen::Vector3d(0, 0, -0.4)).norm(), 1e-15);  // from (0, 0.5)
  const Task ball = load_task(write("allegro_ball", "goal: {objects: {ball: {position: ~, rpy: [~, ~, 1.57]}}}\n").string());
  ASSERT_TRUE(ball.problem.goal.region);
  EXPECT_EQ(ball.problem.goal.region->lower[5], 1.57);
  EXPECT_TRUE(ball.problem.goal.region->upper.head<5>().array().isInf().all());
  EXPECT_LT((ball.problem.goal.X_WG.p - ball.problem.q_start.head<3>()).norm(), 1e-15);
}

TEST(Tasks, GoalOfSeveralObjects_IsARegionOfAll) {
  Task task = load_task((stiction::test::source_dir() / "tests/tasks/data/two_boxes.yaml").string());
  const auto& goal = task.problem.goal;
  EXPECT_EQ(goal.object, 0) << "the smaller one";
  ASSERT_TRUE(goal.region);
  EXPECT_EQ(planning::goal_objects(*task.model, goal), (std::vector<int>{0, 1}));
  EXPECT_EQ(goal.region->lower.head(5), (Eigen::VectorXd(5) << -0.6, 1, 0, 1, 0.5).finished());
  EXPECT_TRUE(std::isinf(goal.region->upper[5]));
  EXPECT_EQ(task.problem.q_goal, (Eigen::VectorXd(6) << -0.6, 1, 0, 1, 0.5, 0).finished());
  set_goal(task, std::vector<double>{-0.6, 0.9, 0, 0.7, 0.5, 0.1});
  ASSERT_TRUE(goal.region);
  EXPECT_EQ(goal.region->upper, (Eigen::VectorXd(6) << -0.6, 0.9, 0, 0.7, 0.5, 0.1).finished());
  expect_refused([&] { set_goal(task, std::vector<double>{0, 0, 0}); }, {"goal", "3 numbers", "6 (the coordinates of 'left' and 'right'"});
}

TEST(Tasks, Bystanders_StandWhereTheStartHasThem) {
  Task task = load_task((stiction::test::source_dir() / "tests/tasks/data/careful_clutter.yaml").string());
  ASSERT_TRUE(task.problem.goal.bystanders);
  const planning::Bystanders& bystanders = *task.problem.goal.bystanders;
  EXPECT_EQ(bystanders.objects.size(), 11U) << "all but the box";
  EXPECT_EQ(bystanders.objects.front(), 1);
  EXPECT_EQ(bystanders.may_move, 0.05);
  EXPECT_TRUE(std::isinf(bystanders.may_tip));
  EXPECT_EQ(bystanders.q_u, task.problem.q_start.head(36));
  Eigen::VectorXd q = task.problem.q_start;
  q[4] += 0.1;
  set_start(task, q);
  EXPECT_EQ(bystanders.q_u, q.head(36));
}

TEST_F(TaskFile, OverAnother_Loads) {
  const Task task = load_task(write("planar_pushing", "tolerance: {position: 0.5}\n").string());
  EXPECT_EQ(task.problem.goal.tol_position, 0.5);
  EXPECT_FALSE(task.builtin);
}

struct Mistake {
  const char* base;
  const char* text;
  std::vector<std::string> message;
};

/// Names the tests by what they ask of the message, not by the addresses of its pieces.
void PrintTo(const Mistake& mistake, std::ostream* out) { *out << fmt::format("{}", fmt::join(mistake.message, " ")); }

class Mistakes : public TaskFile, public testing::WithParamInterface<Mistake> {};

TEST_P(Mistakes, AreNamed) {
  const auto& [base, text, message] = GetParam();
  const fs::path file = write(base, text);
  expect_refused([&] { (void)load_task(file.string()); }, message);
}

INSTANTIATE_TEST_SUITE_P(
    TaskFiles, Mistakes,
    testing::Values(
        Mistake{"planar_pushing", "goals: {}\n", {"mine.yaml:2", "goals", "unknown key"}},
        Mistake{"planar_pushing", "planner: {goal_bais: 0.3}\n", {"mine.yaml:2", "planner.goal_bais", "did you mean 'goal_bias'"}},
        Mistake{"planar_pushing", "planner: {goal_bias: 1.5}\n", {"mine.yaml:2", "planner.goal_bias", "1.5", "[0, 1]"}},
        Mistake{"planar_pushing", "planner: {max_iterations: 0}\n", {"planner.max_iterations", "0", "≥ 1"}},
        Mistake{"planar_pushing", "planner: {max_iterations: many}\n", {"planner.max_iterations", "'many'", "an integer"}},
        Mistake{
            "planar_pushing", "planner: {advanced: {single_step: true}}\n", {"mine.yaml:2", "planner.advanced.single_step", "`thesis`"}},
        Mistake{"planar_pushing", "planner: {scheme: exact}\n", {"mine.yaml:2", "planner.scheme", "`thesis`"}},
        Mistake{"planar_pushing", "planner: {thesis: {h: -0.1}}\n", {"planner.thesis.h", "-0.1", "> 0"}},
        Mistake{"planar_pushing", "planner: {thesis: {gamma: .nan}}\n", {"planner.thesis.gamma", "finite"}},
        Mistake{"planar_pushing",
                "planner: {thesis: {regularisation: {ratio: 0.3, epsilon: 0.3}}}\n",
                {"planner.thesis.regularisation", "either 'ratio' or 'epsilon'"}},
        Mistake{"planar_pushing",
                "planner: {sample_box: {bax: {lower: [0, 0, 0], upper: [1, 1, 1]}}}\n",
                {"planner.sample_box.bax", "did you mean 'box'"}},
        Mistake{"planar_pushing",
                "planner: {sample_box: {box: {lower: [0, 9, 0], upper: [1, 1, 1]}}}\n",
                {"planner.sample_box.box", "lower ≤ upper"}},
        Mistake{"planar_pushing",
                "start: {joints: [0, 0, 0]}\n",
                {"start.joints: got a list of 3, expected a list of 2 numbers (hand/y, hand/z)"}},
        Mistake{"planar_pushing", "start: {joints: {x: 0}}\n", {"mine.yaml:2", "start.joints.x", "y"}},
        Mistake{"planar_pushing",
                "start: {objects: {ball: {coordinates: [0, 0, 0]}}}\n",
                {"start.objects.ball", "unknown object 'ball'", "box"}},
        Mistake{"planar_pushing", "start: {objects: {box: {coordinates: [0, .inf, 0]}}}\n", {"start.objects.box.coordinates[1]", "finite"}},
        Mistake{"planar_pushing", "goal: {objects: {box: {position: [0, 0, 0]}}}\n", {"goal.objects.box", "coordinates"}},
        Mistake{"box_grazing",
                "scene:\n  objects:\n    - {name: box, joint: slider, axis: [0, 1, 0], mass: 1, limits: [-0.5, 0.5], shapes: [{sphere: "
                "{radius: "
                "0.1}}]}\n",
                {"goal.objects.box", "0.66", "a goal inside the limits [-0.5, 0.5]"}},
        Mistake{"box_grazing",
                "goal: {objects: {box: {coordinates: [[0.6, 0.9]]}}}\nscene: {objects: [{name: box, joint: slider, axis: [0, 1, 0], mass: "
                "1, limits: "
                "[-0.5, 0.5], shapes: [{sphere: {radius: 0.1}}]}]}\n",
                {"mine.yaml:2", "goal.objects.box", "0.6", "a goal inside the limits [-0.5, 0.5]"}},
        Mistake{"planar_pushing",
                "goal: {objects: {box: {coordinates: [0, [1, -1], 0]}}}\n",
                {"goal.objects.box.coordinates[1]", "lower ≤ upper"}},
        Mistake{"planar_pushing", "planner: {thesis: {gama: 1}}\n", {"planner.thesis.gama", "did you mean 'gamma'"}},
        Mistake{"planar_pushing", "planner: {thesis: {scheme: smooth}}\n", {"planner.thesis.scheme", "smooth", "randomized-zeroth"}},
        Mistake{"planar_pushing", "planner: {thesis: {metric: euclid}}\n", {"planner.thesis.metric", "euclid", "global"}},
        Mistake{"planar_pushing", "planner: {anytime: true, thesis: {}}\n", {"planner.anytime", "thesis"}},
        Mistake{"allegro_door",
                "goal: {objects: {handle: {coordinates: [0, 1]}}}\n",
                {"mine.yaml:2", "goal.objects.handle.coordinates", "1 number"}},
        Mistake{
            "planar_hand_fixed_y",
            "scene: {objects: [{name: ball, parent: cart, joint: hinge, axis: [1, 0, 0], mass: 1, shapes: [{sphere: {radius: 0.2}}]}]}\n",
            {"mine.yaml:2", "scene.objects[0].parent", "unknown object listed before 'cart'"}},
        Mistake{"planar_pushing",
                "bystanders: {objects: [box], may_move: 0.1}\n",
                {"mine.yaml:2", "bystanders.objects[0]", "'box', which the goal moves"}},
        Mistake{"planar_pushing", "bystanders: {may_move: 0}\n", {"mine.yaml:2", "bystanders.may_move", "> 0"}},
        Mistake{"planar_pushing", "bystanders: {may_tip: 0.1}\n", {"bystanders.may_tip", "a scene without gravity"}},
        Mistake{"planar_pushing", "bystanders: {}\n", {"bystanders", "neither 'may_move' nor 'may_tip'"}},
        Mistake{"planar_pushing", "tolerance: {angle: 0}\n", {"tolerance.angle", "> 0"}},
        Mistake{"allegro_ball", "goal: {objects: {ball: {coordinates: [0, 0, 0]}}}\n", {"goal.objects.ball", "unknown key"}},
        Mistake{"allegro_ball", "goal: {objects: {cube: {position: [0, 0, 0]}}}\n", {"goal.objects.cube", "unknown object 'cube'", "ball"}},
        Mistake{"allegro_ball",
                "start: {objects: {ball: {quaternion_wxyz: [1, 1, 0, 0]}}}\n",
                {"start.objects.ball.quaternion_wxyz", "norm", "unit quaternion"}},
        Mistake{"allegro_ball", "start: {joints: {hand/joint_13: 3}}\n", {"start.joints", "joint_13", "inside the joint limits"}},
        Mistake{"allegro_ball", "start: {joints: {hand/joint_99: 0}}\n", {"joint_99"}},
        Mistake{"allegro_ball",
                "scene: {objects: [{name: ball, joint: free, mass: -1, shapes: [{sphere: {radius: 0.06}}]}]}\n",
                {"mass", "-1"}}));

TEST_F(TaskFile, TruthValues_AreThoseOfYaml) {
  for (const char* word : {"true", "True", "TRUE"}) EXPECT_TRUE(world::YamlNode::parse(word, "file").boolean()) << word;
  for (const char* word : {"false", "False", "FALSE"}) EXPECT_FALSE(world::YamlNode::parse(word, "file").boolean()) << word;
  for (const char* word : {"yes", "'true'", "tRue", "1"})
    expect_refused([&] { (void)world::YamlNode::parse(word, "file").boolean(); }, {"expected true or false"});
}

TEST(Tasks, UnknownName_ListsWhatThereIs) {
  expect_refused([] { (void)load_task("alegro_ball"); }, {"task", "'alegro_ball'", "did you mean 'allegro_ball'"});
  expect_refused([] { (void)load_task("nowhere/task.yaml"); }, {"nowhere/task.yaml"});
}

TEST_F(TaskFile, NotYaml_NamesTheLine) {
  const fs::path file = dir_ / "broken.yaml";
  std::ofstream(file) << "scene: {}\nstart: [1, 2\n";
  expect_refused([&] { (void)load_task(file.string()); }, {"broken.yaml:", "malformed YAML"});
}

TEST(PackageDirs, AreThoseOfTheWorkspacesOfRos) {
  ::setenv("ROS_PACKAGE_PATH", "/ros1/src:/other", 1);
  ::setenv("AMENT_PREFIX_PATH", "/ws/install/arm::/opt/ros/jazzy", 1);
  const std::vector<fs::path> dirs = default_package_dirs();
  ::unsetenv("ROS_PACKAGE_PATH");
  ::unsetenv("AMENT_PREFIX_PATH");
  ASSERT_GE(dirs.size(), 4u);
  EXPECT_EQ((std::vector<fs::path>(dirs.begin(), dirs.begin() + 4)),
            (std::vector<fs::path>{"/ros1/src", "/other", "/ws/install/arm/share", "/opt/ros/jazzy/share"}));
}

}  // namespace
}  // namespace stiction::tasks
