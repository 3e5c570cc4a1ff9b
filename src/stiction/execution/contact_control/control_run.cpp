#include "stiction/execution/contact_control/control_run.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "stiction/core/invalid_input.hpp"
#include "stiction/core/quantile.hpp"
#include "stiction/world/point_jacobian.hpp"

namespace stiction::execution {

using core::Status;

void ControlRunOptions::validate() const { core::require_nonnegative("settle", settle); }

namespace {

constexpr double kAbove = 1.2;  ///< multiple of the bound above which ticks are counted

double quantile_or_0(const std::vector<double>& values, double p) { return values.empty() ? 0 : core::quantile(values, p); }

/// Contacts of a run, for each pair: since when it touches, and its force in the last tick.
class Contacts {
 public:
  struct Contact {
    int pair;
    double since;      ///< begin of the contact [s]
    double force = 0;  ///< force in this tick [N]
    double last = 0;   ///< force in the tick before [N]
    int body = -1;     ///< link
    Eigen::Vector3d p_W = Eigen::Vector3d::Zero(), f_W = Eigen::Vector3d::Zero();
    bool touches = true;
  };

  /// @param settle  age at which a contact counts as settled [s]
  Contacts(const world::Model& model, double settle) : model_(model), settle_(settle), kinematics_work_(model) {}

  /// @param before  the sample of the tick before; null: there is none
  void add(const ControlSample& sample, const ControlSample* before) {
    time_ = sample.time;
    std::erase_if(contacts_, [](const Contact& c) { return !c.touches; });
    for (Contact& c : contacts_) c.last = c.force, c.force = 0, c.touches = false;
    for (const simulation::PairForce& f : sample.forces) {
      auto at = std::find_if(contacts_.begin(), contacts_.end(), [&](const Contact& c) { return c.pair == f.pair; });
      if (at == contacts_.end()) at = contacts_.insert(at, {f.pair, sample.time});
      at->force = f.force_W.norm(), at->touches = true;
    }
    judge_rises(sample, before);
    keep_places(sample);
  }

  /// Largest force of a settled contact [N]; empty: no settled contact.
  std::optional<double> settled_force() const {
    std::optional<double> out;
    for (const Contact& c : contacts_)
      if (c.touches && is_settled(c)) out = std::max(out.value_or(0), c.force);
    return out;
  }

  double peak_rise() const { return peak_rise_; }            ///< largest rise of a settled contact's force in a tick, so far [N]
  double commanded_rise() const { return commanded_rise_; }  ///< part of this rise due to the command [N]

  /// Largest fall of a settled contact's force since the tick before [N].
  double settled_fall() const {
    double out = 0;
    for (const Contact& c : contacts_)
      if (is_settled(c)) out = std::max(out, c.last - c.force);
    return out;
  }

 private:
  bool is_settled(const Contact& c) const { return time_ >= c.since + settle_; }

  void judge_rises(const ControlSample& sample, const ControlSample* before) {
    for (const Contact& c : contacts_) {
      if (!c.touches || c.body < 0 || !is_settled(c) || before == nullptr || !(c.last > 0) || !(c.force - c.last > peak_rise_)) continue;
      peak_rise_ = c.force - c.last;
      commanded_rise_ = calc_commanded(c, before->q, before->q_cmd - last_command_);
    }
    if (before != nullptr) last_command_ = before->q_cmd;
    if (last_command_.size() == 0) last_command_ = sample.q_cmd;
  }

  /// −J_u Δq_cmd / (J_u K⁻¹ J_uᵀ) at the place where the contact was a tick ago, (C.1).
  double calc_commanded(const Contact& c, const Eigen::VectorXd& q, const Eigen::VectorXd& change) {
    Eigen::VectorXd q_full = model_.neutral();
    q_full.tail(model_.n_a()) = q;
    world::calc_kinematics(model_, q_full, kinematics_work_, kinematics_);
    control::RowMatrix J(6, model_.n_a());
    world::calc_point_jacobian(model_, kinematics_, c.body, c.p_W, J);
    const Eigen::VectorXd J_u = J.topRows<3>().transpose() * c.f_W.normalized();
    const double softness = J_u.cwiseAbs2().cwiseQuotient(model_.stiffness()).sum();
    return softness > 0 ? -J_u.dot(change) / softness : 0;
  }

  void keep_places(const ControlSample& sample) {
    for (const simulation::PairForce& f : sample.forces) {
      const auto at = std::find_if(contacts_.begin(), contacts_.end(), [&](const Contact& c) { return c.pair == f.pair; });
      at->p_W = f.p_WC, at->f_W = f.force_W, at->body = body_of(f.pair);
    }
  }

