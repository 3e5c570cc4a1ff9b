#include "stiction/tasks/file_start.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>

#include "stiction/world/mjcf.hpp"
#include "stiction/world/object_space.hpp"

namespace stiction::tasks {
namespace {

using world::FileConfiguration;
using world::Model;
using world::RobotSpec;

/// A configuration of the file of one robot.
void apply(const FileConfiguration& file, const RobotSpec& robot, bool joints, const Model& model, Eigen::VectorXd& q,
           std::vector<bool>& placed) {
  for (const auto& [name, given] : file.objects) {
    for (std::size_t o = 0; o < model.objects().size(); ++o) {
      const world::ObjectInfo& info = model.objects()[o];
      if (info.name != name || info.n_q != given.size()) continue;
      Eigen::VectorXd at = given;
      if (info.n_q == 7) {
        const Eigen::Quaterniond base(robot.X_WBase.R);
        at.head<3>() = robot.X_WBase * Eigen::Vector3d(given.head<3>());
        at.tail<4>() = (base * Eigen::Quaterniond(given[6], given[3], given[4], given[5])).normalized().coeffs();
      } else if (info.n_q == 1) {
        const world::Dof& dof = model.dofs()[static_cast<std::size_t>(info.v_begin)];
        at[0] = std::clamp(given[0], dof.lower, dof.upper);
      }
      q.segment(info.q_begin, info.n_q) = at;
      placed[o] = true;
    }
  }
  for (int j = 0; joints && j < model.n_a(); ++j) {
    const world::Dof& dof = model.dofs()[static_cast<std::size_t>(model.n_vu() + j)];
    for (const auto& [name, value] : file.joints) {
      if (dof.name == fmt::format("{}/{}", robot.name, name)) q[model.n_qu() + j] = std::clamp(value, dof.lower, dof.upper);
    }
  }
}

/// Pose of the fixed bodies of a file, which `places` of the scene may have moved.
world::Pose pose_of_fixed(const RobotSpec& robot, const Model& model) {
  const auto& fixed = model.scene().fixed;
  const auto body = std::ranges::find(fixed, world::name_of_fixed(robot), &world::FixedSpec::name);
  return body != fixed.end() ? body->X_WB : robot.X_WBase;
}

}  // namespace

void start_as_written(const Model& model, Eigen::VectorXd& q, std::vector<bool>& placed) {
  for (const RobotSpec& robot : model.scene().robots) apply(robot.contents->as_written, robot, robot.split.by_actuators, model, q, placed);
}

void start_at_keyframe(const world::YamlNode& name, const Model& model, Eigen::VectorXd& q, std::vector<bool>& placed,
                       std::vector<std::string>* notes) {
  const std::string wanted = name.string();
  std::vector<std::string> known;
  for (const RobotSpec& robot : model.scene().robots) {
    for (const FileConfiguration& keyframe : robot.contents->keyframes) {
      if (keyframe.name == wanted) {
        if (notes != nullptr && !keyframe.elsewhere.empty()) {
          notes->push_back(
              fmt::format("{}: keyframe '{}' moves {}, which {} still at the pose of the file, since the scene has no such object",
                          name.where(), wanted, world::list_some(keyframe.elsewhere), keyframe.elsewhere.size() == 1 ? "stands" : "stand"));
        }
        return apply(keyframe, robot, true, model, q, placed);
      }
      known.push_back(keyframe.name);
    }
  }
  name.fail_unknown("keyframe", wanted, known);
}

world::Pose find_body_of_object(const Model& model, int object) {
  const std::string& name = model.objects()[static_cast<std::size_t>(object)].name;
  const auto named = [&](const auto& item) { return item.name == name; };
  for (const RobotSpec& robot : model.scene().robots) {
    const auto body = std::ranges::find_if(robot.contents->places, named);
    if (body == robot.contents->places.end() || body->moved_by != name) continue;
    Eigen::VectorXd q = model.neutral();
    std::vector<bool> placed(model.objects().size(), false);
    apply(robot.contents->as_written, robot, false, model, q, placed);
    return world::object_pose(model, q, object).inverse() * (robot.X_WBase * body->X_WF);
  }
  return {};
}

world::Pose find_place(const world::YamlNode& name, const Model& model) {
  const std::string wanted = name.string();
  std::vector<std::string> known;
  for (const RobotSpec& robot : model.scene().robots) {
    for (const world::FilePlace& place : robot.contents->places) {
      if (place.name == wanted) {
        if (place.moved_by.empty()) return pose_of_fixed(robot, model) * place.X_WF;
        name.fail(
            fmt::format("'{}', which moves with {} '{}'", wanted, place.with_robot ? "the robot's link" : "the object", place.moved_by),
            "a site or a body that stands still");
      }
      if (place.moved_by.empty()) known.push_back(place.name);
    }
  }
  name.fail_unknown("site or body", wanted, known);
}

}  // namespace stiction::tasks
