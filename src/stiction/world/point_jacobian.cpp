#include "stiction/world/point_jacobian.hpp"

#include <Eigen/Geometry>

#include "stiction/world/axis.hpp"

namespace stiction::world {

void calc_point_jacobian(const Model& model, const Kinematics& kinematics, int body, const Eigen::Vector3d& p_W,
                         Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>& J) {
  J.setZero();
  for (const int axis : model.bodies()[static_cast<std::size_t>(body)].axes) {
    const auto [dof, kind, ratio] = axis_at(model, axis);
    const int column = dof - model.n_vu();
    if (column < 0) continue;  // a coordinate of an object
    const Eigen::Vector3d a = ratio * kinematics.axis_W.col(axis);
    if (kind == DofKind::Prismatic) {
      J.col(column).head<3>() += a;
    } else {
      J.col(column).head<3>() += a.cross(p_W - kinematics.origin_W.col(axis));
      J.col(column).tail<3>() += a;
    }
  }
}

}  // namespace stiction::world
