#include "stiction/world/urdf_scene.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "stiction/core/invalid_input.hpp"
#include "stiction/world/mjcf_names.hpp"
#include "stiction/world/scene_sections.hpp"
#include "stiction/world/shapes.hpp"
#include "stiction/world/yaml.hpp"

namespace stiction::world {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

bool is_mobile(const RobotJoint& joint) { return joint.moves() || joint.floating; }

/// Adds the inertia of a body fixed at the pose X to another body. Both inertias are about centres of mass.
void add_inertia(const BodyInertia& part, const Pose& X, BodyInertia& whole) {
  const double mass = whole.mass + part.mass;
  if (!(mass > 0)) return;
  const Eigen::Vector3d p = X * part.p_BCom, center = (whole.mass * whole.p_BCom + part.mass * p) / mass;
  whole.inertia +=
      parallel_axis(whole.mass, whole.p_BCom - center) + X.R * part.inertia * X.R.transpose() + parallel_axis(part.mass, p - center);
  whole.p_BCom = center;
  whole.mass = mass;
}

/// Inertia of a link as an object. A link with a mass and no moments gets the moments of its shapes at that mass, since an object needs moments.
BodyInertia inertia_of(const RobotLink& link) {
  const BodyInertia shapes = calc_inertia(link);
  BodyInertia out = link.inertia.value_or(shapes);
  if (out.inertia.isZero(0) && shapes.mass > 0) out.inertia = out.mass / shapes.mass * shapes.inertia;
  return out;
}

class UrdfSplitter {
 public:
  UrdfSplitter(const MjcfSplit& split, RobotContents& contents) : split_(split), contents_(contents), tree_(contents.robot) {}

  void run() {
    make_names_usable();
    find_trees();
    decide();
    for (std::size_t link = 0; link < tree_.links.size(); ++link) {
      if (mover(link) == static_cast<int>(link) && role_[link] == Role::Object) add_object(link);
    }
    add_places();
    hand_over_visuals();
    take_objects_out();
    if (!loose_.empty()) tree_.notes.push_back("joints of objects that follow others move by themselves here: " + list_some(loose_));
  }

 private:
  enum class Role {
    Fixed,
    Robot,
    Object
  };

  [[noreturn]] static void fail(std::string_view got, std::string_view expected) {
    throw core::InvalidInput(fmt::format("urdf: got {}, expected {}", got, expected));
  }

  /// Changes names of links that an object cannot have.
  void make_names_usable() {
    std::set<std::string> taken;
    for (const RobotLink& link : tree_.links) taken.insert(link.name);
    for (RobotLink& link : tree_.links) {
      std::string name = usable(link.name);
      if (name == link.name) continue;
      while (!taken.insert(name).second) name += "_";
      for (FileVisual& visual : tree_.visuals) {
        if (visual.owner == link.name) visual.owner = name;
      }
      link.name = name;
    }
  }

  /// The nearest link at or above this one that a joint moves; 0 if there is none.
  int mover(std::size_t link) const {
    while (link != 0 && !is_mobile(tree_.joints[link - 1])) link = at(tree_.joints[link - 1].parent);
    return static_cast<int>(link);
  }

  /// Pose of a link in one at or above it, with all joints between at zero.
  Pose pose_in(std::size_t link, std::size_t above) const {
    Pose X;
    for (; link != above; link = at(tree_.joints[link - 1].parent)) X = tree_.joints[link - 1].X_PJ * X;
    return X;
  }

  std::size_t find_link(const std::string& name, std::string_view what) const {
    std::vector<std::string> moving;
    for (std::size_t link = 0; link < tree_.links.size(); ++link) {
      const bool moves = what == "robot" ? top_[link] != 0 : link != 0 && is_mobile(tree_.joints[link - 1]);
      if (tree_.links[link].name == name) {
        if (!moves) fail(fmt::format("link '{}' as {}, which no joint moves", name, what), "a link that a joint moves");
        return link;
      }
      if (moves) moving.push_back(tree_.links[link].name);
    }
    fail(fmt::format("{} '{}', which is no link of the file", what, name),
         moving.empty() ? "none (no link has a joint that moves)" : "one of " + list_with_hint(name, moving));
  }

