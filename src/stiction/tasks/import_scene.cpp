#include "stiction/tasks/import_scene.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <system_error>

#include "stiction/core/invalid_input.hpp"
#include "stiction/world/robot_tree.hpp"
#include "stiction/world/urdf.hpp"

namespace stiction::tasks {
namespace {

namespace fs = std::filesystem;
using world::ObjectJoint;
using world::ObjectSpec;
using world::RobotContents;

/// A text in the double quotes of YAML.
std::string in_quotes(std::string_view text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c >= 0 && c < ' ')
      out += fmt::format("\\x{:02x}", static_cast<int>(c));
    else
      out += c == '"' || c == '\\' ? std::string{'\\', c} : std::string{c};
  }
  return out + "\"";
}

/// A name quoted as YAML flow style needs it.
std::string quoted(const std::string& name) {
  const auto plain = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '-' || c == '.'; };
  const bool word = !name.empty() && std::isalpha(static_cast<unsigned char>(name[0])) != 0 && std::all_of(name.begin(), name.end(), plain);
  constexpr std::string_view kMeanings[] = {"true", "false", "null", "yes", "no", "on", "off", "nan", "inf", "y", "n"};
  return word && std::find(std::begin(kMeanings), std::end(kMeanings), name) == std::end(kMeanings) ? name : in_quotes(name);
}

/// Names for a comment, which ends with its line.
std::vector<std::string> in_one_line(std::vector<std::string> names) {
  for (std::string& name : names) {
    if (std::any_of(name.begin(), name.end(), [](unsigned char c) { return c < ' '; })) name = in_quotes(name);
  }
  return names;
}

std::string number(double x) { return fmt::format("{:.6g}", x + 0.0); }

/// The file, its contents, and whether the base of its robot had to be fixed.
struct Found {
  std::shared_ptr<const RobotContents> contents;
  bool fixed_base = false;
};

Found read_file(const fs::path& file) {
  world::RobotSpec robot;
  robot.name = "robot";
  (world::is_urdf(file) ? robot.urdf : robot.mjcf) = file;
  robot.split.by_actuators = true;
  try {
    return {world::contents_of(robot), false};
  } catch (const core::InvalidInput& e) {
    if (std::string_view(e.what()).find("fixed_base") == std::string_view::npos) throw;
  }
  robot.fixed_base = true;
  return {world::contents_of(robot), true};
}

std::string describe(const ObjectSpec& object) {
  std::string out = object.name;
  switch (object.joint) {
    case ObjectJoint::Free:
      return out + " (free)";
    case ObjectJoint::PlanarXY:
    case ObjectJoint::PlanarYZ:
    case ObjectJoint::PlanarXZ:
      return out + " (in a plane)";
    case ObjectJoint::Hinge:
    case ObjectJoint::Slider:
      out += object.joint == ObjectJoint::Hinge ? " (hinge" : " (slider";
      if (object.limits) out += fmt::format(" [{}, {}]", number((*object.limits)[0]), number((*object.limits)[1]));
      return out + ")";
  }
  return out;
}

