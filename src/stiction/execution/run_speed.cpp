#include "stiction/execution/run_speed.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "stiction/core/invalid_input.hpp"
#include "stiction/world/joint_speeds.hpp"
#include "stiction/world/scales.hpp"

namespace stiction::execution {
namespace {

using world::Model;

/// Way that an object coasts, trails its plan or falls while springs take it up [L].
constexpr double kCoast = 0.05;
constexpr double kGravity = 9.81;        // [m/s²]
constexpr double kLeastInterval = 1e-6;  // [s]

bool is_free(const Model& model, int object) {
  return model.scene().objects[static_cast<std::size_t>(object)].joint == world::ObjectJoint::Free;
}

/// The least μ of what may touch an object, that stops it; 1 where nothing has friction.
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

/// v² = 2 μ g s L of what friction stops, v (τ + T_f) = s L of what is damped.                                                          (E.13)
double calc_object_speed(const Model& model, int object) {
  const double way = kCoast * model.scales().object(object).length;
  if (is_free(model, object)) return std::sqrt(2 * least_friction(model, object) * kGravity * way);
  return way / (planning::kRestTime + calc_follow_time(model, object));
}

/// (E.1), (E.8) and (E.9) of one piece.
void set_durations(const RunSpeeds& speeds, const planning::Piece& piece, int n_a, const planning::Trajectory& trajectory,
                   Eigen::VectorXd& durations) {
  const Eigen::Index first = piece.first_knot, n = piece.last_knot - first;
  Eigen::VectorXd pushing(n);  // at the speed of pushes
  for (Eigen::Index i = 0; i < n; ++i)
    pushing[i] = planning::calc_duration(trajectory.u.col(first + i), trajectory.u.col(first + i + 1), speeds.push);
  double begin = 0;
  for (Eigen::Index i = 0; i < n; ++i) {
    const Eigen::VectorXd u0 = trajectory.u.col(first + i), u1 = trajectory.u.col(first + i + 1);
    double factor = 1;
    if (piece.kind == planning::SegmentKind::Regrasp) {
      const double middle = begin + 0.5 * pushing[i];
      factor = std::clamp(std::min(middle, pushing.sum() - middle) / speeds.ramp, 1.0, speeds.regrasp_factor);
    }
    const Eigen::VectorXd strain0 = u0 - trajectory.q.col(first + i).tail(n_a), strain1 = u1 - trajectory.q.col(first + i + 1).tail(n_a);
    durations[first + i + 1] = std::max(
        {pushing[i] / factor, planning::calc_duration(strain0, strain1, speeds.springs), planning::calc_duration(u0, u1, speeds.most)});
    begin += pushing[i];
  }
}

}  // namespace

void RunSpeeds::validate(const Model& model) const {
  for (const auto& [name, values] : {std::pair("speed.push", &push), {"speed.most", &most}, {"speed.springs", &springs}}) {
    core::require_size(name, values->size(), model.n_a());
    for (const double v : *values) {
      if (!(v > 0)) core::throw_invalid(name, fmt::format("{:g}", v), "numbers > 0");
    }
  }
  if (!(regrasp_factor >= 1)) core::throw_invalid("speed.regrasp_factor", fmt::format("{:g}", regrasp_factor), "a number ≥ 1");
  core::require_positive("speed.ramp", ramp);
}

double calc_follow_time(const Model& model, int object) {
  if (is_free(model, object)) return 0;
  return model.objects()[static_cast<std::size_t>(object)].carried_mass / (planning::kRestTime * model.scales().softest_stiffness());
}

RunSpeeds calc_run_speeds(const Model& model, int object, double factor) {
  core::require_positive("speed", factor);
  const double speed = factor * calc_object_speed(model, object), way = kCoast * model.scales().object(object).length;
  planning::SpeedLimits limits;
  limits.load_time = std::sqrt(2 * way / kGravity);
  RunSpeeds out;
  out.most = world::read_joint_speeds(model);
  out.springs = limits.of_springs(model);
  out.ramp = limits.load_time;
  out.push.resize(model.n_a());
  for (int j = 0; j < model.n_a(); ++j) {
    const bool turns = model.dofs()[static_cast<std::size_t>(model.n_vu() + j)].kind == world::DofKind::Revolute;
    out.push[j] = std::min(turns ? speed / model.reach()[j] : speed, out.most[j]);
  }
  return out;
}

planning::Trajectory make_trajectory(const Model& model, const planning::Plan& plan, const RunSpeeds& speeds) {
  speeds.validate(model);
  // At one unit a second, for the knots; their times follow.
  planning::Trajectory out = planning::make_trajectory(
      model, plan, {.revolute = 1, .prismatic = 1, .regrasp_factor = 1, .landing_factor = 1, .load_time = 0, .pause = 0});
  Eigen::VectorXd durations = Eigen::VectorXd::Zero(out.times.size());  // up to each knot
  for (const planning::Piece& piece : out.pieces) set_durations(speeds, piece, model.n_a(), out, durations);
  for (Eigen::Index k = 1; k < out.times.size(); ++k) out.times[k] = out.times[k - 1] + std::max(durations[k], kLeastInterval);
  return out;
}

}  // namespace stiction::execution
