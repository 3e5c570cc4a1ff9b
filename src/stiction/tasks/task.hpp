#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "stiction/planning/planner.hpp"
#include "stiction/tasks/optimize_options.hpp"
#include "stiction/world/model.hpp"
#include "stiction/world/yaml.hpp"

namespace stiction::tasks {

/// A task: scene, start, goal and planner options, as described by one YAML file (schema: tasks/schema/task.schema.json).
struct Task {
  std::string name;
  std::string description;
  std::filesystem::path file;                 ///< absolute path; for a task in memory the folder of its relative paths, ending in '/'
  std::string text;                           ///< text of a task in memory; empty: the text is in `file`
  world::YamlNode document;                   ///< the parsed file (merged with its `base`) or text
  bool builtin = false;                       ///< true if the task was found by its name in a data folder
  std::shared_ptr<const world::Model> model;  ///< model->scene() is the scene
  planning::PlanningProblem problem;
  planning::PlannerOptions options;
  std::optional<OptimizeSetup> optimize;   ///< the section of that name, if there is one
  std::string scene_text;                  ///< see make_scene_text
  std::string scene_sha256;                ///< SHA-256 of scene_text
  bool start_from_command_line = false;    ///< set_start replaced the start of the file
  bool goal_from_command_line = false;     ///< set_goal replaced the goal of the file
  bool options_from_command_line = false;  ///< options were given beside those of the file
  std::vector<std::string> notes;          ///< deviations from the file's text, one sentence each
};

/// Default folders of built-in tasks: share/stiction/tasks of the running installation, then the source folder.
std::vector<std::filesystem::path> default_data_dirs();

/// Folders in which a package:// path of a robot is searched if its own `package_dirs` do not have it: the folders of ROS_PACKAGE_PATH, the
/// share/ folders of AMENT_PREFIX_PATH (ROS 2), then packages installed beside this code or beside its dependencies at build time
/// (`pip install example-robot-data`).
std::vector<std::filesystem::path> default_package_dirs();

/// Names of the built-in tasks, in alphabetical order.
std::vector<std::string> list_tasks(std::span<const std::filesystem::path> data_dirs);

/// Loads a built-in task by its name, or a file, named with '.yaml', '.yml' or '/'. What comes through a pipe is a task in memory.
/// @throws core::InvalidInput "FILE:LINE: field: got …, expected …"
Task load_task(const std::string& name_or_file, std::span<const std::filesystem::path> data_dirs);
Task load_task(const std::string& name_or_file);

/// Reads a task from memory. @param text  content of a task file (YAML or JSON)  @param folder  base folder of its relative paths
/// @throws core::InvalidInput "field: got …, expected …"
Task parse_task(const std::string& text, const std::filesystem::path& folder);

/// Replaces the start. @param q  configuration (n_q)   @throws core::InvalidInput: wrong size, not finite, quaternions of length other than
/// 1
void set_start(Task& task, Eigen::Ref<const Eigen::VectorXd> q);

/// Moves fixed bodies: makes a new scene and, for a task from a file, a text that describes it. Start and goal stay.
/// @param places  positions in the world [m] by body name, as in the key `places` of a scene
/// @throws core::InvalidInput: no such fixed body, not finite
void set_places(Task& task, const std::map<std::string, Eigen::Vector3d>& places);

/// Replaces the goal pose: x y z [m] roll pitch yaw [rad] for a free object, its coordinates for any other. Tolerances stay.
/// @throws core::InvalidInput: wrong number of values, not finite
void set_goal(Task& task, std::span<const double> values);
/// Same as above; nullopt marks a coordinate that may have any value, so the goal is a region.
void set_goal(Task& task, const std::vector<std::optional<double>>& values);

/// Makes the input of trajopt::optimize for the task: the constant guess and reference of its section `optimize`. The result refers to the
/// task.
/// @throws core::InvalidInput: no such section
trajopt::OptimizeInput make_optimize_input(const Task& task);

}  // namespace stiction::tasks