  void find_trees() {
    const std::size_t n = tree_.links.size();
    top_.assign(n, 0);
    actuated_.assign(n, false);
    for (std::size_t link = 1; link < n; ++link) {
      const std::size_t above = top_[at(tree_.joints[link - 1].parent)];
      top_[link] = above != 0 ? above : is_mobile(tree_.joints[link - 1]) ? link : 0;
    }
    for (std::size_t link = 1; link < n; ++link) {
      if (tree_.joints[link - 1].actuated) actuated_[top_[link]] = true;
    }
    for (const std::string& name : split_.robot) actuated_[top_[find_link(name, "robot")]] = true;
    for (std::size_t link = 1; link < n; ++link) {  // a joint that follows a robot's joint belongs to the robot; leaders move by themselves
      const int leader = tree_.joints[link - 1].leader;
      if (leader >= 0 && actuated_[top_[at(leader + 1)]]) actuated_[top_[link]] = true;
    }
    actuated_[0] = false;
  }

  void decide() {
    role_.assign(tree_.links.size(), Role::Fixed);
    for (std::size_t link = 1; link < role_.size(); ++link) {
      if (top_[link] != 0) role_[link] = actuated_[top_[link]] ? Role::Robot : Role::Object;
      if (tree_.joints[link - 1].floating) role_[link] = Role::Object;
    }
    if (!split_.objects) return propagate();
    std::vector<bool> named(role_.size(), false);
    for (const std::string& name : *split_.objects) named[find_link(name, "object")] = true;
    for (std::size_t link = 1; link < role_.size(); ++link) {
      RobotJoint& joint = tree_.joints[link - 1];
      if (named[link]) {
        role_[link] = Role::Object;
      } else if (role_[link] == Role::Object && is_mobile(joint)) {
        role_[link] = Role::Fixed;
        joint.kind = RobotJoint::Kind::Fixed;
        joint.floating = false;
        joint.leader = -1;
      }
    }
    propagate();
  }

  /// Assigns links fixed to an object, and the joints below it, to the objects.
  void propagate() {
    for (std::size_t link = 1; link < role_.size(); ++link) {
      const Role above = role_[at(tree_.joints[link - 1].parent)];
      if (above == Role::Object && (role_[link] == Role::Robot || !is_mobile(tree_.joints[link - 1]))) role_[link] = Role::Object;
      if (above != Role::Object && !is_mobile(tree_.joints[link - 1])) role_[link] = above;
    }
  }

  /// The object that carries a link; 0: the world.
  std::size_t carrier(std::size_t link) const {
    int up = tree_.joints[link - 1].parent;
    while (up != 0 && !(role_[at(up)] == Role::Object && mover(at(up)) == up)) up = tree_.joints[at(up - 1)].parent;
    return at(up);
  }

  void add_object(std::size_t link) {
    const RobotJoint& joint = tree_.joints[link - 1];
    const std::size_t above = carrier(link);
    ObjectSpec object;
    object.name = tree_.links[link].name;
    object.joint = joint.floating ? ObjectJoint::Free : joint.kind == RobotJoint::Kind::Revolute ? ObjectJoint::Hinge : ObjectJoint::Slider;
    Eigen::VectorXd q = Eigen::VectorXd::Zero(1);
    if (joint.floating) {
      const Pose X = pose_in(link, 0);
      q.resize(7);
      q.head<3>() = X.p;
      q.tail<4>() = Eigen::Quaterniond(X.R).coeffs();
    } else {
      if (above != 0) object.parent = tree_.links[above].name;
      object.axis = joint.axis;
      object.X_WP = pose_in(link, above);
      if (std::isfinite(joint.lower) || std::isfinite(joint.upper)) object.limits = {joint.lower, joint.upper};
      object.joint_friction = joint.friction;
      object.joint_damping = joint.damping;
      q[0] = std::clamp(0.0, joint.lower, joint.upper);
      if (joint.leader >= 0) loose_.push_back(joint.name);
      const std::size_t parent = at(joint.parent);
      for (const std::size_t part : parts_of(link)) {
        if (role_[parent] != Role::Object) contents_.excludes.emplace_back(tree_.links[part].name, tree_.links[parent].name);
      }
    }
    add_shapes(link, object);
    contents_.as_written.objects.emplace_back(object.name, q);
    contents_.objects.push_back(std::move(object));
  }

