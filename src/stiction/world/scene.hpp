#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace stiction::world {

/// Rigid transform X_AB: a point with coordinates p_B in B has coordinates R p_B + p in A.
struct Pose {
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  Eigen::Vector3d p = Eigen::Vector3d::Zero();  // [m]

  Eigen::Vector3d operator*(const Eigen::Vector3d& point) const { return R * point + p; }
  Pose operator*(const Pose& other) const { return {R * other.R, R * other.p + p}; }
  Pose inverse() const { return {R.transpose(), -(R.transpose() * p)}; }
};

/// Triangle mesh of a convex body, vertices in the geometry frame [m]; triangles wind so that normals point outwards.
struct ConvexMesh {
  Eigen::Matrix3Xd vertices;
  Eigen::Matrix3Xi triangles;
  std::string source;                                 ///< file it came from, empty for one made in memory
  std::shared_ptr<const Eigen::Matrix3Xd> surface{};  ///< corners (3 × 3n) of the triangles of that file, if it is a mesh: of all its parts
};

struct Sphere {
  double radius = 0;
};  // [m]
struct Capsule {
  double radius = 0;
  double half_length = 0;
};  // axis z, half_length of the cylindrical part [m]
struct Box {
  Eigen::Vector3d half_extents = Eigen::Vector3d::Zero();
};  // [m]
struct Cylinder {
  double radius = 0;
  double half_length = 0;
};                    // axis z [m]
struct HalfSpace {};  // the points with z ≤ 0; outward normal +z
struct Mesh {
  std::shared_ptr<const ConvexMesh> mesh;
};
using Shape = std::variant<Sphere, Capsule, Box, Cylinder, HalfSpace, Mesh>;

/// Mass distribution of a body.
struct BodyInertia {
  double mass = 0;                                    ///< [kg]
  Eigen::Vector3d p_BCom = Eigen::Vector3d::Zero();   ///< centre of mass in the body frame [m]
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();  ///< about the centre of mass, body axes [kg m²]
};

/// Two geometries may touch when one's `type` and the other's `affinity` have a bit in common.
struct ContactMask {
  std::uint32_t type = ~0u, affinity = ~0u;
};

/// What contacts of a surface resist beside sliding, and whose friction counts, as MuJoCo's `condim`, `friction` and `priority` say it. Only simulations know the
/// moments: a step has point contacts.
struct SurfaceRule {
  int dimension = 3;     ///< 1: a contact has no friction; 3: it resists sliding; 4: also turning about the normal; 6: also rolling
  double torsional = 0;  ///< largest moment about the normal beside the normal force [m], ≥ 0
  double rolling = 0;    ///< and about the tangents [m], ≥ 0
  int priority = 0;      ///< where two surfaces differ in it, the higher one's numbers count alone
};

struct GeometrySpec {
  std::string name;  ///< unique within its body
  Shape shape;
  Pose X_BG;              ///< geometry in body
  double friction = 1.0;  ///< μ of the surface, ≥ 0
  ContactMask mask{};
  double max_force = std::numeric_limits<double>::infinity();  ///< largest normal force that it bears from one other geometry [N], > 0
  SurfaceRule rule{};
};

/// How an object may move relative to the world (or, for hinges and sliders, about the placed frame).
enum class ObjectJoint {
  Free,
  PlanarXY,
  PlanarYZ,
  PlanarXZ,
  Hinge,
  Slider
};

struct ObjectSpec {
  std::string name;
  std::string parent{};  ///< object listed before that this one hangs on by a hinge or slider; empty: the world
  ObjectJoint joint = ObjectJoint::Free;
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();  ///< of a hinge or slider, in the placed frame
  Pose X_WP;        ///< placed frame P, in the parent's body frame where there is one; identity for free objects. q = 0 puts the body on P
  double mass = 0;  ///< [kg] > 0
  Eigen::Vector3d p_BCom = Eigen::Vector3d::Zero();
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();  ///< about the centre of mass, body axes [kg m²]
  double weight_share = 1;                            ///< of its weight that acts on it; the rest is compensated (MJCF: gravcomp)
  std::optional<std::array<double, 2>> limits;        ///< hinge or slider range [rad or m]
  double joint_friction = 0;                          ///< dry friction of a hinge or slider, ≥ 0 [N·m or N]
  double joint_damping = 0;                           ///< viscous friction of a hinge or slider, ≥ 0 [N·m·s/rad or N·s/m]
  double joint_stiffness = 0;                         ///< of a spring on a hinge or slider, ≥ 0 [N·m/rad or N/m]
  double joint_rest = 0;                              ///< where that spring is at rest [rad or m]
  std::vector<GeometrySpec> geometries;
};

/// How a mesh that is not convex is split into convex parts at load.
struct Decomposition {
  static constexpr double kMinThreshold = 0.01;
  double threshold = 0.05;  ///< how far a part may be from convex, in halves of the longest edge of the mesh's bounding box, 0.01 to 1
  int max_parts = 16;       ///< of each solid of the file; more are merged, whatever the threshold says
};

