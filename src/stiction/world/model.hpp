#pragma once

#include <Eigen/Core>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "stiction/world/scene.hpp"

namespace stiction::world {

using VectorRef = Eigen::Ref<const Eigen::VectorXd>;

class Scales;

enum class BodyKind {
  Fixed,
  Object,
  Robot
};

struct Body {
  std::string name;  ///< "robot/link", "object", "fixed"; unique
  BodyKind kind = BodyKind::Fixed;
  int owner = -1;         ///< index of the object or robot that the body belongs to
  std::vector<int> dofs;  ///< velocity indices that move the body, ascending
  std::vector<int> axes;  ///< columns of Kinematics that move the body, from the root; equal to `dofs` if no joint follows another
};

struct Geometry {
  std::string name;  ///< "body/geometry"
  int body = -1;
  Shape shape;
  Pose X_BG;
  double friction = 1.0;
  Eigen::Vector3d p_BCenter = Eigen::Vector3d::Zero();         ///< centre of the bounding sphere in its body
  double bounding_radius = 0;                                  ///< [m]; infinite for a half-space
  double max_force = std::numeric_limits<double>::infinity();  ///< largest normal force that the geometry bears from one other geometry [N]
  SurfaceRule rule{};
};

/// Two geometries that may touch. Any two geometries of different bodies form a pair, unless neither moves, they are welded together, a joint
/// of a robot links their (welded) bodies, or a filter excludes the pair. Pairs are in the order of their geometries: objects, robots, fixed.
/// v_c is the velocity of side A relative to side B. An object comes before a robot, and a robot before a fixed body, as side A.
struct Pair {
  int geometry_a = -1;
  int geometry_b = -1;
  double friction = 0;      ///< μ = 2 μ_a μ_b / (μ_a + μ_b), unless priorities or a ContactSpec say otherwise
  double max_distance = 0;  ///< [m]
  int support = -1;         ///< index into Model::supports()
  /// Largest sum of the normal forces of its contacts [N]: the limit of the weaker side; infinite if neither side has a limit.
  double max_force = std::numeric_limits<double>::infinity();
  /// Largest moments about the normal and about the tangents, divided by the normal force [m]; 0 if contacts do not resist them. Steps and
  /// simulations use the first one, and only simulations the second one.
  double torsional = 0, rolling = 0;
};

enum class DofKind {
  Prismatic,
  Revolute
};

/// One velocity coordinate. Names: "object/x", "y", "z", "rx", "ry", "rz", "theta" (planar), "angle" (hinge), "position" (slider);
/// "robot/joint", in the order of the URDF, depth first.
struct Dof {
  std::string name;
  DofKind kind = DofKind::Revolute;
  BodyKind owner_kind = BodyKind::Object;
  int owner = -1;                                           ///< object or robot index
  double lower = 0, upper = 0;                              ///< joint limits [rad or m]; infinite without a limit
  double command_lower = 0, command_upper = 0;              ///< range of commands of a robot joint; see Model::command_lower()
  double stiffness = 0;                                     ///< K_a of a robot joint [N/m or N·m/rad], 0 for objects
  double effort = std::numeric_limits<double>::infinity();  ///< τ_max of a robot joint's motor [N or N·m]; infinite without a limit
  double speed_limit =
      std::numeric_limits<double>::infinity();  ///< largest speed of a robot joint [m/s or rad/s]; see Model::speed_limit()
  /// Dry friction τ_f [N or N·m] of a hinge, a slider, or a robot joint, and viscous damping [N·s/m or N·m·s/rad]. A step uses
  /// the dry friction of objects (S.19); simulations also use the damping. Servos of robot joints compensate the dry friction, as they do the
  /// robot's weight, and the damping up to the speed that they ask for (M.5).
  double friction = 0, damping = 0;
  double spring = 0, spring_rest = 0;  ///< spring of an object's joint: τ = spring·(spring_rest − q); see ObjectSpec::joint_stiffness
};

/// A joint that follows another joint, its leader: q = ratio·q_leader + offset. Follower i turns about or slides along its own axis, column
/// n_v + i of Kinematics. The velocity of a body per unit of the leader's coordinate is the sum, over all axes that move the body, of `ratio` times
/// the motion about that axis.
struct Follower {
  std::string name;  ///< "robot/joint"
  DofKind kind = DofKind::Revolute;
  int dof = -1;  ///< velocity index of its leader
  double ratio = 1, offset = 0;
};

/// The joint between a robot link and its parent: X_PB(q) = X_PJ · rot(axis, q), X_PJ · trans(q · axis), or X_PJ if the link is welded.
struct Link {
  int body = -1;
  int parent = -1;    ///< parent body; −1 = the world, for the root link of a robot
  int dof = -1;       ///< velocity index of its joint, or of the leader if the joint is a follower; −1 = welded
  int follower = -1;  ///< index into Model::followers()
  Pose X_PJ;          ///< joint frame in the parent
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();  ///< unit, in the joint frame (and in the link's)
};

struct ObjectInfo {
  std::string name;
  int body = -1;
  int v_begin = 0, n_v = 0;  ///< velocity coordinates [v_begin, v_begin + n_v)
  int q_begin = 0, n_q = 0;
  double mass = 0;
  int parent = -1;          ///< earlier object that it hangs on
  double carried_mass = 0;  ///< mass of the object and of all objects that hang on it [kg]
};

struct RobotInfo {
  std::string name;
  int v_begin = 0, n_v = 0;  ///< its commands are u[v_begin − n_vu, …)
  int q_begin = 0;
  std::vector<std::vector<int>> chains;  ///< velocity indices grouped by branch (trunk, finger, …), in elimination order
};

/// Immutable kinematics, actuation, geometry and friction of a scene, shared by threads.
///
/// q = (objects, robots) with n_q numbers; velocities and increments have n_v = n_vu + n_a, objects first. Robot joints have one
/// coordinate each, so that u and qᵃ have n_a numbers in the same order. A free object has q = (x, y, z, qx, qy, qz, qw) and the
/// increment (displacement of the body origin in W [m]; rotation vector in body axes [rad]): R⁺ = R exp(δθ_B).
class Model {
 public:
  /// @throws core::InvalidInput naming file, field, given and expected
  static std::shared_ptr<const Model> make(const Scene& scene);
  ~Model();
  Model(const Model&) = delete;
  Model& operator=(const Model&) = delete;

