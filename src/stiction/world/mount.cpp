#include "stiction/world/mount.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <string_view>

#include "stiction/core/invalid_input.hpp"
#include "stiction/core/sha256.hpp"
#include "stiction/world/urdf.hpp"
#include "stiction/world/yaml.hpp"

namespace stiction::world {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// Index after the last link of a subtree; links come depth first.
int end_of_subtree(const RobotTree& tree, int link) {
  int end = link + 1;
  for (; end < static_cast<int>(tree.links.size()); ++end) {
    int up = end;
    while (up > link) up = tree.joints[at(up - 1)].parent;
    if (up != link) break;
  }
  return end;
}

/// Inserts the links of one tree into another, after the subtree of the link `on`.
void graft(RobotTree& tree, int on, const Pose& X_LM, RobotTree mounted) {
  const int begin = end_of_subtree(tree, on), count = static_cast<int>(mounted.links.size());
  const auto moved_link = [&](int link) { return link < begin ? link : link + count; };
  const auto moved_joint = [&](int joint) { return joint < 0 ? joint : moved_link(joint + 1) - 1; };
  for (RobotJoint& joint : tree.joints) {
    joint.parent = moved_link(joint.parent);
    joint.child = moved_link(joint.child);
    joint.leader = moved_joint(joint.leader);
  }
  for (RobotJoint& joint : mounted.joints) {
    joint.parent += begin;
    joint.child += begin;
    if (joint.leader >= 0) joint.leader += begin;
  }
  RobotJoint root{.name = fmt::format("{}.mount", mounted.links[0].name), .parent = on, .child = begin, .X_PJ = X_LM};
  mounted.joints.insert(mounted.joints.begin(), std::move(root));
  tree.links.insert(tree.links.begin() + begin, mounted.links.begin(), mounted.links.end());
  tree.joints.insert(tree.joints.begin() + begin - 1, mounted.joints.begin(), mounted.joints.end());
}

/// Reads one mounted file and gives its links and joints their final names.
class MountReader {
 public:
  MountReader(const RobotSpec& robot, const MountSpec& mount) : mount_(mount) {
    RobotSpec spec;
    spec.package_dirs = robot.package_dirs;
    spec.convex_hulls = robot.convex_hulls;
    spec.decomposition = robot.decomposition;
    spec.fixed_base = true;
    (is_urdf(mount.file) ? spec.urdf : spec.mjcf) = mount.file;
    is_mjcf_ = !spec.mjcf.empty();
    contents_ = *contents_of(spec);
  }

  RobotContents read() {
    if (!contents_.objects.empty())
      core::throw_invalid("file", fmt::format("{} with the object '{}'", mount_.file.string(), contents_.objects[0].name),
                          "a file with a robot alone");
    RobotTree& tree = contents_.robot;
    root_ = is_mjcf_ ? tree.links[0].name : "";
    for (RobotLink& link : tree.links) {
      link.name = rename(link.name);
      for (RobotCollision& collision : link.collisions) collision.mask.file = tree.links[0].name;
    }
    for (RobotJoint& joint : tree.joints) joint.name = prefixed(joint.name);
    for (auto& [a, b] : contents_.excludes) a = rename(a), b = rename(b);
    std::erase_if(contents_.contacts, [&](const ContactSpec& contact) { return is_of_world(contact.a) || is_of_world(contact.b); });
    for (ContactSpec& contact : contents_.contacts) contact.a = rename_geometry(contact.a), contact.b = rename_geometry(contact.b);
    for (auto& [joint, value] : contents_.as_written.joints) joint = prefixed(joint);
    for (FilePlace& place : contents_.places) place.name = prefixed(place.name), place.moved_by = rename(place.moved_by);
    for (FileVisual& visual : tree.visuals) {
      visual.owner = visual.owner.empty() ? tree.links[0].name : rename(visual.owner);
      if (auto* file = std::get_if<VisualFile>(&visual.form); file != nullptr && file->file.empty()) file->file = mount_.file;
    }
    for (std::string& note : tree.unseen) note = fmt::format("{}: {}", mount_.file.filename().string(), note);
    for (std::string& note : tree.notes) note = fmt::format("{}: {}", mount_.file.filename().string(), note);
    if (!contents_.fixed.empty())
      tree.notes.push_back(
          fmt::format("{}: shapes of its world are left out, {} of them", mount_.file.filename().string(), contents_.fixed.size()));
    return std::move(contents_);
  }

