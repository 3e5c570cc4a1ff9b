#pragma once

#include <Eigen/Core>
#include <array>
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "stiction/world/joint_motor.hpp"
#include "stiction/world/scene.hpp"

namespace stiction::world {

/// Density of robot links whose file states no inertia [kg/m³].
inline constexpr double kLinkDensity = 1000;
/// Limits from here on mean that there is none (159 turns, 1 km): files write 1e4, 1e6, 1e16 or the largest double [rad, m].
inline constexpr double kNoLimit = 1e3;

struct RobotCollision {
  std::string name;  ///< name of the element, or KIND_NUMBER; unique within its link
  Shape shape;
  Pose X_LG;                         ///< pose of the geometry in the link
  std::optional<double> friction{};  ///< μ, if the file states it
  ContactMask mask{};
  std::optional<SurfaceRule> rule{};  ///< set if the file states it
};

/// A file with the triangles of a visual. Only read_visuals() opens it.
struct VisualFile {
  std::filesystem::path file;                       ///< STL, OBJ, DAE, or the MJCF that holds mesh `number`; empty: the text of the robot
  Eigen::Vector3d scale = Eigen::Vector3d::Ones();  ///< scale of a mesh file
  int number = -1;                                  ///< number of the mesh in an MJCF
};

/// A visual of a body in the file of a robot. See visuals.hpp.
struct FileVisual {
  std::string owner;  ///< link or object; empty: fixed in the world
  Pose X_BV{};
  std::variant<Shape, VisualFile> form;
  std::optional<std::array<double, 4>> color{};  ///< red, green, blue, opacity in [0, 1]; nullopt: colour of the mesh file
};

struct RobotLink {
  std::string name;
  std::vector<RobotCollision> collisions;
  std::optional<BodyInertia> inertia;  ///< inertia in the file; nullopt if the file states none or a mass of 0
  bool only_seen = false;              ///< the link has visual geometry and no collision geometry
};

struct RobotJoint {
  enum class Kind {
    Fixed,
    Revolute,
    Prismatic
  };
  std::string name;
  Kind kind = Kind::Fixed;
  int parent = -1, child = -1;                      ///< links
  Pose X_PJ;                                        ///< pose of the joint in the parent link, at joint value 0
  Eigen::Vector3d axis = Eigen::Vector3d::UnitX();  ///< unit, in the child frame
  double lower = 0, upper = 0;                      ///< [rad or m]; infinite for continuous joints
  /// Range of the commands of its servo, where it goes beyond the limits; empty (lower > upper) if the file states none [rad or m].
  double command_lower = std::numeric_limits<double>::infinity(), command_upper = -std::numeric_limits<double>::infinity();
  std::optional<double> stiffness{};  ///< K_a, if the file states it [N/m or N·m/rad]
  int leader = -1;                    ///< index of the joint that it follows, q = ratio·q_leader + offset; −1 = moves by itself
  double ratio = 1, offset = 0;       ///< [-], [rad or m]
  double room = 0;                    ///< deviation from ratio·q_leader + offset that the file allows [rad or m]
  std::optional<double> effort{};     ///< largest force or torque of the motor, if the file states it [N or N·m]

  double speed_limit = std::numeric_limits<double>::infinity();  ///< largest speed, if the file states one [rad/s or m/s]

  double friction = 0, damping = 0;  ///< dry [N or N·m] and viscous [N·s/m or N·m·s/rad] friction in the file
  JointMotor motor{};                ///< in an MJCF
  double spring = 0;                 ///< spring in an MJCF of a joint that no actuator moves [N/m or N·m/rad]

  bool actuated = false;  ///< URDF only: a <transmission> or <ros2_control> names the joint
  bool floating = false;  ///< only in a URDF that is a whole scene: all six directions are free; its kind is Fixed

  bool moves() const { return kind != Kind::Fixed; }
  bool moves_by_itself() const { return moves() && leader < 0; }
};

/// Kinematics, collision geometry and inertia of a robot, as its file states them.
/// Links and joints come depth first, children in the order of the file; link i > 0 is the child of joint i − 1.
struct RobotTree {
  std::string name;
  std::vector<RobotLink> links;
  std::vector<RobotJoint> joints;
  std::vector<std::string> notes;  ///< deviations from the file, one sentence each
  std::vector<FileVisual> visuals{};
  std::vector<std::string> unseen{};  ///< links or geoms whose visuals cannot be read, each with the reason

