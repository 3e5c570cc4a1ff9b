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

#include "stiction/world/scene.hpp"

namespace stiction::world {

/// Density of robot links whose file states no inertia [kg/m³].
inline constexpr double kLinkDensity = 1000;

struct RobotCollision {
  std::string name;  ///< of the element, or KIND_NUMBER; unique within its link
  Shape shape;
  Pose X_LG;                         ///< geometry in link
  std::optional<double> friction{};  ///< μ, where the file states it
  ContactMask mask{};
  std::optional<SurfaceRule> rule{};  ///< where the file states it
};

/// A file with triangles that are looked at. Nothing opens it before read_visuals() does.
struct VisualFile {
  std::filesystem::path file;                       ///< STL, OBJ, DAE, or the MJCF that holds mesh `number`; empty: the text of the robot
  Eigen::Vector3d scale = Eigen::Vector3d::Ones();  ///< of a mesh file
  int number = -1;                                  ///< of a mesh of an MJCF
};

/// What the file of a robot shows of a body. See visuals.hpp.
struct FileVisual {
  std::string owner;  ///< link or object; empty: it stands still in the world
  Pose X_BV{};
  std::variant<Shape, VisualFile> form;
  std::optional<std::array<double, 4>> color{};  ///< red, green, blue, opacity in [0, 1]; nullopt: that of the mesh file
};

struct RobotLink {
  std::string name;
  std::vector<RobotCollision> collisions;
  std::optional<BodyInertia> inertia;  ///< as the file states it; nullopt where it states none or a mass of 0
  bool only_seen = false;              ///< the file has geometry to be seen for it, and none that collides
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
  Pose X_PJ;                                        ///< joint in parent link at zero
  Eigen::Vector3d axis = Eigen::Vector3d::UnitX();  ///< unit, in the child frame
  double lower = 0, upper = 0;                      ///< [rad or m]; infinite for continuous joints
  std::optional<double> stiffness{};                ///< K_a, where the file states it [N/m or N·m/rad]
  int leader = -1;                                  ///< joint (index) that it follows, q = ratio·q_leader + offset; −1 = moves by itself
  double ratio = 1, offset = 0;                     ///< [-], [rad or m]
  double room = 0;                                  ///< how far the file lets it be from where its leader takes it [rad or m]
  std::optional<double> effort{};                   ///< largest force or torque of the motor, where the file states it [N or N·m]

  double speed_limit = std::numeric_limits<double>::infinity();  ///< largest speed, where the file states one [rad/s or m/s]

  double friction = 0, damping = 0;  ///< dry [N or N·m] and viscous [N·s/m or N·m·s/rad], as the file states them

  bool actuated = false;  ///< of a URDF: a <transmission> or <ros2_control> names it
  bool floating = false;  ///< of a URDF that is a whole scene: all six directions are free; its kind is Fixed

  bool moves() const { return kind != Kind::Fixed; }
  bool moves_by_itself() const { return moves() && leader < 0; }
};

/// What a robot file says about kinematics, collision geometry and inertia.
/// Links and joints come depth first, children in the order of the file: link i > 0 is the child of joint i − 1.
struct RobotTree {
  std::string name;
  std::vector<RobotLink> links;
  std::vector<RobotJoint> joints;
  std::vector<std::string> notes;  ///< what was taken otherwise than it is written, one sentence each
  std::vector<FileVisual> visuals{};
  std::vector<std::string> unseen{};  ///< links or geoms whose pictures cannot be read, each with the reason

  std::vector<std::string> movable_joints() const;  ///< names of those that move by themselves, in order
};

/// Where the joints and objects of a file are: a keyframe, or the pose that the file is written in. Numbers are as in a Model's q.
struct FileConfiguration {
  std::string name;
  std::vector<std::pair<std::string, Eigen::VectorXd>> objects{};
  std::vector<std::pair<std::string, double>> joints{};
};

/// A site or a body of a file, in the pose that the file is written in.
struct FilePlace {
  std::string name;
  Pose X_WF;                ///< in the frame of the file's world
  std::string moved_by{};   ///< the object, or the link of the robot, that it moves with; empty: it stands still
  bool with_robot = false;  ///< a link moves it
};

/// All that the file of a robot brings. Only an MJCF, or a URDF that is a whole scene, brings more than the robot.
struct RobotContents {
  RobotTree robot;                  ///< of an MJCF everything on hinges and slides and what is welded to the world; root link "world"
  std::vector<ObjectSpec> objects;  ///< bodies with a free joint
  std::vector<GeometrySpec> fixed;  ///< geometry of the world body, and all planes, in its frame
  std::vector<std::pair<std::string, std::string>> excludes;  ///< names of bodies that never touch each other
  std::vector<ContactSpec> contacts{};                        ///< names "body/geometry"; of the world "world/geometry"
  std::string sha256;                                         ///< of the file, or of the text, and of what is mounted
  FileConfiguration as_written{};                             ///< of an MJCF
  std::vector<FileConfiguration> keyframes{};
  std::vector<FilePlace> places{};
  Eigen::Vector3d gravity{0, 0, -9.81};  ///< of an MJCF [m/s²]
  RobotSpec spec;                        ///< the robot that the file was read for
};

/// Of the collision geometry at kLinkDensity, overlaps twice; 0 without.
BodyInertia calc_inertia(const RobotLink& link);

/// Bound over all joint angles on the distance from the axis of the joint that moves a link to the geometry that it moves [m]; 1 without any.
double calc_reach(const RobotTree& tree, std::size_t link);

/// K_a of the joint that moves a link, where nobody states one: it bears its effort at 1/40 of its range (a turn where there is none).
/// A motor without effort lifts twice what hangs on it at its reach.
double calc_default_stiffness(const RobotTree& tree, std::size_t link);

/// Velocity index of each joint that moves by itself, counted from v_begin; of a follower that of its leader; −1 of fixed ones.
std::vector<int> number_joints(const RobotTree& tree, int v_begin);

/// Velocity indices of runs of joints without a branch between them; those farther out come first.
std::vector<std::vector<int>> calc_chains(const RobotTree& tree, int v_begin);

/// Limits of 1000 rad or m and more stand for none: they become infinite, and a note names their joints.
void release_placeholder_limits(RobotTree& tree);

/// Leaders that follow others are replaced by those; limits of followers become limits of their leaders; joints whose limits are one point
/// become fixed, and what follows them; friction and speed limits of followers become those of their leaders. @throws core::InvalidInput: a joint that follows itself
void resolve_followers(RobotTree& tree);

/// "a, b, c and 4 more".
std::string list_some(std::span<const std::string> names);

/// What messages call the URDF or MJCF of a robot that is no file: "text:LINE: …".
inline constexpr const char* kTextName = "text";

/// What the file or the text of a robot says, URDF or MJCF: as it was read before, where it was read for the same keys of the robot; else it
/// is read now. @throws core::InvalidInput
std::shared_ptr<const RobotContents> contents_of(const RobotSpec& robot);

}  // namespace stiction::world
