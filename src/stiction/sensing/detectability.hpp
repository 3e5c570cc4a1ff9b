#pragma once

#include "stiction/sensing/sensor.hpp"

namespace stiction::sensing {

/// The joint whose torque sensor a contact on a link is judged by: the last one before it, in the link's frame L.
struct JointLine {
  Eigen::Vector3d axis_L = Eigen::Vector3d::UnitZ();   ///< unit
  Eigen::Vector3d origin_L = Eigen::Vector3d::Zero();  ///< a point on it [m]
  bool prismatic = false;
  int joint = -1;  ///< index into u; for a follower that of the joint that it follows

  /// The direction m with τ = m·f for a force f at p: e × (p − o) [m], or e of a prismatic joint [-].
  Eigen::Vector3d lever(const Eigen::Vector3d& p_L) const { return prismatic ? axis_L : axis_L.cross(p_L - origin_L).eval(); }
};

/// @throws core::InvalidInput: a body that no joint of a robot moves
JointLine find_joint_line(const world::Model& model, int body);

enum class Detectability {
  Undetectable,  ///< no force in the cone causes a torque
  Partial,       ///< some forces in the cone cause a torque
  Full           ///< every nonzero force in the cone causes a torque
};

/// Classifies a contact as in section 4.4.1, without the linear program (4.7): the torque m·f has one sign on the cone. Polyhedral: all
/// m·v_i ≠ 0 have one sign; exact: |m·k|/‖m‖ > μ/√(1 + μ²).  (Y.5)
Detectability classify(const Eigen::Vector3d& lever, const Eigen::Matrix3d& R_LC, const FrictionCone& cone);

/// η_ε (4.8): share of the unit forces of the exact cone whose torque is at most ε in size, in [0, 1]. The cone cuts a cap from the unit
/// sphere and |m·f| ≤ ε a band between two caps, so that it is a difference of two intersections of caps, which have closed areas. (Y.6)
/// With μ = 0 the cap is a point: 0 or 1.
/// @param epsilon  torque of a unit force [N·m/N], > 0
double calc_undetectability(const Eigen::Vector3d& lever, const Eigen::Vector3d& inward_normal, double friction, double epsilon);

/// Area of the intersection of two caps of the unit sphere. @param a, b  their half angles, in [0, π]  @param d  angle between their axes
double calc_cap_intersection(double a, double b, double d);

/// Result of calc_detectability(): detectability and η_ε at every sample of a link. @param full  number of fully detectable samples
struct DetectabilityMap {
  std::vector<Detectability> kinds;
  Eigen::VectorXd eta;
  int full = 0;
};
DetectabilityMap calc_detectability(const world::Model& model, const SensedLink& link, const FrictionCone& cone, double epsilon);

}  // namespace stiction::sensing
