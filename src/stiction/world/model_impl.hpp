#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "stiction/world/joint_motor.hpp"
#include "stiction/world/model.hpp"
#include "stiction/world/scales.hpp"

namespace stiction::world {

/// An object as calc_kinematics sees it.
struct ObjectNode {
  ObjectJoint joint = ObjectJoint::Free;
  int body = 0, q = 0, v = 0, n_v = 0;
  int parent = -1;                                    ///< index of the object that it hangs on
  Pose X_WP;                                          ///< placed frame, in the parent's body frame
  Eigen::Vector3d axis_P = Eigen::Vector3d::UnitZ();  ///< axis of a hinge or slider
  int first = 0, second = 1, normal = 2;              ///< axes of P that a planar object slides along and turns about
  double mass = 0;
  double weight_share = 1;
  std::vector<int> carried{};  ///< objects that this one moves: itself and those that hang on it
  Eigen::Vector3d p_BCom = Eigen::Vector3d::Zero();
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();
};

/// A robot link that moves: X_WB = X_WP X_PJ T(q). With a the joint axis, R_PJ exp(q â) = C0 + cos q C1 + sin q C2.
struct LinkNode {
  enum class Kind {
    Welded,
    Revolute,
    Prismatic
  };
  Kind kind = Kind::Welded;
  int body = 0, parent = 0;
  int q = 0, v = 0;              ///< indices in q and v; for a follower those of its leader
  int axis = 0;                  ///< column of Kinematics; v, or n_v + i of follower i
  double ratio = 1, offset = 0;  ///< see Follower
  Eigen::Matrix3d C0, C1, C2;    ///< a welded or sliding link has only C0 = R_PJ
  Eigen::Vector3d p_PJ;
  Eigen::Vector3d axis_P;  ///< joint axis in the parent link
};

struct Model::Impl {
  Scene scene;
  int n_q = 0, n_v = 0, n_vu = 0, n_qu = 0, n_a = 0;
  std::vector<Body> bodies;
  std::vector<Geometry> geometries;
  std::vector<Pair> pairs;
  std::vector<Dof> dofs;
  std::vector<JointMotor> motors;  ///< per robot joint
  std::vector<Follower> followers;
  std::vector<ObjectInfo> objects;
  std::vector<RobotInfo> robots;
  std::vector<Link> links;
  std::vector<std::string> notes;
  std::vector<BodyInertia> inertias;  ///< per body
  std::vector<std::vector<int>> supports;
  std::optional<int> planar_axis;
  Eigen::VectorXd stiffness, effort, speed_limit, lower, upper, command_lower, command_upper, reach, neutral;
  std::optional<Scales> scales;  ///< set when the rest of the model is complete

  std::vector<ObjectNode> object_nodes;
  std::vector<LinkNode> link_nodes;                  ///< parents first
  std::vector<std::pair<int, Pose>> constant_poses;  ///< bodies that never move
};

void calc_kinematics(const Model::Impl& m, const VectorRef& q, Kinematics& out);

/// Computes the pose of a link and the axis of its joint from the pose of its parent.
void place_link(const LinkNode& node, const VectorRef& q, Kinematics& out);

}  // namespace stiction::world
