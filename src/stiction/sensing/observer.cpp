#include "stiction/sensing/observer.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "stiction/core/invalid_input.hpp"
#include "stiction/sensing/calibrate.hpp"
#include "stiction/sensing/known_contacts.hpp"

namespace stiction::sensing {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

void require_record(const world::Model& model, const MotionRecord& record) {
  const auto n = static_cast<Index>(record.times.size());
  if (n < 2) core::throw_invalid("t", fmt::format("{} moments", n), "two or more");
  const auto require = [&](const char* name, const MatrixXd& matrix) {
    if (matrix.rows() != model.n_a() || matrix.cols() != n)
      core::throw_invalid(name, fmt::format("shape ({}, {})", matrix.cols(), matrix.rows()), fmt::format("({}, {})", n, model.n_a()));
    core::require_finite(name, {matrix.data(), static_cast<std::size_t>(matrix.size())});
  };
  require("q", record.q);
  require("qd", record.v);
  require("tau", record.tau);
  core::require_finite("t", record.times);
  for (std::size_t i = 1; i < record.times.size(); ++i)
    if (!(record.times[i] > record.times[i - 1]))
      core::throw_invalid(fmt::format("t[{}]", i), fmt::format("{} after {}", record.times[i], record.times[i - 1]), "times that increase");
  for (const world::Link& link : model.links())
    if (link.dof >= 0 && model.inertias()[static_cast<std::size_t>(link.body)].mass > 0) return;
  core::throw_invalid("model", "links without mass", "a robot whose file states the masses of its links");
}

/// Momentum and kinetic energy of the links of the robots.
class Momentum {
 public:
  explicit Momentum(const world::Model& model) : model_(model), work_(model) {}

  /// p = M q̇ (n_a).
  VectorXd calc(VectorRef q, VectorRef v) {
    VectorXd out = VectorXd::Zero(model_.n_a());
    for_each_link(q, v, [&](const Vector3d& moment, const Vector3d& push, const Vector3d&, const Vector3d&) {
      out += J_w_.transpose() * moment + J_v_.transpose() * push;
    });
    return out;
  }
  double calc_energy(VectorRef q, VectorRef v) {
    double out = 0;
    for_each_link(q, v, [&](const Vector3d& moment, const Vector3d& push, const Vector3d& w, const Vector3d& speed) {
      out += 0.5 * (moment.dot(w) + push.dot(speed));
    });
    return out;
  }
  /// Cᵀq̇ = ∂/∂q ½ q̇ᵀM q̇.
  VectorXd calc_coriolis(const VectorXd& q, VectorRef v) {
    constexpr double kStep = 1e-5;
    VectorXd out(model_.n_a()), moved = q;
    for (Index j = 0; j < out.size(); ++j) {
      moved[j] = q[j] + kStep;
      const double above = calc_energy(moved, v);
      moved[j] = q[j] - kStep;
      out[j] = (above - calc_energy(moved, v)) / (2 * kStep);
      moved[j] = q[j];
    }
    return out;
  }

 private:
  /// Angular momentum about the link's origin, linear momentum, angular velocity and velocity of the origin, all in the link's axes.
  template <class Function>
  void for_each_link(VectorRef q, VectorRef v, const Function& function) {
    world::calc_kinematics(model_, place_robots(model_, q), work_, kinematics_);
    for (const world::Link& link : model_.links()) {
      const world::BodyInertia& inertia = model_.inertias()[static_cast<std::size_t>(link.body)];
      if (!(inertia.mass > 0) || model_.bodies()[static_cast<std::size_t>(link.body)].axes.empty()) continue;
      calc_link_jacobian(model_, kinematics_, link.body, J_w_, J_v_);
      const Vector3d w = J_w_ * v, speed = J_v_ * v, push = inertia.mass * (speed + w.cross(inertia.p_BCom));
      function(inertia.inertia * w + inertia.p_BCom.cross(push), push, w, speed);
    }
  }

  const world::Model& model_;
  world::KinematicsWorkspace work_;
  world::Kinematics kinematics_;
  Eigen::Matrix3Xd J_w_, J_v_;
};

constexpr Index kFrictionTerms = 3;

/// Least squares of dry friction, viscous friction and offset. Friction dissipates energy: a negative coefficient is set to 0, and the
/// others are fitted again.
Vector3d solve_friction(const MatrixXd& columns, const VectorXd& torques) {
  Vector3d out = columns.colPivHouseholderQr().solve(torques);
  if (out[0] >= 0 && out[1] >= 0) return out;
  const Index none = out[1] < 0 ? 1 : 0, other = 1 - none;
  MatrixXd rest(columns.rows(), 2);
  rest << columns.col(other), columns.col(2);
  const Eigen::Vector2d x = rest.colPivHouseholderQr().solve(torques);
  out[none] = 0;
  out[other] = std::max(0.0, x[0]);
  out[2] = x[0] >= 0 ? x[1] : torques.mean();
  return out;
}

/// Rows whose low-passed torques come from a joint that slides: friction of a joint that sticks is not a function of its speed. All rows if the joint does not
/// slide in both directions.
std::vector<Index> find_sliding(const std::vector<double>& times, const Eigen::RowVectorXd& v, double time_constant,
                                double stiction_speed) {
  constexpr double kSlides = 2, kForgets = 3;  // in v₀, and in time constants
  std::vector<Index> out;
  double since = 0;  // time since the joint last stuck [s]
  bool forwards = false, backwards = false;
  for (Index i = 1; i < v.size(); ++i) {
    since =
        std::abs(v[i]) > kSlides * stiction_speed ? since + times[static_cast<std::size_t>(i)] - times[static_cast<std::size_t>(i) - 1] : 0;
    if (since < kForgets * time_constant) continue;
    out.push_back(i);
    (v[i] > 0 ? forwards : backwards) = true;
  }
  if (forwards && backwards && std::ssize(out) > 2 * kFrictionTerms) return out;
  out.resize(static_cast<std::size_t>(v.size()));
  std::iota(out.begin(), out.end(), Index{0});
  return out;
}

/// Gain of a first-order low-pass over a step, exact for an input that is held.
double gain_of(double dt, double time_constant) { return -std::expm1(-dt / time_constant); }

}  // namespace

