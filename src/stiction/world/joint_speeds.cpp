#include "stiction/world/joint_speeds.hpp"

#include <fmt/format.h>
#include <tinyxml2.h>

#include <limits>

#include "stiction/core/invalid_input.hpp"
#include "stiction/world/robot_tree.hpp"

namespace stiction::world {
namespace {

/// The velocity of one joint element; infinite where it has none.
double read_speed(const std::filesystem::path& file, const tinyxml2::XMLElement& joint, std::string_view name) {
  const tinyxml2::XMLElement* limit = joint.FirstChildElement("limit");
  const char* text = limit == nullptr ? nullptr : limit->Attribute("velocity");
  if (text == nullptr) return std::numeric_limits<double>::infinity();
  double speed = 0;
  if (limit->QueryDoubleAttribute("velocity", &speed) != tinyxml2::XML_SUCCESS || !(speed >= 0))
    core::throw_invalid(fmt::format("{}:{}: joint '{}' velocity", file.string(), limit->GetLineNum(), name), fmt::format("'{}'", text),
                        "a number > 0, or 0 where it is not known");
  return speed > 0 ? speed : std::numeric_limits<double>::infinity();
}

void read_robot(const Model& model, const RobotSpec& robot, Eigen::VectorXd& speeds) {
  const std::filesystem::path name = robot.text.empty() ? robot.urdf : kTextName;
  tinyxml2::XMLDocument document;
  const auto error = robot.text.empty() ? document.LoadFile(robot.urdf.c_str()) : document.Parse(robot.text.data(), robot.text.size());
  if (error != tinyxml2::XML_SUCCESS || document.RootElement() == nullptr)
    core::throw_invalid(name.string(), document.ErrorStr(), "the URDF that the model was made of");
  for (auto* joint = document.RootElement()->FirstChildElement("joint"); joint != nullptr; joint = joint->NextSiblingElement("joint")) {
    const char* joint_name = joint->Attribute("name");
    if (joint_name == nullptr) continue;
    const std::string full = fmt::format("{}/{}", robot.name, joint_name);
    for (int j = 0; j < model.n_a(); ++j) {
      if (model.dofs()[static_cast<std::size_t>(model.n_vu() + j)].name == full) speeds[j] = read_speed(name, *joint, joint_name);
    }
  }
}

}  // namespace

Eigen::VectorXd read_joint_speeds(const Model& model) {
  Eigen::VectorXd speeds = Eigen::VectorXd::Constant(model.n_a(), std::numeric_limits<double>::infinity());
  for (const RobotSpec& robot : model.scene().robots) {
    if (!robot.urdf.empty()) read_robot(model, robot, speeds);
  }
  return speeds;
}

}  // namespace stiction::world