  /// Link of a pair; −1 for the force of a hand, which no command changes.
  int body_of(int pair) const {
    const auto body = [&](int geometry) { return model_.geometries()[static_cast<std::size_t>(geometry)].body; };
    if (pair < 0) return -1;
    const world::Pair& p = model_.pairs()[static_cast<std::size_t>(pair)];
    const int a = body(p.geometry_a);
    return model_.bodies()[static_cast<std::size_t>(a)].kind == world::BodyKind::Robot ? a : body(p.geometry_b);
  }

  const world::Model& model_;
  double settle_, time_ = 0, peak_rise_ = 0, commanded_rise_ = 0;
  Eigen::VectorXd last_command_;  ///< command of the tick before the last one (n_a)
  world::KinematicsWorkspace kinematics_work_;
  world::Kinematics kinematics_;
  std::vector<Contact> contacts_;
};

Status run(const ControlScenario& scenario, const ControlRunOptions& options, ControlLoop& loop, ControlRunResult& out) {
  const double ticks = std::ceil(scenario.duration / scenario.period - 1e-9);
  Eigen::VectorXd reference;
  for (long k = 0; static_cast<double>(k) < ticks; ++k) {
    if (options.control.cancelled()) return Status::Cancelled;
    if (options.control.expired()) return Status::MaxIterations;
    calc_reference(scenario, loop.time() + scenario.period, reference);
    if (loop.tick(reference, out.samples.emplace_back()) != Status::Solved) {
      out.message = loop.message();
      return Status::NumericalFailure;
    }
  }
  return Status::Solved;
}

}  // namespace

void summarise(const ControlScenario& scenario, const ControlLoop& loop, double settle, ControlRunResult& out) {
  std::vector<double> bounded;
  double force_sum = 0, error_contact = 0, error_free = 0;
  int in_contact = 0, free = 0;
  bool touched = false;
  Contacts contacts(loop.world(), settle);
  const ControlSample* before = nullptr;
  for (const ControlSample& s : out.samples) {
    const bool touches = s.largest_force > 0;
    out.makes += touches && !touched;
    touched = touches;
    (touches ? in_contact : free) += 1;
    (touches ? error_contact : error_free) += s.error * s.error;
    out.peak_force = std::max(out.peak_force, s.largest_force);
    out.peak_speed = std::max(out.peak_speed, s.speed);
    out.slack_ticks += s.slack > 1e-3 * scenario.controller.lambda_max;
    contacts.add(s, before);
    before = &s;
    out.peak_force_rate = std::max(out.peak_force_rate, contacts.settled_fall() / scenario.period);
    const std::optional<double> force = contacts.settled_force();
    if (!force) continue;
    ++out.settled_ticks;
    force_sum += *force;
    out.settled_peak = std::max(out.settled_peak, *force);
    out.above_ticks += *force > kAbove * scenario.controller.lambda_max;
    if (!s.bounded) continue;
    bounded.push_back(*force);
    out.bound_error += std::abs(*force - scenario.controller.lambda_max);
  }
  out.peak_rise = contacts.peak_rise(), out.commanded_rise = contacts.commanded_rise();
  out.bounded_ticks = static_cast<int>(bounded.size());
  if (!bounded.empty()) out.bound_error /= static_cast<double>(bounded.size());
  out.bound_p95 = quantile_or_0(bounded, 0.95);
  if (out.settled_ticks > 0) out.mean_force = force_sum / out.settled_ticks;
  if (in_contact > 0) out.rms_error_contact = std::sqrt(error_contact / in_contact);
  if (free > 0) out.rms_error_free = std::sqrt(error_free / free);
  out.unsolved_ticks = loop.unsolved_ticks();
  out.tick_median_s = quantile_or_0(loop.update_times(), 0.5);
  out.tick_p99_s = quantile_or_0(loop.update_times(), 0.99);
  out.sense_median_s = quantile_or_0(loop.sense_times(), 0.5);
  out.sense_p99_s = quantile_or_0(loop.sense_times(), 0.99);
}

Status run_control(const ControlScenario& scenario, const ControlRunOptions& options, ControlRunResult& out) {
  options.validate();
  ControlLoop loop(scenario, scenario.model);
  out = {};
  out.status = run(scenario, options, loop, out);
  summarise(scenario, loop, options.settle, out);
  return out.status;
}

}  // namespace stiction::execution