  std::vector<std::string> movable_joints() const;  ///< names of the joints that move by themselves, in order
};

/// A configuration of the joints and objects of a file: a keyframe, or the pose in which the file is written. Numbers are as in a Model's q.
struct FileConfiguration {
  std::string name;
  std::vector<std::pair<std::string, Eigen::VectorXd>> objects{};
  std::vector<std::pair<std::string, double>> joints{};
  std::vector<std::string> elsewhere{};  ///< bodies that stand still in the model, at another pose than here
};

/// A site or a body of a file, at the pose in which the file is written.
struct FilePlace {
  std::string name;
  Pose X_WF;                ///< pose in the world frame of the file
  std::string moved_by{};   ///< object or robot link that it moves with; empty: it is fixed
  bool with_robot = false;  ///< true if it moves with a robot link
};

/// Contents of the file of a robot. Only an MJCF, or a URDF that is a whole scene, contains more than the robot.
struct RobotContents {
  RobotTree robot;                  ///< for an MJCF: all bodies on hinges and slides and bodies welded to the world; root link "world"
  std::vector<ObjectSpec> objects;  ///< bodies with a free joint
  std::vector<GeometrySpec> fixed;  ///< geometry of the world body, and all planes, in its frame
  std::vector<std::pair<std::string, std::string>> excludes;  ///< names of bodies of the file that never touch each other
  /// Bodies of the file with shapes that belong to objects or to the world, and these shapes: "OBJECT/GEOMETRY" or "world/GEOMETRY".
  std::vector<std::pair<std::string, std::vector<std::string>>> shapes_of{};
  std::vector<ContactSpec> contacts{};  ///< names are "body/geometry"; for the world "world/geometry"
  std::string sha256;                   ///< hash of the file or text, and of mounted files
  FileConfiguration as_written{};       ///< pose in which an MJCF is written
  std::vector<FileConfiguration> keyframes{};
  std::vector<FilePlace> places{};
  Eigen::Vector3d gravity{0, 0, -9.81};  ///< gravity of an MJCF [m/s²]
  RobotSpec spec;                        ///< the robot that the file was read for
};

/// Inertia of the link's collision geometry at kLinkDensity (overlaps count twice); 0 without collision geometry.
BodyInertia calc_inertia(const RobotLink& link);

/// Bound, over all joint angles, on the distance from the axis of a link's joint to the geometry that the joint moves [m]; 1 without geometry.
double calc_reach(const RobotTree& tree, std::size_t link);

/// Default K_a of the joint that moves a link, if neither scene nor file states one. The joint reaches its effort at 1/40 of its range (one turn if
/// it has no limits). Without an effort, its motor is assumed to lift twice the mass that hangs on the joint, at the joint's reach.
double calc_default_stiffness(const RobotTree& tree, std::size_t link);

/// Velocity index of each joint, counted from v_begin; a follower has the index of its leader, and a fixed joint has −1.
std::vector<int> number_joints(const RobotTree& tree, int v_begin);

/// Velocity indices of the joints of each branch, a run of joints without branching. Outer branches come first.
std::vector<std::vector<int>> calc_chains(const RobotTree& tree, int v_begin);

/// Makes limits of 1000 rad or m and more infinite, since files write them to mean no limit. A note names their joints.
void release_placeholder_limits(RobotTree& tree);

/// Simplifies followers. A leader that follows another joint is replaced by that joint. Limits, friction, armature and speed limits of followers count
/// for their leaders. A joint whose limits are one point becomes fixed, and its followers too. @throws core::InvalidInput: a joint that follows itself
void resolve_followers(RobotTree& tree);

/// "a, b, c and 4 more".
std::string list_some(std::span<const std::string> names);

/// Name in messages of a URDF or MJCF that is a text and not a file: "text:LINE: …".
inline constexpr const char* kTextName = "text";

/// Contents of the URDF or MJCF file or text of a robot. They are taken from `robot.contents` if these were read for the same keys of the robot; else
/// the file is read now. @throws core::InvalidInput
std::shared_ptr<const RobotContents> contents_of(const RobotSpec& robot);

}  // namespace stiction::world
