#include "stiction/execution/open_loop/speed_limits.hpp"

#include <algorithm>
#include <limits>

#include "stiction/core/invalid_input.hpp"

namespace stiction::execution {

void SpeedLimits::validate() const {
  core::require_positive("speed.revolute", revolute);
  core::require_positive("speed.prismatic", prismatic);
  core::require_positive("speed.regrasp_factor", regrasp_factor);
  core::require_positive("speed.ramp", ramp);
  core::require_positive("speed.landing_factor", landing_factor);
  core::require_nonnegative("speed.load_time", load_time);
  core::require_nonnegative("speed.pause", pause);
}

Eigen::VectorXd SpeedLimits::of_joints(const world::Model& model) const {
  Eigen::VectorXd v(model.n_a());
  for (int j = 0; j < model.n_a(); ++j) {
    const auto& dof = model.dofs()[static_cast<std::size_t>(model.n_vu() + j)];
    v[j] = dof.kind == world::DofKind::Revolute ? revolute : prismatic;
  }
  return v;
}

Eigen::VectorXd SpeedLimits::of_springs(const world::Model& model) const {
  double lightest = std::numeric_limits<double>::infinity();
  for (const auto& object : model.scene().objects) {
    if (!object.geometries.empty()) lightest = std::min(lightest, object.mass);  // what has none only carries others
  }
  return kGravity * lightest / load_time * model.reach().cwiseQuotient(model.stiffness());
}

double calc_duration(const Eigen::VectorXd& u_before, const Eigen::VectorXd& u, const Eigen::VectorXd& speeds) {
  return (u - u_before).cwiseAbs().cwiseQuotient(speeds).maxCoeff();
}

}  // namespace stiction::execution
