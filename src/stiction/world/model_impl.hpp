#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "stiction/world/model.hpp"
#include "stiction/world/scales.hpp"

namespace stiction::world {

/// An object as calc_kinematics sees it.
struct ObjectNode {
  ObjectJoint joint = ObjectJoint::Free;
  int body = 0, q = 0, v = 0, n_v = 0;
  int parent = -1;                                    ///< object that it hangs on
  Pose X_WP;                                          ///< in the parent's body
  Eigen::Vector3d axis_P = Eigen::Vector3d::UnitZ();  ///< hinge or slider
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
  int q = 0, v = 0;              ///< of a follower its leader's
  int axis = 0;                  ///< column of Kinematics; v, or n_v + i of follower i
  double ratio = 1, offset = 0;  ///< of a follower
  Eigen::Matrix3d C0, C1, C2;    ///< of a welded or sliding link only C0 = R_PJ
  Eigen::Vector3d p_PJ;
  Eigen::Vector3d axis_P;  ///< in the parent link
};

struct Model::Impl {
  Scene scene;
  int n_q = 0, n_v = 0, n_vu = 0, n_qu = 0, n_a = 0;
  std::vector<Body> bodies;
  std::vector<Geometry> geometries;
  std::vector<Pair> pairs;
  std::vector<Dof> dofs;
  std::vector<Follower> followers;
  std::vector<ObjectInfo> objects;
  std::vector<RobotInfo> robots;
  std::vector<Link> links;
  std::vector<std::string> notes;
  std::vector<BodyInertia> inertias;  ///< per body
  std::vector<std::vector<int>> supports;
  std::optional<int> planar_axis;
  Eigen::VectorXd stiffness, effort, speed_limit, lower, upper, reach, neutral;
  std::optional<Scales> scales;  ///< of the finished model

  std::vector<ObjectNode> object_nodes;
  std::vector<LinkNode> link_nodes;                  ///< parents first
  std::vector<std::pair<int, Pose>> constant_poses;  ///< bodies that never move
};

void calc_kinematics(const Model::Impl& m, const VectorRef& q, Kinematics& out);

/// Pose of a link and axis of its joint, from those of its parent.
void place_link(const LinkNode& node, const VectorRef& q, Kinematics& out);

}  // namespace stiction::world
