#include "stiction/execution/open_loop/speed_limits.hpp"

#include <algorithm>
#include <limits>

#include "stiction/core/invalid_input.hpp"
#include "stiction/world/scales.hpp"

namespace stiction::execution {
namespace {

/// Weight of an object for (E.9) [N]: m g, or the force of its joint's friction and damping when it moves kCoast in a load time, if that is larger.
double calc_weight(const world::Model& model, int object, double load_time) {
  const world::ObjectSpec& spec = model.scene().objects[static_cast<std::size_t>(object)];
  const double length = model.scales().object(object).length;
  const bool turns = spec.joint == world::ObjectJoint::Hinge, slides = spec.joint == world::ObjectJoint::Slider;
  if (!turns && !slides) return kGravity * spec.mass;
  const double speed = kCoast * (turns ? 1 : length) / load_time;
  const double damping = spec.joint_damping * speed;
  return std::max(kGravity * spec.mass, (spec.joint_friction + damping) / (turns ? length : 1));
}

}  // namespace

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
  for (std::size_t i = 0; i < model.scene().objects.size(); ++i) {
    if (model.scene().objects[i].geometries.empty()) continue;  // an object without shapes only carries others
    lightest = std::min(lightest, calc_weight(model, static_cast<int>(i), load_time));
  }
  return lightest / load_time * model.reach().cwiseQuotient(model.stiffness());
}

double calc_duration(const Eigen::VectorXd& u_before, const Eigen::VectorXd& u, const Eigen::VectorXd& speeds) {
  return (u - u_before).cwiseAbs().cwiseQuotient(speeds).maxCoeff();
}

}  // namespace stiction::execution
