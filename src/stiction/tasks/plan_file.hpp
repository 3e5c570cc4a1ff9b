#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "stiction/planning/planner.hpp"
#include "stiction/tasks/task.hpp"

namespace stiction::tasks {

inline constexpr std::string_view kPlanFormat = "stiction-plan";
inline constexpr int kPlanFormatVersion = 1;

/// Position and quaternion_wxyz.
using PoseNumbers = std::array<double, 7>;

struct StoredContact {
  int a = -1, b = -1;                          ///< indices of geometries; the force acts on a, its opposite on b
  Eigen::Vector3d point_W, normal_W, force_W;  ///< [m], from b to a, [N]
  double friction = 0;
  double gap = 0;     ///< signed distance before the sub-step [m]
  double moment = 0;  ///< on a, about the normal [N·m]
};

struct StoredKnot {
  Eigen::VectorXd u;                    ///< (n_a), exact
  Eigen::VectorXd q;                    ///< (n_q), exact
  std::vector<PoseNumbers> bodies;      ///< poses of the moving bodies, display
  std::vector<StoredContact> contacts;  ///< active contacts, display
};

struct StoredSegment {
  planning::SegmentKind kind = planning::SegmentKind::Contact;
  std::vector<StoredKnot> knots;
};

struct StoredTreeNode {
  int parent = -1;  ///< index in PlanFile::tree, before its own; −1 for the root
  planning::SegmentKind edge = planning::SegmentKind::Contact;
  PoseNumbers object{};  ///< pose of the goal's object, display
};

struct StoredObject {
  std::string name;
  world::ObjectJoint joint = world::ObjectJoint::Free;
  int n_q = 7;  ///< numbers in q: 7 for a free object, otherwise the number of its coordinates
};

struct StoredBody {
  std::string name;
  world::BodyKind kind = world::BodyKind::Fixed;
  std::optional<PoseNumbers> fixed_pose;  ///< pose of a fixed body
};

struct StoredGeometry {
  std::string name;
  int body = -1;  ///< index into PlanFile::bodies
  world::Shape shape;
  PoseNumbers X_BG{};
  double friction = 0;
};

/// A plan file in memory, with the fields described in docs/plan_file.md.
struct PlanFile {
  std::string code_version;
  std::string task_name, task_file;  ///< task_file: name in the data folder, or path relative to the folder of the plan file
  std::string task_text;             ///< text of a task made in memory; task_file is then the folder of its relative paths
  bool task_builtin = false;
  std::string scene_sha256, scene_text;
  core::Status status = core::Status::NumericalFailure;
  std::uint64_t seed = 0;
  std::string options;  ///< JSON object, see planner_options_json
  long iterations = 0, nodes = 0, steps = 0, linearisations = 0, failed_steps = 0, distrusted = 0;
  planning::RegraspCounts regrasps;
  double start_penetration = 0;  ///< [m]
  bool start_projected = false;
  double wall_s = 0;  ///< planning time
  int threads = 0;
  std::string created;  ///< ISO 8601, UTC
  dynamics::StepOptions step;
  std::optional<dynamics::SubstepLimits> substep;  ///< nullopt: single steps
  std::vector<std::string> joints;
  std::vector<StoredObject> objects;
  std::vector<StoredBody> bodies;
  std::vector<StoredGeometry> geometries;
  Eigen::VectorXd q_start, u_start;
  std::string goal_object;
  PoseNumbers goal_pose{};
  double tol_position = 0, tol_angle = 0;
  std::optional<planning::GoalRegion> region;      ///< of the goal (n_vu)
  std::optional<planning::Bystanders> bystanders;  ///< bystanders of the goal; their positions are those in q_start
  bool start_from_command_line = false, goal_from_command_line = false, options_from_command_line = false;
  planning::GoalError error;
  std::vector<StoredSegment> segments;
  std::vector<StoredTreeNode> tree;  ///< display; a large tree is thinned evenly
  std::string sha256;                ///< content_sha256 at the time of writing; empty in files of earlier versions
};

/// Makes the plan file of a finished plan. @param file  future path of the file, used only to write the task's path relative to it
PlanFile make_plan_file(const Task& task, const planning::PlannerOptions& options, const planning::PlanResult& result,
                        const std::filesystem::path& file);

/// Plan stored in the file, with exact commands and states and without forces. The file must fit the model, see require_same_scene.
planning::Plan to_plan(const world::Model& model, const PlanFile& file);

/// Search result stored in the file, with its plan: the input of make_plan_file() without tree and records.
planning::PlanResult to_result(const world::Model& model, const PlanFile& file);

/// Planner options of the plan. @param file  path of the plan file, for messages
planning::PlannerOptions options_of_plan(const world::Model& model, const PlanFile& plan, const std::filesystem::path& file);

/// Path of the task that a plan file names (PlanFile::task_file). @param file  path of the plan file
std::string spell_task_file(const Task& task, const std::filesystem::path& file);

/// The text of the file; equal plans give equal texts. @throws core::InvalidInput when a number is not finite
std::string to_text(const PlanFile& plan);

/// SHA-256 of the whole text except the digest itself. It reveals accidental edits but gives no protection: an editor can compute it again.
std::string content_sha256(const PlanFile& plan);

/// The entries of `bodies` and `geometries`; equal ones give equal texts.
std::string to_text(const StoredBody& body);
std::string to_text(const StoredGeometry& geometry);

/// Writes under a temporary name in the same folder (made if missing) and renames. @throws core::InvalidInput: cannot be written
void write_plan(const PlanFile& plan, const std::filesystem::path& file);

/// Writes a text in the same way as a plan file.
void write_text(const std::string& text, const std::filesystem::path& file);

/// Makes the folder of a plan file and proves that it can be written to. @throws core::InvalidInput naming the folder
void require_writable(const std::filesystem::path& dir);

/// Reads and checks everything that needs no task. to_text(read_plan(f)) is the text of f when this library wrote it.
/// @param file the file, or its folder
/// @throws core::InvalidInput "FILE: field: got …, expected …"
PlanFile read_plan(const std::filesystem::path& file);
PlanFile parse_plan(const std::string& text, const std::filesystem::path& file);

/// Loads the task of a plan file. @throws core::InvalidInput: not found; its scene, joints, objects or geometries differ from the file
Task load_task_of_plan(const PlanFile& plan, const std::filesystem::path& file, std::span<const std::filesystem::path> data_dirs);
void require_same_scene(const PlanFile& plan, const Task& task, const std::filesystem::path& file);

}  // namespace stiction::tasks
