#pragma once

#include "stiction/world/model.hpp"

namespace stiction::world {

/// How M_u v and τᵘ of object i (calc_object_mass, calc_gravity) change with the objects' coordinates, at fixed components of v: a centre of
/// mass moves against the axis that it turns about, and what hangs on an object turns and moves with it.
/// @param v (n_v,i)  @param D_momentum_q, D_gravity_q (n_v,i × n_vu), overwritten
void calc_object_derivatives(const Model& model, const Kinematics& kinematics, int object, VectorRef v,
                             Eigen::Ref<Eigen::MatrixXd> D_momentum_q, Eigen::Ref<Eigen::MatrixXd> D_gravity_q);

}  // namespace stiction::world
