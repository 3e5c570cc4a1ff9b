#pragma once

#include "stiction/world/model.hpp"

namespace stiction::world {

/// Computes the derivatives of M_u v and τᵘ of object i (calc_object_mass, calc_gravity) by the objects' coordinates, at fixed components of v.
/// They are not zero because a centre of mass moves relative to the axis that it turns about, and objects that hang on an object move with it.
/// @param v (n_v,i)  @param D_momentum_q, D_gravity_q (n_v,i × n_vu), overwritten
void calc_object_derivatives(const Model& model, const Kinematics& kinematics, int object, VectorRef v,
                             Eigen::Ref<Eigen::MatrixXd> D_momentum_q, Eigen::Ref<Eigen::MatrixXd> D_gravity_q);

}  // namespace stiction::world