  const Scene& scene() const;
  int n_q() const;
  int n_v() const;
  int n_vu() const;  ///< velocity coordinates of the objects
  int n_qu() const;  ///< configuration numbers of the objects
  int n_a() const;   ///< actuated joints = length of u

  std::span<const Body> bodies() const;
  std::span<const Geometry> geometries() const;
  std::span<const Pair> pairs() const;
  std::span<const Dof> dofs() const;
  std::span<const Follower> followers() const;
  std::span<const ObjectInfo> objects() const;
  std::span<const RobotInfo> robots() const;
  std::span<const Link> links() const;  ///< of all robots, parents first

  /// Deviations of the model from the scene's files, and values chosen because the files state none: one sentence each, starting with the
  /// name of the robot or object.
  std::span<const std::string> notes() const;

  /// Inertia per body. A robot link has the inertia in its file, else that of its collision geometry at 1000 kg/m³ (overlaps count twice),
  /// else 0. A fixed body has 0. The quasi-static step does not use the inertias of robots.
  std::span<const BodyInertia> inertias() const;

  /// Distinct sets of velocity coordinates that pairs touch (union of the two bodies' dofs, ascending).
  const std::vector<std::vector<int>>& supports() const;

  /// Axis (0, 1, 2) normal to the plane in which all bodies move, if there is such a plane; friction is then planar.
  std::optional<int> planar_axis() const;

  const Eigen::VectorXd& stiffness() const;  ///< K_a (n_a) [N/m or N·m/rad]
  const Eigen::VectorXd& effort()
      const;  ///< τ_max (n_a), the largest force or torque of a joint's motor [N or N·m]; infinite without a limit
  /// Largest speeds of the robots' joints (n_a) [rad/s or m/s], > 0, from `velocity` in the URDF; the limits of followers count as well. Infinite
  /// if the file states none, or 0. An MJCF never states one.
  const Eigen::VectorXd& speed_limit() const;
  const Eigen::VectorXd& lower() const;  ///< joint limits of the robots (n_a)
  const Eigen::VectorXd& upper() const;
  /// Range of the commands u (n_a) [rad or m]. It contains the joint limits, and goes beyond them as far as `ctrlrange` of a position servo in an
  /// MJCF does: with such commands a gripper presses harder than its travel allows.
  const Eigen::VectorXd& command_lower() const;
  const Eigen::VectorXd& command_upper() const;

