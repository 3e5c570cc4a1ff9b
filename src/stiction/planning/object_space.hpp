#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "stiction/core/random.hpp"
#include "stiction/planning/planner.hpp"
#include "stiction/world/model.hpp"

namespace stiction::planning {

/// The configurations qᵘ of the objects as a space to measure and sample in.
class ObjectSpace {
 public:
  explicit ObjectSpace(const world::Model& model);

  int n_q() const { return n_q_; }
  int n_v() const { return n_v_; }

  /// e = to ⊖ from in the tangent of the objects, e of (3.5); the angle of a planar object is wrapped to (−π, π];
  /// rotation vectors are right to 4e-8 of their length.
  /// @param from, to  at least n_q() numbers each  @param e  n_v() numbers
  void error(const double* from, const double* to, double* e) const;

  /// Replaces the entries of every free rotation by their mean.
  /// @param weights  (n_v)
  void make_isotropic(Eigen::Ref<Eigen::VectorXd> weights) const;

  /// A metric of the space that is at most √(Σ weights e²), and cheap: the angle θ of a free rotation counts as 2 sin(θ/2), its chord.
  /// @param weights  (n_v), equal over every free rotation
  double chord(const double* from, const double* to, const Eigen::VectorXd& weights) const;

  /// Coordinates of one object that give it the pose X_WB; nothing is lost for free objects, others are projected.
  Eigen::VectorXd coordinates(int object, const world::Pose& X_WB) const;

  /// A configuration of all objects drawn from the boxes; objects without a box stay where q_u has them.
  void sample(const std::vector<SampleBox>& boxes, core::Random& random, Eigen::Ref<Eigen::VectorXd> q_u) const;

 private:
  struct Block {
    world::ObjectJoint joint;
    int q_begin, v_begin;
    world::Pose X_WP;
    Eigen::Vector3d axis;
  };
  std::vector<Block> blocks_;
  int n_q_ = 0, n_v_ = 0;
};

/// Of the angles that are the same modulo 2π the nearest to `reference` [rad].
double nearest_turn(double angle, double reference);

/// 1/tolerance of the goal per coordinate of the objects (n_vu) [1/m or 1/rad].
Eigen::VectorXd inverse_tolerances(const world::Model& model, const Goal& goal);

/// Worst displacement of an object in e (n_vu, tangent) as a share of the given distance [m] and angle [rad].
double largest_share(const world::Model& model, const Eigen::VectorXd& e, double position, double angle);

/// Every object is at q1 within the given distance [m] and angle [rad] of where it is at q0.
bool objects_agree(const world::Model& model, const ObjectSpace& space, const Eigen::VectorXd& q0, const Eigen::VectorXd& q1,
                   double position, double angle);

}  // namespace stiction::planning