  /// The link that moves an object and the links fixed to it.
  std::vector<std::size_t> parts_of(std::size_t link) const {
    std::vector<std::size_t> out;
    for (std::size_t part = link; part < tree_.links.size(); ++part) {
      if (role_[part] == Role::Object && mover(part) == static_cast<int>(link)) out.push_back(part);
    }
    return out;
  }

  void add_shapes(std::size_t link, ObjectSpec& object) {
    BodyInertia whole;
    for (const std::size_t part : parts_of(link)) {
      const RobotLink& from = tree_.links[part];
      const Pose X = pose_in(part, link);
      add_inertia(inertia_of(from), X, whole);
      std::vector<std::string> shapes;
      for (const RobotCollision& c : from.collisions) {
        const std::string name = part == link ? c.name : fmt::format("{}.{}", from.name, c.name);
        object.geometries.push_back(
            {.name = name, .shape = c.shape, .X_BG = X * c.X_LG, .friction = c.friction.value_or(1.0), .mask = c.mask});
        shapes.push_back(fmt::format("{}/{}", object.name, name));
      }
      if (!shapes.empty()) contents_.shapes_of.emplace_back(from.name, std::move(shapes));
    }
    if (!(whole.mass > 0)) fail(fmt::format("object '{}' without mass and without a shape", object.name), "an <inertial> or a <collision>");
    object.mass = whole.mass;
    object.p_BCom = whole.p_BCom;
    object.inertia = whole.inertia;
    round_center(object);
  }

  void add_places() {
    for (std::size_t link = 0; link < tree_.links.size(); ++link) {
      FilePlace place{.name = tree_.links[link].name, .X_WF = pose_in(link, 0)};
      if (role_[link] == Role::Object) place.moved_by = tree_.links[at(mover(link))].name;
      if (role_[link] == Role::Robot) place.moved_by = place.name, place.with_robot = true;
      contents_.places.push_back(std::move(place));
    }
  }

  /// Moves the visuals of the links of an object to the object.
  void hand_over_visuals() {
    for (FileVisual& visual : tree_.visuals) {
      const auto found = std::find_if(tree_.links.begin(), tree_.links.end(), [&](const RobotLink& l) { return l.name == visual.owner; });
      const std::size_t link = static_cast<std::size_t>(found - tree_.links.begin());
      if (found == tree_.links.end() || role_[link] != Role::Object) continue;
      const std::size_t top = at(mover(link));
      visual.owner = tree_.links[top].name;
      visual.X_BV = pose_in(link, top) * visual.X_BV;
    }
  }

  void take_objects_out() {
    RobotTree left;
    left.name = tree_.name;
    left.notes = tree_.notes;
    left.visuals = tree_.visuals;
    left.unseen = tree_.unseen;
    std::vector<int> number(tree_.links.size(), -1);
    for (std::size_t link = 0; link < tree_.links.size(); ++link) {
      if (role_[link] == Role::Object) continue;
      number[link] = static_cast<int>(left.links.size());
      left.links.push_back(std::move(tree_.links[link]));
      if (link == 0) continue;
      RobotJoint joint = tree_.joints[link - 1];
      joint.parent = number[at(joint.parent)];
      joint.child = number[link];
      if (joint.leader >= 0) joint.leader = number[at(joint.leader + 1)] - 1;
      left.joints.push_back(std::move(joint));
    }
    tree_ = std::move(left);
  }

  const MjcfSplit& split_;
  RobotContents& contents_;
  RobotTree& tree_;
  std::vector<std::size_t> top_{};  ///< per link: the topmost link with a joint at or above it; 0 if there is none
  std::vector<bool> actuated_{};    ///< for each link at the top of a tree: the tree has an actuator
  std::vector<Role> role_{};        ///< per link
  std::vector<std::string> loose_{};
};

}  // namespace

void split_urdf(const MjcfSplit& split, RobotContents& contents) { UrdfSplitter(split, contents).run(); }

}  // namespace stiction::world
