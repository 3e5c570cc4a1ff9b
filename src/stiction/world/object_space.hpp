#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "stiction/core/random.hpp"
#include "stiction/world/model.hpp"

namespace stiction::world {

/// Box from which the configuration of one object is drawn: position [m] and rotation [rad] relative to the world for a free object, coordinates
/// for a planar, hinged or sliding object.
struct SampleBox {
  int object = 0;
  Eigen::VectorXd lower, upper;  ///< free object: x y z roll pitch yaw; others: their coordinates
};

/// The space of the configurations qᵘ of the objects: computes errors and draws samples.
class ObjectSpace {
 public:
  explicit ObjectSpace(const Model& model);

  int n_q() const { return n_q_; }
  int n_v() const { return n_v_; }

  /// Computes e = to ⊖ from in the tangent of the objects, e of (3.5). The angle of a planar object is wrapped to (−π, π]. Rotation vectors are
  /// accurate to 4e-8 of their length.
  /// @param from, to  at least n_q() numbers each  @param e  n_v() numbers
  void error(const double* from, const double* to, double* e) const;

  /// Coordinates at which one object has the pose X_WB: exact for free objects; for others the pose is projected onto their motion.
  Eigen::VectorXd coordinates(int object, const Pose& X_WB) const;

  /// Draws a configuration of all objects from the boxes; objects without a box keep their values in q_u.
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

/// The angle equal to `angle` modulo 2π that is nearest to `reference` [rad].
double nearest_turn(double angle, double reference);

/// Largest displacement of an object in e (n_vu, tangent), as a share of the given distance [m] and angle [rad].
double largest_share(const Model& model, const Eigen::VectorXd& e, double position, double angle);

/// True if each object at q1 is within the given distance [m] and angle [rad] of its pose at q0.
bool objects_agree(const Model& model, const ObjectSpace& space, const Eigen::VectorXd& q0, const Eigen::VectorXd& q1, double position,
                   double angle);

}  // namespace stiction::world