VectorXd JointFriction::calc(VectorRef v) const {
  return coulomb.cwiseProduct((v / stiction_speed).array().tanh().matrix()) + viscous.cwiseProduct(v) + offset;
}

MatrixXd observe(const world::Model& model, const MotionRecord& record, const ObserverSettings& settings) {
  require_record(model, record);
  core::require_positive("time_constant", settings.time_constant);
  if (settings.friction != nullptr) core::require_size("friction", settings.friction->coulomb.size(), model.n_a());
  Momentum momentum(model);
  const auto forces = [&](Index i) {
    const VectorXd q = record.q.col(i);
    VectorXd out = record.tau.col(i) + momentum.calc_coriolis(q, record.v.col(i)) - calc_holding_torques(model, place_robots(model, q));
    if (settings.friction != nullptr) out -= settings.friction->calc(record.v.col(i));
    return out;
  };
  MatrixXd out = MatrixXd::Zero(model.n_a(), record.tau.cols());
  VectorXd p = momentum.calc(record.q.col(0), record.v.col(0)), known = forces(0);
  for (Index i = 1; i < out.cols(); ++i) {
    const double dt = record.times[static_cast<std::size_t>(i)] - record.times[static_cast<std::size_t>(i) - 1];
    const VectorXd p_next = momentum.calc(record.q.col(i), record.v.col(i)), known_next = forces(i);
    // The mean external torque of the step is the mean of ṗ minus that of the known torques; r moves towards it.
    const VectorXd mean = (p_next - p) / dt - 0.5 * (known + known_next);
    out.col(i) = out.col(i - 1) + gain_of(dt, settings.time_constant) * (mean - out.col(i - 1));
    p = p_next;
    known = known_next;
  }
  return out;
}

JointFriction identify_friction(const world::Model& model, const MotionRecord& record, double time_constant, double stiction_speed) {
  const MatrixXd r = observe(model, record, {.time_constant = time_constant});
  return fit_friction(model, record.times, record.v, r, time_constant, stiction_speed);
}

JointFriction fit_friction(const world::Model& model, const std::vector<double>& times, const MatrixXd& velocities, const MatrixXd& r,
                           double time_constant, double stiction_speed) {
  core::require_positive("time_constant", time_constant);
  core::require_positive("stiction_speed", stiction_speed);
  const Index n = model.n_a(), count = velocities.cols();
  if (count <= kFrictionTerms) core::throw_invalid("t", fmt::format("{} moments", count), fmt::format("more than {}", kFrictionTerms));
  core::require_size("qd: joints", velocities.rows(), n);
  core::require_size("r: joints", r.rows(), n);
  core::require_size("r: moments", r.cols(), count);
  core::require_size("t", static_cast<Index>(times.size()), count);
  JointFriction out{VectorXd(n), VectorXd(n), VectorXd(n), stiction_speed, VectorXd(n)};
  MatrixXd columns(count, kFrictionTerms);
  for (Index j = 0; j < n; ++j) {
    const Eigen::RowVectorXd v = velocities.row(j);
    if (!(v.maxCoeff() > stiction_speed && v.minCoeff() < -stiction_speed))
      core::throw_invalid("qd",
                          fmt::format("velocities from {:.3g} to {:.3g} of joint '{}'", v.minCoeff(), v.maxCoeff(),
                                      model.dofs()[static_cast<std::size_t>(model.n_vu() + j)].name),
                          fmt::format("motion in both directions, faster than {} rad/s or m/s", stiction_speed));
    const auto regressors = [&](Index i) { return Eigen::RowVector3d(std::tanh(v[i] / stiction_speed), v[i], 1); };
    columns.row(0).setZero();
    for (Index i = 1; i < count; ++i) {
      const double dt = times[static_cast<std::size_t>(i)] - times[static_cast<std::size_t>(i) - 1];
      const Eigen::RowVector3d mean = 0.5 * (regressors(i) + regressors(i - 1));
      columns.row(i) = columns.row(i - 1) + gain_of(dt, time_constant) * (mean - columns.row(i - 1));
    }
    const std::vector<Index> sliding = find_sliding(times, v, time_constant, stiction_speed);
    const VectorXd torques = -r(j, sliding).transpose();
    const MatrixXd used = columns(sliding, Eigen::all);
    const Vector3d x = solve_friction(used, torques);
    out.coulomb[j] = x[0];
    out.viscous[j] = x[1];
    out.offset[j] = x[2];
    out.left[j] = (used * x - torques).norm() / std::sqrt(static_cast<double>(torques.size() - kFrictionTerms));
  }
  return out;
}

}  // namespace stiction::sensing
