#include "stiction/tasks/plan_file.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>

#include "stiction/core/invalid_input.hpp"
#include "stiction/tasks/check.hpp"
#include "support/temporary_folder.hpp"
#include "tasks/scripted_plan.hpp"

namespace stiction::tasks {
namespace {

namespace fs = std::filesystem;
using json = nlohmann::ordered_json;

class PlanFiles : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    box_ = new ScriptedPlan(push_box());
    ball_ = new ScriptedPlan(squeeze_ball());
  }
  static void TearDownTestSuite() {
    delete box_;
    delete ball_;
  }

  static void expect_refused(const std::string& text, const std::vector<std::string>& parts) {
    try {
      (void)parse_plan(text, "plan.json");
      ADD_FAILURE() << "accepted, expected a message with '" << parts.front() << "'";
    } catch (const core::InvalidInput& e) {
      EXPECT_TRUE(std::string(e.what()).starts_with("plan.json: ")) << e.what();
      for (const auto& part : parts)
        EXPECT_NE(std::string(e.what()).find(part), std::string::npos) << "no '" << part << "' in: " << e.what();
    }
  }

  static inline ScriptedPlan* box_ = nullptr;
  static inline ScriptedPlan* ball_ = nullptr;
  const stiction::test::TemporaryFolder temporary_;
  const fs::path dir_ = temporary_.path() / "plan";  // made where a plan is written
};

TEST_F(PlanFiles, WriteAndRead_GivesTheSameBits) {
  for (const ScriptedPlan* plan : {box_, ball_}) {
    const fs::path file = dir_ / "plan.json";
    write_plan(plan->file, file);
    const PlanFile again = read_plan(dir_);
    EXPECT_EQ(to_text(again), to_text(plan->file));
    ASSERT_EQ(again.segments.size(), plan->result.plan.segments.size());
    for (std::size_t s = 0; s < again.segments.size(); ++s) {
      const auto& original = plan->result.plan.segments[s].knots;
      ASSERT_EQ(again.segments[s].knots.size(), original.size());
      for (std::size_t k = 0; k < original.size(); ++k) {
        EXPECT_EQ(again.segments[s].knots[k].u, original[k].u);  // bit by bit
        EXPECT_EQ(again.segments[s].knots[k].q, original[k].q);
        EXPECT_EQ(again.segments[s].knots[k].contacts.size(), original[k].contacts.size());
      }
    }
    EXPECT_EQ(again.q_start, plan->result.plan.q_start);
    EXPECT_NO_THROW(require_same_scene(again, plan->task, file));
  }
}

TEST_F(PlanFiles, FrictionLaw_IsKeptAndAnitescusWhereThereIsNone) {
  PlanFile plan = ball_->file;
  plan.step.friction_law = dynamics::FrictionLaw::Coulomb;
  json j = json::parse(to_text(plan));
  EXPECT_EQ(parse_plan(j.dump(), "plan.json").step.friction_law, dynamics::FrictionLaw::Coulomb);
  j["step"].erase("friction_law");
  EXPECT_EQ(parse_plan(j.dump(), "plan.json").step.friction_law, dynamics::FrictionLaw::Anitescu);
}

/// The two rows of a contact that resists turning are one contact of the file, with the moment of both.
TEST_F(PlanFiles, ContactThatResistsTurning_IsOneContactWithAMoment) {
  Task task = load_task("allegro_ball");
  world::Scene scene = task.model->scene();
  scene.objects[0].geometries[0].rule = {.dimension = 4, .torsional = 0.01};
  task.model = world::Model::make(scene);
  const Eigen::VectorXd u = task.problem.q_start.tail(16);
  Eigen::VectorXd closed = u;
  for (const int j : {1, 2, 5, 6, 9, 10, 14, 15}) closed[j] += 0.1;
  const ScriptedPlan plan = run_script(std::move(task), {closed, u});
  CheckReport report;
  ASSERT_EQ(check_plan(plan.task, plan.file, {}, {}, report), core::Status::Solved);
  EXPECT_TRUE(report.pass);
  write_plan(plan.file, dir_ / "plan.json");
  const PlanFile again = read_plan(dir_);
  double largest = 0;
  std::size_t rows = 0, contacts = 0;
  for (std::size_t s = 0; s < again.segments.size(); ++s) {
    for (std::size_t k = 0; k < again.segments[s].knots.size(); ++k) {
      rows += plan.result.plan.segments[s].knots[k].contacts.size();
      contacts += again.segments[s].knots[k].contacts.size();
      for (std::size_t c = 0; c < again.segments[s].knots[k].contacts.size(); ++c) {
        const StoredContact &read = again.segments[s].knots[k].contacts[c], &written = plan.file.segments[s].knots[k].contacts[c];
        EXPECT_NEAR(read.moment, written.moment, 1e-6);
        EXPECT_LE(std::abs(read.moment), 0.01 * read.normal_W.dot(read.force_W) + 1e-5);
        largest = std::max(largest, std::abs(read.moment));
      }
    }
  }
  EXPECT_GT(largest, 1e-3);
  EXPECT_GT(rows, contacts);
}

