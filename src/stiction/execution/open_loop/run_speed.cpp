#include "stiction/execution/open_loop/run_speed.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "stiction/core/invalid_input.hpp"
#include "stiction/execution/open_loop/drag_feedforward.hpp"
#include "stiction/execution/open_loop/speed_limits.hpp"
#include "stiction/world/robot_chains.hpp"
#include "stiction/world/scales.hpp"

namespace stiction::execution {
namespace {

using world::Model;

/// χ of (E.13): share of the damping of objects on joints that is unknown, so the lead does not compensate it.
constexpr double kUnknownDrag = 0.3;
/// Least share of the speed with a lead at which a push without lead may go, for any damping of the object.
constexpr double kLeastUnled = 1.0 / 16;
/// Time in which an object on a joint comes to its speed or to rest, in rest times τ.
constexpr double kStartTimes = 4;
/// s_g of (E.26): acceleration of an object that only robots hold, as a share of gravity.
constexpr double kCarry = 0.2;
/// Share of a motor's effort for accelerating the inertia that it moves.
constexpr double kInertiaShare = 0.5;
/// Share of a motor's effort for overcoming the damping of its joint.
constexpr double kDampingShare = 0.5;

bool is_free(const Model& model, int object) {
  return model.scene().objects[static_cast<std::size_t>(object)].joint == world::ObjectJoint::Free;
}

/// Least friction μ > 0 of the pairs of an object, which brakes it; 1 if none has friction.
double least_friction(const Model& model, int object) {
  const int body = model.objects()[static_cast<std::size_t>(object)].body;
  double least = std::numeric_limits<double>::infinity();
  for (const auto& pair : model.pairs()) {
    const bool touches = model.geometries()[static_cast<std::size_t>(pair.geometry_a)].body == body ||
                         model.geometries()[static_cast<std::size_t>(pair.geometry_b)].body == body;
    if (touches && pair.friction > 0) least = std::min(least, pair.friction);
  }
  return std::isfinite(least) ? least : 1.0;
}

/// Speed of the object: v² = 2 μ g s_L L if friction stops it, v (τ + χ T_f) = s_L L if damping does.                                   (E.13)
double calc_object_speed(const Model& model, int object) {
  const double way = kCoast * model.scales().object(object).length;
  if (is_free(model, object)) return std::sqrt(2 * least_friction(model, object) * kGravity * way);
  return way / (kRestTime + kUnknownDrag * calc_follow_time(model, object));
}

/// ω² = K_a/M of the joints, with the largest inertia M of any posture (n_a) [1/s²].
Eigen::VectorXd calc_omega_squared(const Model& model) { return model.stiffness().cwiseQuotient(world::calc_largest_joint_inertia(model)); }

/// T_j of (E.24). A spring force that changes as e^(t/T) trails its command by 1/(T ω)² of itself. T makes this share kCoast for the slowest joint of a branch,
/// so an object is pressed where the plan presses it. T is no shorter than the load time of unloaded springs.                           (E.24)
Eigen::VectorXd calc_spring_time(const Model& model, const Eigen::VectorXd& omega_squared, double load_time) {
  const world::RobotChains chains(model);
  Eigen::VectorXd out = Eigen::VectorXd::Constant(model.n_a(), load_time);
  for (int chain = 0; chain < chains.size(); ++chain) {
    double slowest = std::numeric_limits<double>::infinity();
    for (const int j : chains.joints(chain)) slowest = std::min(slowest, omega_squared[j]);
    for (const int j : chains.joints(chain)) out[j] = std::max(load_time, 1 / std::sqrt(kCoast * slowest));
  }
  return out;
}

/// Speed without lead, v (τ + T_D) = s_L L, over the speed with lead, v (τ + χ T_f) = s_L L. Without lead, an object trails by its whole damping, the damping of
/// its joint included.                                                                                                                      (E.13)
double calc_unled(const Model& model, int object) {
  const auto& coordinates = model.objects()[static_cast<std::size_t>(object)];
  const Eigen::VectorXd damping = calc_object_damping(model);
  double trails = 0;  // T_D [s]
  for (int v = coordinates.v_begin; v < coordinates.v_begin + coordinates.n_v; ++v) {
    const bool turns = model.dofs()[static_cast<std::size_t>(v)].kind == world::DofKind::Revolute;
    const double arm = turns ? 0.5 * model.scales().object(object).length : 1;
    trails = std::max(trails, damping[v] / (arm * arm * model.scales().softest_stiffness()));
  }
  return std::clamp((kRestTime + kUnknownDrag * calc_follow_time(model, object)) / (kRestTime + trails), kLeastUnled, 1.0);
}

/// Largest speeds of the joints: those of the file, and those at which half of the effort overcomes the damping of the joint (n_a) [rad/s, m/s].
Eigen::VectorXd calc_most_speed(const Model& model) {
  Eigen::VectorXd out = model.speed_limit();
  for (int j = 0; j < model.n_a(); ++j) {
    const double damping = model.dofs()[static_cast<std::size_t>(model.n_vu() + j)].damping;
    if (damping > 0) out[j] = std::min(out[j], kDampingShare * model.effort()[j] / damping);
  }
  return out;
}

/// Sets the limits of free motion. A spring K_a with the inertia M of its joint trails by M q̈/K_a, and after a speed jump Δq̇ by at most Δq̇/(e ω). Here
/// ω² = K_a/M. Both must stay within the clearance at the reach of the joint, and within what the motor gives.                           (E.18)
void set_free_motion(const Model& model, const Eigen::VectorXd& omega_squared, RunSpeeds& out) {
  out.room = world::share::kClearance * model.scales().robots().length;
  out.most_room = kInertiaShare * model.effort().cwiseQuotient(model.stiffness()).cwiseProduct(model.reach());
  const Eigen::VectorXd lag = out.most_room.cwiseMin(out.room).cwiseQuotient(model.reach());
  out.acceleration = omega_squared.cwiseProduct(lag);
  out.jump = std::numbers::e * omega_squared.cwiseSqrt().cwiseProduct(lag);
}

/// Sets the limits while an object is carried, with the acceleration s_g g. Critically damped springs start at 2 ω Δq̇ after a speed jump Δq̇ of their
/// commands.                                                                                                                             (E.26)
void set_carrying(const Model& model, const Eigen::VectorXd& omega_squared, RunSpeeds& out) {
  out.carry_acceleration = kCarry * kGravity * model.reach().cwiseInverse();
  out.carry_jump = 0.5 * out.carry_acceleration.cwiseQuotient(omega_squared.cwiseSqrt());
}

/// Scales the limits to a time that passes `share` times as fast.
void slow_down(double share, RunSpeeds& out) {
  out.object *= share;
  out.push *= share;
  out.most *= share;
  out.springs *= share;
  out.spring_time /= share;
  out.acceleration *= share * share;
  out.jump *= share;
  out.carry_acceleration *= share * share;
  out.carry_jump *= share;
}

}  // namespace

void RunSpeeds::validate(const Model& model) const {
  for (const auto& [name, values] : {std::pair("speed.push", &push),
                                     {"speed.most", &most},
                                     {"speed.springs", &springs},
                                     {"speed.spring_time", &spring_time},
                                     {"speed.acceleration", &acceleration},
                                     {"speed.jump", &jump},
                                     {"speed.carry_acceleration", &carry_acceleration},
                                     {"speed.carry_jump", &carry_jump},
                                     {"speed.most_room", &most_room}}) {
    core::require_size(name, values->size(), model.n_a());
    for (const double v : *values) {
      if (!(v > 0)) core::throw_invalid(name, fmt::format("{:g}", v), "numbers > 0");
    }
  }
  core::require_positive("speed.factor", factor);
  core::require_positive("speed.object", object);
  core::require_positive("speed.unled", unled);
  core::require_positive("speed.room", room);
  core::require_nonnegative("speed.start_time", start_time);
}

double calc_follow_time(const Model& model, int object) {
  if (is_free(model, object)) return 0;
  return model.objects()[static_cast<std::size_t>(object)].carried_mass / (kRestTime * model.scales().softest_stiffness());
}

RunSpeeds calc_run_speeds(const Model& model, int object, double factor) {
  core::require_positive("speed", factor);
  const double speed = std::max(factor, 1.0) * calc_object_speed(model, object), way = kCoast * model.scales().object(object).length;
  SpeedLimits limits;
  limits.load_time = std::sqrt(2 * way / kGravity);
  RunSpeeds out;
  out.factor = factor;
  out.object = speed;
  out.unled = calc_unled(model, object);
  out.most = calc_most_speed(model);
  out.springs = limits.of_springs(model);
  out.start_time = is_free(model, object) ? 0 : kStartTimes * kRestTime;
  out.push.resize(model.n_a());
  for (int j = 0; j < model.n_a(); ++j) {
    const bool turns = model.dofs()[static_cast<std::size_t>(model.n_vu() + j)].kind == world::DofKind::Revolute;
    out.push[j] = std::min(turns ? speed / model.reach()[j] : speed, out.most[j]);
  }
  const Eigen::VectorXd omega_squared = calc_omega_squared(model);
  out.spring_time = calc_spring_time(model, omega_squared, limits.load_time);
  set_free_motion(model, omega_squared, out);
  set_carrying(model, omega_squared, out);
  slow_down(std::min(factor, 1.0), out);
  return out;
}

}  // namespace stiction::execution
