#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "stiction/core/random.hpp"
#include "stiction/world/model.hpp"

namespace stiction::world {

/// Box from which configurations are drawn: per object position [m] and rotation [rad] relative to the world, or coordinates for
/// planar, hinged and sliding objects.
struct SampleBox {
  int object = 0;
  Eigen::VectorXd lower, upper;  ///< free object: x y z roll pitch yaw; others: their coordinates
};

/// The configurations qᵘ of the objects as a space to measure and sample in.
class ObjectSpace {
 public:
  explicit ObjectSpace(const Model& model);

  int n_q() const { return n_q_; }
  int n_v() const { return n_v_; }

  /// e = to ⊖ from in the tangent of the objects, e of (3.5); the angle of a planar object is wrapped to (−π, π];
  /// rotation vectors are right to 4e-8 of their length.
  /// @param from, to  at least n_q() numbers each  @param e  n_v() numbers
  void error(const double* from, const double* to, double* e) const;

  /// Coordinates of one object that give it the pose X_WB; nothing is lost for free objects, others are projected.
  Eigen::VectorXd coordinates(int object, const Pose& X_WB) const;

  /// A configuration of all objects drawn from the boxes; objects without a box stay where q_u has them.
  void sample(const std::vector<SampleBox>& boxes, core::Random& random, Eigen::Ref<Eigen::VectorXd> q_u) const;

 private:
  struct Block {
    ObjectJoint joint;
    int q_begin, v_begin;
    Pose X_WP;
    Eigen::Vector3d axis;
  };
  std::vector<Block> blocks_;
  int n_q_ = 0, n_v_ = 0;
};

/// Of the angles that are the same modulo 2π the nearest to `reference` [rad].
double nearest_turn(double angle, double reference);

/// Worst displacement of an object in e (n_vu, tangent) as a share of the given distance [m] and angle [rad].
double largest_share(const Model& model, const Eigen::VectorXd& e, double position, double angle);

/// Every object is at q1 within the given distance [m] and angle [rad] of where it is at q0.
bool objects_agree(const Model& model, const ObjectSpace& space, const Eigen::VectorXd& q0, const Eigen::VectorXd& q1, double position,
                   double angle);

}  // namespace stiction::world
