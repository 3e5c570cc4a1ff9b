#pragma once

#include <Eigen/Geometry>
#include <string>
#include <string_view>
#include <vector>

#include "stiction/planning/planner.hpp"
#include "stiction/world/model.hpp"
#include "stiction/world/yaml.hpp"

namespace stiction::tasks {

// The sections `start` and `goal` of a task file. All of them @throws core::InvalidInput with file, line and field.

/// Section `start` (n_q): objects by name, joints by name or as a list.
Eigen::VectorXd read_start(const world::YamlNode& node, const world::Model& model, std::vector<std::string>* notes = nullptr);

/// Section `goal`, into problem.goal and problem.q_goal; problem.q_start is known.
void read_goal(const world::YamlNode& node, const world::Model& model, planning::PlanningProblem& problem);

/// Section `bystanders`, into problem.goal; start and goal are known.
void read_bystanders(const world::YamlNode& node, const world::Model& model, planning::PlanningProblem& problem);

/// Section `tolerance`.
void read_tolerance(const world::YamlNode& node, planning::Goal& goal);

Eigen::Matrix3d rotation_of_rpy(const Eigen::Vector3d& rpy);
/// Rotation from `quaternion_wxyz` or `rpy`; the identity if neither is given.
Eigen::Quaterniond read_rotation(const world::YamlNode& pose);
/// Writes the pose of one object, as a start or goal section gives it, into q.
void read_object_pose(const world::YamlNode& node, const world::Model& model, int object, Eigen::VectorXd& q);
int find_object(const world::YamlNode& entry, const std::string& name, const world::Model& model);
bool is_free(const world::Model& model, int object);
/// Checks that the coordinate x of a hinge or slider is inside the limits of the object.
void require_in_limits(const world::YamlNode& node, const world::Model& model, int object, double x, std::string_view what);

}  // namespace stiction::tasks