/// A moment that the file rounds to 0 is read as none, and the digest is that of what is read.
TEST_F(PlanFiles, MomentBelowTheDigitsOfTheFile_IsNoEdit) {
  PlanFile plan = ball_->file;
  int moments = 0;
  for (StoredSegment& segment : plan.segments) {
    for (StoredKnot& knot : segment.knots) {
      for (StoredContact& contact : knot.contacts) contact.moment = 1e-9 * ++moments;
    }
  }
  ASSERT_GT(moments, 0);
  plan.sha256 = content_sha256(plan);
  const PlanFile read = parse_plan(to_text(plan), "plan.json");
  EXPECT_EQ(read.sha256, plan.sha256);
  EXPECT_EQ(content_sha256(read), read.sha256);
}

TEST_F(PlanFiles, Write_LeavesNothingButTheFile) {
  write_plan(box_->file, dir_ / "plan.json");
  int files = 0;
  for ([[maybe_unused]] const auto& entry : fs::directory_iterator(dir_)) ++files;
  EXPECT_EQ(files, 1);
}

TEST_F(PlanFiles, UnwritableFolder_IsNamed) {
  fs::create_directories(dir_);
  std::ofstream(dir_ / "a_file") << "x";
  for (const auto& call : {std::function<void()>([&] { require_writable(dir_ / "a_file" / "sub"); }),
                           std::function<void()>([&] { write_plan(box_->file, dir_ / "a_file" / "sub" / "plan.json"); })}) {
    try {
      call();
      ADD_FAILURE() << "accepted";
    } catch (const core::InvalidInput& e) {
      EXPECT_NE(std::string(e.what()).find("a_file"), std::string::npos) << e.what();
    }
  }
}

TEST_F(PlanFiles, Truncated_IsRefused) {
  const std::string text = to_text(box_->file);
  for (const double share : {0.0, 0.1, 0.5, 0.99}) {
    expect_refused(text.substr(0, static_cast<std::size_t>(share * static_cast<double>(text.size()))), {"only part of it"});
  }
}

struct Edit {
  const char* what;
  std::function<void(json&)> apply;
  std::vector<std::string> message;
};