/// Which bodies of an MJCF belong to robots and which are objects.
struct MjcfSplit {
  /// Trees with an actuator are robots, and what moves in other trees are objects. Without this rule only free bodies are objects.
  bool by_actuators = false;
  std::vector<std::string> robot{};                   ///< bodies whose trees are robots although no actuator moves them
  std::optional<std::vector<std::string>> objects{};  ///< bodies that are objects, and the only ones; nullopt: by the rule

  bool operator==(const MjcfSplit&) const = default;
};

/// A file whose robot is mounted on a link of another one.
struct MountSpec {
  std::string name{};          ///< in front of the names of its links and joints, with '_'; empty: they stay as they are
  std::filesystem::path file;  ///< URDF or MJCF
  std::string on;              ///< link of the robot, or of what was mounted before
  Pose X_LM{};                 ///< root link of the file in that link
};

struct RobotContents;  // robot_tree.hpp

struct RobotSpec {
  std::string name;
  std::filesystem::path urdf;  ///< resolved file; of a `text` the folder that paths in it are relative to, with '/' at its end
  std::filesystem::path mjcf;  ///< instead of `urdf`; see add_mjcf in mjcf.hpp
  std::string text{};          ///< the URDF or MJCF itself, where there is no file
  std::vector<std::filesystem::path> package_dirs;  ///< where package:// is looked up
  Pose X_WBase;
  std::vector<std::pair<std::string, double>>
      stiffness;  ///< joint → K_a [N/m or N·m/rad]; goes before what the file says. Joints without one bear their effort at 1/40 of their range
  /// joint → largest force or torque of its motor [N or N·m], > 0, infinite for none; goes before what the file says
  std::vector<std::pair<std::string, double>> effort{};
  double friction = 1.0;  ///< of every collision geometry that has no own entry
  SurfaceRule rule{};     ///< of every collision geometry whose file states none
  std::vector<std::pair<std::string, double>> link_friction;
  bool convex_hulls = false;                     ///< each mesh as one hull, without a note; else as NonConvex::TakeHulls has it
  std::vector<std::string> push_with{};          ///< links, '*' matches any run of characters: only these may touch objects; empty: all
  std::optional<Decomposition> decomposition{};  ///< split meshes that are not convex into convex parts; not together with convex_hulls
  MjcfSplit split{};                             ///< of an MJCF
  bool fixed_base = false;           ///< of an MJCF: free joints of robots are left out, their bodies stand where the file has them
  std::vector<MountSpec> mounts{};   ///< in this order; see mount() in mount.hpp
  std::vector<std::string> notes{};  ///< what was taken otherwise than the files beside the robot's own say, one sentence each
  /// What its file says, once the file was read: nothing opens the file again. Of a spec made by hand Model::make() reads it.
  std::shared_ptr<const RobotContents> contents{};

  const std::filesystem::path& file() const { return mjcf.empty() ? urdf : mjcf; }
};

struct FixedSpec {
  std::string name;
  Pose X_WB;
  std::vector<GeometrySpec> geometries;
};

/// Two name patterns "body" or "body/geometry" ('*' matches any run of characters); a robot's name stands for all its links.
struct FilterSpec {
  std::string a, b;
  std::optional<double> max_distance;  ///< [m] pair limit: the pair is looked at only when nearer; nullopt = pair excluded
};

/// Two geometries "body/geometry" whose contacts have a friction of their own (MJCF: <pair>).
struct ContactSpec {
  std::string a, b;
  double friction = 1;                ///< μ ≥ 0
  double torsional = 0, rolling = 0;  ///< [m] ≥ 0; see SurfaceRule
};

/// What there is. Plain data, as written in a scene file; Model is made from it.
struct Scene {
  std::string name;
  std::filesystem::path file;
  Eigen::Vector3d gravity{0, 0, -9.81};  ///< [m/s²], acts on objects only (robots are gravity compensated)
  double contact_distance = 0.025;       ///< pairs farther apart than this are not contacts [m]
  std::optional<int> max_contacts;       ///< keep only the nearest this many
  std::vector<RobotSpec> robots;
  std::vector<ObjectSpec> objects;
  std::vector<FixedSpec> fixed;
  std::vector<FilterSpec> filters;
  std::vector<ContactSpec> contacts{};
  std::vector<double> rest;  ///< of all robots (n_a) [rad or m]: links of one robot that overlap here never touch; empty: neutral()
};

/// Reads a scene file (YAML, strict keys; schema in tasks/schema/scene.schema.json).
/// @throws core::InvalidInput "FILE:LINE: field: got …, expected …"
Scene load_scene(const std::filesystem::path& file);

/// @param package_dirs  where package://PKG/… is looked up after the `package_dirs` of a robot
Scene load_scene(const std::filesystem::path& file, std::span<const std::filesystem::path> package_dirs);

}  // namespace stiction::world