  /// Bound over all joint angles on the distance from a joint axis to the farthest point of the geometry it moves, per robot joint
  /// (n_a) [m]; 1 for a prismatic joint.
  /// It converts between forces [N] and joint torques [N·m].
  const Eigen::VectorXd& reach() const;

  const Scales& scales() const;  ///< lengths and forces of objects and robots, from which all thresholds derive

  /// Configuration with every object at its placed frame and every joint at the value nearest to 0 inside its limits.
  Eigen::VectorXd neutral() const;

  /// Index of a robot joint in u; index of an object. @throws core::InvalidInput with the list of known names
  int joint_index(std::string_view name) const;  ///< "robot/joint", or "joint" where unique
  int object_index(std::string_view name) const;

  struct Impl;
  const Impl& impl() const { return *impl_; }

 private:
  explicit Model(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

/// Poses and joint axes at one configuration. Every coordinate of v moves its bodies about or along an axis through a point. A revolute
/// column of a point Jacobian is axis × (p − origin), and a prismatic column is axis. A free object has three columns of each kind.
struct Kinematics {
  std::vector<Pose> X_WB;     ///< per body
  Eigen::Matrix3Xd axis_W;    ///< (3 × n_v + number of followers) unit axes
  Eigen::Matrix3Xd origin_W;  ///< (3 × n_v + number of followers) a point on the axis [m]
};

/// Scratch memory of calc_kinematics(); one per thread.
class KinematicsWorkspace {
 public:
  explicit KinematicsWorkspace(const Model& model);
  ~KinematicsWorkspace();
  KinematicsWorkspace(KinematicsWorkspace&&) noexcept;
  struct Impl;
  Impl& impl() { return *impl_; }

 private:
  std::unique_ptr<Impl> impl_;
};

/// Poses of all bodies and axes of all coordinates at q (n_q). No heap use after the first call.
void calc_kinematics(const Model& model, VectorRef q, KinematicsWorkspace& work, Kinematics& out);

/// Computes the generalised mass matrix of object i with all objects that hang on it (n_v,i × n_v,i, tangent coordinates) [kg, kg m²]: its block
/// on the diagonal of M_u. The step's ε M_u has no blocks off the diagonal, which would couple an object with the objects that hang on it.
void calc_object_mass(const Model& model, const Kinematics& kinematics, int object, Eigen::Ref<Eigen::MatrixXd> M_u);

/// Computes the diagonal of the mass matrix of the robots (n_a) [kg m²; kg for prismatic joints]: for each joint, the inertia of all links that
/// it moves, about its axis.
Eigen::VectorXd calc_joint_inertia(const Model& model, const Kinematics& kinematics);
/// Computes the largest such inertia of each joint over random postures within the joint limits (n_a). The posture matters: about the vertical
/// base axis, an arm that reaches out has a hundred times the inertia of the same arm standing upright.
Eigen::VectorXd calc_largest_joint_inertia(const Model& model);

/// Generalised force of gravity on the objects τᵘ (n_vu) [N, N·m].
void calc_gravity(const Model& model, const Kinematics& kinematics, Eigen::Ref<Eigen::VectorXd> tau_u);

/// Computes q ⊕ δ, the only way to change a configuration. @param delta (n_v) [m, rad]  @param out (n_q), may be q itself
void retract(const Model& model, VectorRef q, VectorRef delta, Eigen::Ref<Eigen::VectorXd> out);

/// Computes q1 ⊖ q0 (n_v): retract(q0, local(q0, q1)) = q1 up to the sign of a quaternion; rotation vectors have length ≤ π.
/// Unlimited single revolute coordinates (planar angle, hinge) are plain differences, not wrapped.
void local(const Model& model, VectorRef q0, VectorRef q1, Eigen::Ref<Eigen::VectorXd> out);

/// Pose X_WB of object i at q, for every kind of object joint.
Pose object_pose(const Model& model, VectorRef q, int object);

/// Checks a configuration. @throws core::InvalidInput: wrong size, not finite, quaternion not unit to 1e-6
void require_configuration(const Model& model, std::string_view field, VectorRef q);

/// The robot part qᵃ of q: its last n_a numbers.
inline auto robot_part(const Model& model, const Eigen::VectorXd& q) { return q.tail(model.n_a()); }

}  // namespace stiction::world