TEST_F(PlanFiles, Edits_AreNamed) {
  const json original = json::parse(to_text(ball_->file));
  const std::vector<Edit> edits = {
      {"format", [](json& j) { j["format"] = "other"; }, {"format", "\"other\"", "stiction-plan"}},
      {"version", [](json& j) { j["format_version"] = 2; }, {"format_version", "2", "1"}},
      {"missing key", [](json& j) { j.erase("goal"); }, {"goal"}},
      {"unknown key", [](json& j) { j["extra"] = 1; }, {"unknown key 'extra'"}},
      {"missing knot key", [](json& j) { j["segments"][0]["knots"][3].erase("u"); }, {"segments[0].knots[3]", "'u'"}},
      {"wrong size", [](json& j) { j["segments"][1]["knots"][2]["u"].push_back(0); }, {"segments[1].knots[2].u", "17 numbers", "16"}},
      {"wrong type", [](json& j) { j["segments"][0]["knots"][0]["joints"][4] = "x"; }, {"segments[0].knots[0].joints[4]", "a number"}},
      {"null", [](json& j) { j["error"]["angle"] = nullptr; }, {"error.angle", "null", "a number"}},
      {"missing body pose", [](json& j) { j["segments"][0]["knots"][0]["bodies"].erase(0); }, {"segments[0].knots[0].bodies"}},
      {"geometry index",
       [](json& j) { j["segments"][0]["knots"][3]["contacts"][0]["a"] = 1000; },
       {"segments[0].knots[3].contacts[0].a", "1000"}},
      {"scene text", [](json& j) { j["scene_text"] = "gravity: [0, 0, 0]"; }, {"scene_sha256", "SHA-256"}},
      {"tolerance", [](json& j) { j["goal"]["tolerance"]["angle"] = -1; }, {"goal.tolerance.angle", "> 0"}},
      {"goal quaternion", [](json& j) { j["goal"]["quaternion_wxyz"][0] = 5; }, {"goal.quaternion_wxyz", "unit quaternion"}},
      {"goal object", [](json& j) { j["goal"]["object"] = "cube"; }, {"goal.object", "cube"}},
      {"shape", [](json& j) { j["geometries"][0]["shape"]["type"] = "cone"; }, {"geometries[0].shape.type", "cone"}},
      {"segment kind", [](json& j) { j["segments"][0]["kind"] = "jump"; }, {"segments[0].kind", "settle, contact, regrasp"}},
      {"h", [](json& j) { j["step"]["h"] = 0; }, {"step.h", "> 0"}},
      {"law", [](json& j) { j["step"]["friction_law"] = "newton"; }, {"step.friction_law", "newton", "anitescu, coulomb"}},
      {"seed", [](json& j) { j["seed"] = -3; }, {"seed", "-3"}},
      {"status", [](json& j) { j["status"] = "Fine"; }, {"status", "Fine"}},
      {"not an object", [](json& j) { j = json::array(); }, {"an object"}},
  };
  for (const auto& edit : edits) {
    SCOPED_TRACE(edit.what);
    json j = original;
    edit.apply(j);
    expect_refused(j.dump(), edit.message);
  }
  json huge = original;
  std::string text = huge.dump();
  const auto at = text.find("\"wall_s\":") + 9;
  expect_refused(text.substr(0, at) + "1e999" + text.substr(text.find(',', at)), {"plan.json"});
}

TEST_F(PlanFiles, OtherScene_IsRefused) {
  const auto refused = [](const PlanFile& plan, const Task& task, const std::string& part) {
    try {
      require_same_scene(plan, task, "plan.json");
      ADD_FAILURE() << "accepted, expected a message with '" << part << "'";
    } catch (const core::InvalidInput& e) {
      EXPECT_NE(std::string(e.what()).find(part), std::string::npos) << e.what();
    }
  };
  refused(box_->file, ball_->task, "scene_sha256");
  PlanFile edited = ball_->file;
  std::swap(edited.joints[0], edited.joints[1]);
  refused(edited, ball_->task, "joints[0]");
  edited = ball_->file;
  edited.objects[0].name = "cube";
  refused(edited, ball_->task, "objects[0]");
  edited = ball_->file;
  edited.options = R"({"goal_bias": 7})";
  refused(edited, ball_->task, "options.goal_bias");
}

TEST_F(PlanFiles, TaskIsFoundAgain) {
  write_plan(box_->file, dir_ / "plan.json");
  const Task task = load_task_of_plan(read_plan(dir_), dir_, default_data_dirs());
  EXPECT_EQ(task.name, "planar_pushing");
  PlanFile elsewhere = box_->file;
  elsewhere.task_builtin = false;
  elsewhere.task_file = "../gone.yaml";
  EXPECT_THROW((void)load_task_of_plan(elsewhere, dir_, default_data_dirs()), core::InvalidInput);
  elsewhere.task_builtin = true;
  EXPECT_THROW((void)load_task_of_plan(elsewhere, dir_, default_data_dirs()), core::InvalidInput);
}

TEST_F(PlanFiles, TaskMadeInMemory_StandsInTheFile) {
  const std::string text = R"({"base": "planar_pushing.yaml", "name": "mine"})";
  const Task task = parse_task(text, box_->task.file.parent_path());
  write_plan(make_plan_file(task, task.options, box_->result, dir_ / "plan.json"), dir_ / "plan.json");
  const PlanFile file = read_plan(dir_);
  EXPECT_EQ(file.task_text, text);
  EXPECT_EQ(to_text(parse_plan(to_text(file), dir_ / "plan.json")), to_text(file));
  const Task again = load_task_of_plan(file, dir_, {});
  EXPECT_EQ(again.name, "mine");
  EXPECT_EQ(again.scene_text, box_->task.scene_text);
  EXPECT_EQ(again.text, text);
}

}  // namespace
}  // namespace stiction::tasks
