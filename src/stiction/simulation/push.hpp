#pragma once

#include <Eigen/Core>

namespace stiction::simulation {

/// A constant force on a point that is fixed in a body.
struct Push {
  int body = -1;                                      ///< index into Model::bodies(); −1: no force
  Eigen::Vector3d p_BP = Eigen::Vector3d::Zero();     ///< [m]
  Eigen::Vector3d force_W = Eigen::Vector3d::Zero();  ///< [N]
};

}  // namespace stiction::simulation
