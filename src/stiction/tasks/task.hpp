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

/// A scene, a start, a goal and how to plan, as one YAML file says (schema: tasks/schema/task.schema.json).
struct Task {
  std::string name;
  std::string description;
  std::filesystem::path file;  ///< absolute; of a task in memory the folder that its paths are relative to, with '/' at its end
  std::string text;            ///< of a task in memory; empty: that of `file`
  world::YamlNode document;    ///< the file, with its `base`, or the text, as it was read
  bool builtin = false;        ///< found by its name in a data folder
  std::shared_ptr<const world::Model> model;  ///< model->scene() is the scene
  planning::PlanningProblem problem;
  planning::PlannerOptions options;
  std::optional<OptimizeSetup> optimize;   ///< the section of that name, if there is one
  std::string scene_text;                  ///< see make_scene_text
  std::string scene_sha256;                ///< of scene_text
  bool start_from_command_line = false;    ///< set_start replaced the start of the file
  bool goal_from_command_line = false;     ///< set_goal replaced the goal of the file
  bool options_from_command_line = false;  ///< options were given beside those of the file
  std::vector<std::string> notes;          ///< what was taken otherwise than the file says, a sentence each
};

/// Where built-in tasks are looked up when no folders are given: share/stiction/tasks of the installation that runs, the source folder.
std::vector<std::filesystem::path> default_data_dirs();

/// Where package:// of a robot is looked up when its own `package_dirs` do not have it: the folders of ROS_PACKAGE_PATH, the folders
/// share/ of AMENT_PREFIX_PATH (ROS 2), then the packages installed beside this code or where its dependencies were at build time
/// (`pip install example-robot-data`).
std::vector<std::filesystem::path> default_package_dirs();

/// Names of the built-in tasks, in alphabetical order.
std::vector<std::string> list_tasks(std::span<const std::filesystem::path> data_dirs);

/// Loads a built-in task by its name, or a file: anything that ends in .yaml or .yml or contains a '/'.
/// @throws core::InvalidInput "FILE:LINE: field: got …, expected …"
Task load_task(const std::string& name_or_file, std::span<const std::filesystem::path> data_dirs);
Task load_task(const std::string& name_or_file);

/// A task in memory. @param text  as in a file (YAML or JSON)  @param folder  that paths in it are relative to
/// @throws core::InvalidInput "field: got …, expected …"
Task parse_task(const std::string& text, const std::filesystem::path& folder);

/// Replaces the start. @param q  configuration (n_q)   @throws core::InvalidInput: size, not finite, quaternions that are not of length 1
void set_start(Task& task, Eigen::Ref<const Eigen::VectorXd> q);

/// Puts fixed bodies elsewhere: a scene, and a text that says so where the task is of a file; the start and the goal stay.
/// @param places  positions in the world [m] by name, as of the key `places` of a scene
/// @throws core::InvalidInput: no such fixed body, not finite
void set_places(Task& task, const std::map<std::string, Eigen::Vector3d>& places);

/// Replaces the goal pose: x y z [m] roll pitch yaw [rad] for a free object, its coordinates for any other. Tolerances stay.
/// @throws core::InvalidInput: wrong number of values, not finite
void set_goal(Task& task, std::span<const double> values);
/// The same with nullopt for a coordinate that may have any value: a goal region.
void set_goal(Task& task, const std::vector<std::optional<double>>& values);

/// What trajopt::optimize needs for the task: the constant guess and reference of its section `optimize`. It refers to the task.
/// @throws core::InvalidInput: no such section
trajopt::OptimizeInput make_optimize_input(const Task& task);

}  // namespace stiction::tasks