bool says_goal(std::string name) {
  std::transform(name.begin(), name.end(), name.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return name.find("goal") != std::string::npos || name.find("target") != std::string::npos;
}

/// A goal for an object that starts at q. @param places  fixed sites and bodies
std::string make_goal(const ObjectSpec& object, const Eigen::VectorXd& q, const std::vector<std::string>& places) {
  constexpr double kMove = 0.1, kTurn = 0.5, kShare = 0.9;  // [m], [rad], of the way to the farther end
  if (object.joint == ObjectJoint::Hinge || object.joint == ObjectJoint::Slider) {
    double to = q[0] + (object.joint == ObjectJoint::Hinge ? kTurn : kMove);
    if (object.limits) {
      const auto [lower, upper] = *object.limits;
      to = q[0] + kShare * ((q[0] - lower > upper - q[0] ? lower : upper) - q[0]);
    }
    return fmt::format("objects: {{{}: {{coordinates: [{}]}}}}", quoted(object.name), number(to));
  }
  const auto place = std::find_if(places.begin(), places.end(), says_goal);
  if (place != places.end()) return fmt::format("object: {}, at: {}, rpy: ~", quoted(object.name), quoted(*place));
  if (object.joint != ObjectJoint::Free)
    return fmt::format("objects: {{{}: {{coordinates: [{}, {}, {}]}}}}", quoted(object.name), number(q[0] + kMove), number(q[1]),
                       number(q[2]));
  return fmt::format("objects: {{{}: {{position: [{}, {}, {}], rpy: ~}}}}", quoted(object.name), number(q[0] + kMove), number(q[1]),
                     number(q[2]));
}

class SceneImporter {
 public:
  SceneImporter(const fs::path& file, const fs::path& folder, const std::string& object)
      : file_(file), folder_(folder), object_(object), found_(read_file(file)) {}

  std::string write() const {
    const RobotContents& contents = *found_.contents;
    const auto joints = contents.robot.movable_joints();
    if (joints.empty()) fail_without_robot();
    if (contents.objects.empty())
      fail("a file without an object: every joint is in a tree with an actuator, or nothing that it moves collides");
    std::vector<std::string> objects, names, keyframes, places;
    for (const ObjectSpec& object : contents.objects) objects.push_back(describe(object));
    std::vector<std::size_t> bodies;  // indices of the objects that are bodies of the file
    for (std::size_t i = 0; i < contents.objects.size(); ++i) {
      if (!is_between(contents.objects[i])) bodies.push_back(i), names.push_back(quoted(contents.objects[i].name));
    }
    for (const auto& keyframe : contents.keyframes) keyframes.push_back(quoted(keyframe.name));
    for (const auto& place : contents.places) {
      if (place.moved_by.empty()) places.push_back(place.name);
    }
    std::string out = fmt::format("# Robot: {} joint{} ({}).\n# Objects, and the only bodies that move beside it: {}.\n", joints.size(),
                                  joints.size() == 1 ? "" : "s", world::list_some(in_one_line(joints)), fmt::join(objects, ", "));
    if (keyframes.size() > 1) out += fmt::format("# Keyframes: {}.\n", fmt::join(keyframes, ", "));
    if (!places.empty()) out += fmt::format("# Places for `at` of a goal: {}.\n", world::list_some(in_one_line(places)));
    out += fmt::format("scene:\n  file: {}\n", quoted_path());
    if (found_.fixed_base) out += "  robot: {fixed_base: true}\n";
    out += fmt::format("  objects: [{}]\n", fmt::join(names, ", "));
    if (keyframes.empty())
      out += "start: {}  # as the file has it; `joints`, `poses` of links and `objects` change it\n";
    else
      out += fmt::format("start: {{keyframe: {}}}\n", keyframes[0]);
    const auto& at = keyframes.empty() ? contents.as_written : contents.keyframes[0];
    const std::size_t moved = find_moved(bodies);
    out += fmt::format("goal: {{{}}}  # to be edited\n", make_goal(contents.objects[moved], at.objects[moved].second, places));
    return out + "tolerance: {position: 0.01, angle: 0.1}\n";
  }

 private:
  [[noreturn]] void fail(std::string_view got) const {
    throw core::InvalidInput(
        fmt::format("{}: import: got {}, expected one that has both (a scene of several files is written by hand)", file_.string(), got));
  }

  /// Index of the object of the goal.
  std::size_t find_moved(const std::vector<std::size_t>& bodies) const {
    if (object_.empty()) return bodies[0];
    std::vector<std::string> names;
    for (const std::size_t i : bodies) {
      names.push_back(found_.contents->objects[i].name);
      if (names.back() == object_) return i;
    }
    core::throw_invalid("object", fmt::format("'{}'", object_), fmt::format("one of {}", fmt::join(names, ", ")));
  }

  [[noreturn]] void fail_without_robot() const {
    std::vector<std::string> trees;
    for (const ObjectSpec& object : found_.contents->objects) {
      if (object.parent.empty() && !is_between(object)) trees.push_back(object.name);
    }
    const std::string by_name =
        trees.empty() ? ""
                      : fmt::format(", or a task with `robot: {{bodies: […]}}` beside its `file`, for one of {}", world::list_some(trees));
    throw core::InvalidInput(
        fmt::format("{}: import: got a file without a robot, expected a joint with an actuator{}", file_.string(), by_name));
  }

  /// An object of a body with several joints, other than the last, which has the name of the body.
  bool is_between(const ObjectSpec& object) const {
    const auto& objects = found_.contents->objects;
    const auto hangs_on_it = [&](const ObjectSpec* o) {
      while (o != nullptr && o->parent != object.name) {
        const auto next = std::find_if(objects.begin(), objects.end(), [&](const ObjectSpec& p) { return p.name == o->parent; });
        o = next != objects.end() ? &*next : nullptr;
      }
      return o != nullptr;
    };
    return std::any_of(objects.begin(), objects.end(),
                       [&](const ObjectSpec& o) { return object.name.starts_with(o.name + ".") && hangs_on_it(&o); });
  }

  std::string quoted_path() const {
    std::error_code error;
    const fs::path path = fs::relative(fs::absolute(file_), fs::absolute(folder_), error);
    return in_quotes((error || path.empty() ? fs::absolute(file_) : path).generic_string());
  }

  const fs::path& file_;
  const fs::path& folder_;
  const std::string& object_;
  Found found_;
};

}  // namespace

std::string import_scene(const fs::path& file, const fs::path& folder, const std::string& object) {
  return SceneImporter(file, folder, object).write();
}

std::vector<std::string> list_keyframes(const fs::path& file) {
  const Found found = read_file(file);
  std::vector<std::string> out;
  for (const auto& keyframe : found.contents->keyframes) out.push_back(keyframe.name);
  return out;
}

}  // namespace stiction::tasks
