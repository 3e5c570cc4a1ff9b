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
  std::string source;  ///< file of the mesh; empty for a mesh made in memory
  std::shared_ptr<const Eigen::Matrix3Xd>
      surface{};  ///< triangle corners (3 × 3n) of that whole file, all parts together, if it is a mesh file
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

/// Two geometries of one MJCF may touch if the `type` of one and the `affinity` of the other have a bit in common. Geometries of different files
/// may touch, unless both have neither a type nor an affinity.
struct ContactMask {
  std::uint32_t type = ~0u, affinity = ~0u;
  std::string file{};  ///< robot of the scene whose MJCF states them, '/', and the file mounted on it; empty: of no MJCF
};

/// Friction moments of a surface and its priority in a contact, as in MuJoCo's `condim`, `friction` and `priority`. Only simulations use the
/// moment against rolling.
struct SurfaceRule {
  int dimension = 3;     ///< 1: a contact has no friction; 3: it resists sliding; 4: also turning about the normal; 6: also rolling
  double torsional = 0;  ///< largest moment about the normal, divided by the normal force [m], ≥ 0
  double rolling = 0;    ///< largest moment about the tangents, divided by the normal force [m], ≥ 0
  int priority = 0;      ///< if the priorities of two surfaces differ, only the numbers of the higher one count
};

struct GeometrySpec {
  std::string name;  ///< unique within its body
  Shape shape;
  Pose X_BG;              ///< pose of the geometry in the body
  double friction = 1.0;  ///< μ of the surface, ≥ 0
  ContactMask mask{};
  double max_force =
      std::numeric_limits<double>::infinity();  ///< largest normal force that the geometry bears from one other geometry [N], > 0
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
  std::string parent{};  ///< earlier object on which this one is mounted by a hinge or slider; empty: the world
  ObjectJoint joint = ObjectJoint::Free;
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();  ///< axis of a hinge or slider, in the placed frame
  Pose X_WP;  ///< placed frame P, in the parent's body frame if there is a parent; identity for free objects. At q = 0 the body frame is P
  double mass = 0;  ///< [kg] > 0
  Eigen::Vector3d p_BCom = Eigen::Vector3d::Zero();
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();  ///< about the centre of mass, body axes [kg m²]
  double weight_share = 1;                            ///< share of its weight that acts; the rest is compensated (MJCF: gravcomp)
  std::optional<std::array<double, 2>> limits;        ///< hinge or slider range [rad or m]
  double joint_friction = 0;                          ///< dry friction of a hinge or slider, ≥ 0 [N·m or N]
  /// Viscous friction of every coordinate, ≥ 0 [N·s/m and N·m·s/rad]. Moments on a free object oppose its angular velocity by the same number, as
  /// in MuJoCo. Only simulations use it.
  double joint_damping = 0;
  double joint_stiffness = 0;  ///< stiffness of a spring on a hinge or slider, ≥ 0 [N·m/rad or N/m]
  double joint_rest = 0;       ///< rest position of that spring [rad or m]
  std::vector<GeometrySpec> geometries;
};

/// Settings for splitting a non-convex mesh into convex parts when it is loaded.
struct Decomposition {
  static constexpr double kMinThreshold = 0.01;
  double threshold =
      0.05;            ///< allowed deviation of a part from convex, in units of half the longest edge of the mesh's bounding box, 0.01 to 1
  int max_parts = 16;  ///< largest number of parts per solid of the file; further parts are merged, whatever the threshold
};

/// Says which bodies of an MJCF belong to robots and which are objects.
struct MjcfSplit {
  /// true: trees with an actuator are robots, and moving bodies of other trees are objects. false: only free bodies are objects.
  bool by_actuators = false;
  std::vector<std::string> robot{};                   ///< bodies whose trees are robots although no actuator moves them
  std::optional<std::vector<std::string>> objects{};  ///< the complete list of bodies that are objects; nullopt: the rule decides

  bool operator==(const MjcfSplit&) const = default;
};

