#pragma once

#include <Eigen/Core>
#include <span>

#include "stiction/world/model_impl.hpp"

namespace stiction::world {

struct Ball {
  Eigen::Vector3d center = Eigen::Vector3d::Zero();  ///< [m], in W
  double radius = 0;                                 ///< [m]
};

/// Computes a ball that a point of a body never leaves while joints move: hinges turn the point about their axes, sliders move it within their
/// limits. The radius is infinite for an unbounded motion, as on a free object.
/// @param kinematics  kinematics at q (n_q)
/// @param p_W         the point [m]
/// @param moving      per robot joint (n_a): nonzero if it moves; objects are then fixed. Empty: all joints and objects move
/// Tests: tests/world/reach_ball_test.cpp
Ball calc_reach_ball(const Model::Impl& model, const Kinematics& kinematics, const VectorRef& q, const Body& body,
                     const Eigen::Vector3d& p_W, std::span<const char> moving = {});

}  // namespace stiction::world