 private:
  std::string prefixed(const std::string& name) const { return mount_.name.empty() ? name : fmt::format("{}_{}", mount_.name, name); }
  std::string rename(const std::string& link) const {
    if (link.empty() || link != root_) return prefixed(link);
    return mount_.name.empty() ? mount_.file.stem().string() : mount_.name;
  }

  bool is_of_world(const std::string& geometry) const { return is_mjcf_ && geometry.starts_with(root_ + "/"); }
  std::string rename_geometry(const std::string& name) const {
    const std::size_t slash = name.find('/');
    return rename(name.substr(0, slash)) + name.substr(slash);
  }

  const MountSpec& mount_;
  RobotContents contents_{};
  bool is_mjcf_ = false;
  std::string root_{};  ///< name for the root of an MJCF, which is the world and has no name of its own
};

void mount(const RobotSpec& robot, const MountSpec& mount, RobotContents& contents) {
  std::vector<std::string> links;
  std::set<std::string> joints;
  for (const auto& link : contents.robot.links) links.push_back(link.name);
  for (const auto& joint : contents.robot.joints) joints.insert(joint.name);
  const auto on = std::find(links.begin(), links.end(), mount.on);
  if (on == links.end()) core::throw_invalid("on", fmt::format("unknown link '{}'", mount.on), "one of " + list_with_hint(mount.on, links));
  RobotContents added = MountReader(robot, mount).read();
  for (const RobotLink& link : added.robot.links) {
    if (std::find(links.begin(), links.end(), link.name) != links.end())
      core::throw_invalid("name", fmt::format("link '{}' twice", link.name), "a name that goes in front of those of the mounted file");
  }
  for (const RobotJoint& joint : added.robot.joints) {
    if (joints.contains(joint.name))
      core::throw_invalid("name", fmt::format("joint '{}' twice", joint.name), "a name that goes in front of those of the mounted file");
  }
  const std::string root = added.robot.links[0].name;
  for (const auto& [a, b] : added.excludes) contents.excludes.emplace_back(a, b);
  contents.contacts.insert(contents.contacts.end(), added.contacts.begin(), added.contacts.end());
  for (auto& place : added.places) {  // X_WF is meaningless, since the mounted file is not at the world's origin
    place.with_robot = true;
    if (place.moved_by.empty()) place.moved_by = root;
    contents.places.push_back(std::move(place));
  }
  contents.as_written.joints.insert(contents.as_written.joints.end(), added.as_written.joints.begin(), added.as_written.joints.end());
  contents.robot.notes.insert(contents.robot.notes.end(), added.robot.notes.begin(), added.robot.notes.end());
  for (FileVisual& visual : added.robot.visuals) contents.robot.visuals.push_back(std::move(visual));
  for (std::string& note : added.robot.unseen) contents.robot.unseen.push_back(std::move(note));
  contents.sha256 = core::sha256(fmt::format("{} {} {}", contents.sha256, mount.on, added.sha256));
  graft(contents.robot, static_cast<int>(on - links.begin()), mount.X_LM, std::move(added.robot));
}

}  // namespace

void mount_all(const RobotSpec& robot, RobotContents& contents) {
  for (std::size_t i = 0; i < robot.mounts.size(); ++i) {
    try {
      mount(robot, robot.mounts[i], contents);
    } catch (const core::InvalidInput& e) {
      const std::string_view what = e.what();  // a fault in the file, or one of a key
      throw core::InvalidInput(fmt::format("mount[{}]{}{}", i, what.starts_with(robot.mounts[i].file.string()) ? ": " : ".", what));
    }
  }
}

}  // namespace stiction::world