/// A file whose robot is mounted on a link of another robot.
struct MountSpec {
  std::string name{};          ///< prefix of its link and joint names, followed by '_'; empty: the names stay unchanged
  std::filesystem::path file;  ///< URDF or MJCF
  std::string on;              ///< link of the robot, or of a file mounted earlier
  Pose X_LM{};                 ///< pose of the file's root link in that link
};

struct RobotContents;  // robot_tree.hpp

struct RobotSpec {
  std::string name;
  std::filesystem::path urdf;                       ///< resolved file; with `text`, the folder for its relative paths, ending in '/'
  std::filesystem::path mjcf;                       ///< instead of `urdf`; see add_mjcf in mjcf.hpp
  std::string text{};                               ///< the URDF or MJCF itself, if there is no file
  std::vector<std::filesystem::path> package_dirs;  ///< folders in which package:// is looked up
  Pose X_WBase;
  std::vector<std::pair<std::string, double>>
      stiffness;  ///< joint → K_a [N/m or N·m/rad]; overrides the file. A joint without a stiffness reaches its effort at 1/40 of its range
  /// joint → largest force or torque of its motor [N or N·m], > 0, infinite for no limit; overrides the file
  std::vector<std::pair<std::string, double>> effort{};
  double friction = 1.0;  ///< μ of every collision geometry without an entry of its own
  SurfaceRule rule{};     ///< rule of every collision geometry for which the file states none
  std::vector<std::pair<std::string, double>> link_friction;
  bool convex_hulls = false;             ///< true: each mesh becomes one hull, without a note; false: NonConvex::TakeHulls applies
  std::vector<std::string> push_with{};  ///< only these links may touch objects ('*' matches any run of characters); empty: all links
  std::optional<Decomposition> decomposition{};  ///< settings for splitting non-convex meshes into convex parts; excludes convex_hulls
  MjcfSplit split{};                             ///< robots and objects of the file, if it is an MJCF
  bool fixed_base = false;           ///< MJCF only: free joints of robots are left out, and their bodies stay at the pose in the file
  std::vector<MountSpec> mounts{};   ///< in this order; see mount() in mount.hpp
  std::vector<std::string> notes{};  ///< deviations from the files other than the robot's own, one sentence each
  /// Contents of the robot's file after it was read; the file is not opened again. For a spec made by hand, Model::make() reads the file.
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
  std::optional<double> max_distance;  ///< the pair is checked for contact only below this distance [m]; nullopt = pair excluded
};

/// Two given geometries "body/geometry" that may touch, whatever their masks are, and their friction (MJCF: <pair>).
struct ContactSpec {
  std::string a, b;
  double friction = 1;                ///< μ ≥ 0
  double torsional = 0, rolling = 0;  ///< [m] ≥ 0; see SurfaceRule
};

/// Robots, objects and fixed bodies of a scene, as plain data of a scene file. Model::make() builds a Model from it.
struct Scene {
  std::string name;
  std::filesystem::path file;
  Eigen::Vector3d gravity{0, 0, -9.81};  ///< [m/s²], acts on objects only (robots are gravity compensated)
  double contact_distance = 0.025;       ///< pairs farther apart than this are not contacts [m]
  std::optional<int> max_contacts;       ///< only this many nearest contacts are kept; nullopt: all
  std::vector<RobotSpec> robots;
  std::vector<ObjectSpec> objects;
  std::vector<FixedSpec> fixed;
  std::vector<FilterSpec> filters;
  std::vector<ContactSpec> contacts{};
  std::vector<double>
      rest;  ///< rest posture of all robots (n_a) [rad or m]. Links of one robot that overlap in it form no pair; empty: neutral()
};

/// Reads a scene file (YAML, strict keys; schema in tasks/schema/scene.schema.json).
/// @throws core::InvalidInput "FILE:LINE: field: got …, expected …"
Scene load_scene(const std::filesystem::path& file);

/// The same. @param package_dirs  folders in which package://PKG/… is looked up, after the `package_dirs` of a robot
Scene load_scene(const std::filesystem::path& file, std::span<const std::filesystem::path> package_dirs);

}  // namespace stiction::world
