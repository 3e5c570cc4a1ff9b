#include "stiction/tasks/lint_robots.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <variant>

#include "stiction/world/robot_tree.hpp"
#include "stiction/world/scales.hpp"

namespace stiction::tasks {
namespace {

using world::RobotTree;

/// Looks at one robot of a task.
class RobotLinter {
 public:
  RobotLinter(const world::Model& model, int robot, std::vector<Finding>& out)
      : model_(model),
        robot_(robot),
        spec_(model.scene().robots[static_cast<std::size_t>(robot)]),
        tree_(spec_.contents->robot),
        out_(out) {}

  void run() {
    only_seen();
    size();
  }

 private:
  /// Links that joints weld together have one number, that of the link nearest to the root.
  std::vector<std::size_t> calc_welded() const {
    std::vector<std::size_t> group(tree_.links.size(), 0);
    for (std::size_t i = 1; i < tree_.links.size(); ++i) {
      const world::RobotJoint& joint = tree_.joints[i - 1];
      group[i] = joint.moves() ? i : group[static_cast<std::size_t>(joint.parent)];
    }
    return group;
  }

  /// Links that move, that the file shows, and that have nothing to touch, nor has what is welded to them.
  void only_seen() {
    const std::vector<std::size_t> group = calc_welded();
    std::vector<std::string> names;
    for (std::size_t i = 0; i < tree_.links.size(); ++i) {
      if (!tree_.links[i].only_seen || group[i] == 0) continue;
      bool touches = false;
      for (std::size_t k = 0; k < tree_.links.size(); ++k)
        touches = touches || (group[k] == group[i] && !tree_.links[k].collisions.empty());
      if (!touches) names.push_back(tree_.links[i].name);
    }
    if (names.empty()) return;
    out_.push_back(
        {"visual", fmt::format("'{}': links that are seen and that nothing can touch, because they have no collision geometry: {}; "
                               "give them some, if they are to touch anything",
                               spec_.name, world::list_some(names))});
    for (const std::string& name : names) out_.back().names.push_back(fmt::format("{}/{}", spec_.name, name));
  }

  /// How far the links are from the root at most, as the joints have it: without what they look like [m].
  double calc_span() const {
    std::vector<double> to(tree_.links.size(), 0);
    double span = 0;
    for (std::size_t i = 1; i < tree_.links.size(); ++i) {
      const world::RobotJoint& joint = tree_.joints[i - 1];
      const double most = std::max(std::abs(joint.lower), std::abs(joint.upper));
      const double slide = joint.kind == world::RobotJoint::Kind::Prismatic && std::isfinite(most) ? most : 0;
      to[i] = to[static_cast<std::size_t>(joint.parent)] + joint.X_PJ.p.norm() + slide;
      span = std::max(span, to[i]);
    }
    return span;
  }

  /// "'NAME' (FILE) is SIZE".
  static std::string describe(const world::Geometry& geometry) {
    const auto* mesh = std::get_if<world::Mesh>(&geometry.shape);
    const std::filesystem::path source = mesh != nullptr ? mesh->mesh->source : "";
    return fmt::format("'{}'{} is {:.3g}", geometry.name, source.empty() ? "" : fmt::format(" ({})", source.filename().string()),
                       2 * geometry.bounding_radius);
  }

  /// A shape that is many times as large as the robot is long; of a robot of one link, as the largest object.
  void size() {
    constexpr double kSpans = 10, kObjects = 100;
    double largest_object = 0;
    for (int o = 0; o < static_cast<int>(model_.objects().size()); ++o)
      largest_object = std::max(largest_object, model_.scales().object(o).length);
    const double span = calc_span(), limit = std::max(kSpans * span, span > 0 ? 0.0 : kObjects * largest_object);
    if (!(limit > 0)) return;
    const world::Geometry* widest = nullptr;
    int count = 0;
    for (const world::Geometry& geometry : model_.geometries()) {
      const world::Body& body = model_.bodies()[static_cast<std::size_t>(geometry.body)];
      if (body.kind != world::BodyKind::Robot || body.owner != robot_ || !(2 * geometry.bounding_radius > limit)) continue;
      ++count;
      if (widest == nullptr || geometry.bounding_radius > widest->bounding_radius) widest = &geometry;
    }
    if (widest == nullptr) return;
    const std::string others = count > 1 ? fmt::format(" ({} shapes of the robot are as large)", count) : "";
    const std::string against = span > 0 ? fmt::format("the joints of the robot reach {:.3g} m", span)
                                         : fmt::format("the largest object is {:.3g} m large", largest_object);
    out_.push_back({"size", fmt::format("{} m across{}, and {}; lengths are in metres: {}", describe(*widest), others, against,
                                        std::holds_alternative<world::Mesh>(widest->shape)
                                            ? "is the file in millimetres? Then write scale=\"0.001 0.001 0.001\" at the mesh"
                                            : "is the shape in millimetres?")});
    out_.back().names = {widest->name};
    out_.back().amount = 2 * widest->bounding_radius;
  }

  const world::Model& model_;
  int robot_ = 0;
  const world::RobotSpec& spec_;
  const RobotTree& tree_;
  std::vector<Finding>& out_;
};

}  // namespace

void lint_robots(const Task& task, std::vector<Finding>& out) {
  for (int robot = 0; robot < static_cast<int>(task.model->robots().size()); ++robot) RobotLinter(*task.model, robot, out).run();
}

}  // namespace stiction::tasks
