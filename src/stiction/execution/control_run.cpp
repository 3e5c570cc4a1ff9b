#include "stiction/execution/control_run.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <deque>
#include <optional>

#include "stiction/core/invalid_input.hpp"
#include "stiction/core/quantile.hpp"
#include "stiction/simulation/driven_plant.hpp"

namespace stiction::execution {

using core::Status;

void ControlRunOptions::validate() const { core::require_nonnegative("settle", settle); }

namespace {

std::size_t at(Eigen::Index i) { return static_cast<std::size_t>(i); }

double quantile_or_0(const std::vector<double>& values, double p) { return values.empty() ? 0 : core::quantile(values, p); }

/// Estimated contacts come with damping of their own, the same per second at any period.
control::ControllerOptions make_controller_options(const ControlScenario& scenario) {
  control::ControllerOptions out = scenario.controller;
  if (scenario.contacts == ContactSource::True) return out;
  const double share = scenario.period / kDampingPeriod;
  out.damping = scenario.estimated_damping;
  out.damping.largest /= share;
  out.damping.forget_rate = 1 - std::pow(1 - out.damping.forget_rate, share);
  return out;
}

/// One run in progress.
class Run {
 public:
  Run(const ControlScenario& scenario, const ControlRunOptions& options, ControlRunResult& out)
      : scenario_(scenario),
        model_(*scenario.model),
        options_(options),
        out_(out),
        plant_(simulation::Plant::make(scenario.model, scenario.plant), scenario.impedance,
               is_estimated() ? std::optional(scenario.observer) : std::nullopt),
        controller_(scenario.model, make_controller_options(scenario)),
        kinematics_work_(model_) {
    Eigen::VectorXd q = model_.neutral();
    q.tail(model_.n_a()) = scenario.start;
    plant_.reset(q);
    controller_.configure(scenario.start);
    q_cmd_ = scenario.start;
    if (is_estimated()) estimator_.emplace(scenario.model, scenario.estimator);
    if (scenario.tool >= 0) X_WT_start_ = calc_tool_pose();
    out = {};
  }

  Status go() {
    const auto ticks = static_cast<long>(std::ceil(scenario_.duration / scenario_.period - 1e-9));
    for (long k = 0; k < ticks; ++k) {
      if (options_.control.cancelled()) return Status::Cancelled;
      if (options_.control.expired()) return Status::MaxIterations;
      const double time = static_cast<double>(k) * scenario_.period;
      calc_reference(scenario_, time + scenario_.period, reference_);
      read_contacts();
      measure();
      tick(time);
      if (plant_.advance(q_cmd_, scenario_.period) != Status::Solved) {
        out_.message = plant_.message();
        return Status::NumericalFailure;
      }
    }
    return Status::Solved;
  }

  void summarise() {
    std::vector<double> bounded;
    double force_sum = 0, error_contact = 0, error_free = 0;
    int in_contact = 0, free = 0;
    std::optional<double> made;
    for (const ControlSample& s : out_.samples) {
      const bool touches = s.largest_force > 0;
      if (touches && !made) made = s.time, ++out_.makes;
      if (!touches) made.reset();
      (touches ? in_contact : free) += 1;
      (touches ? error_contact : error_free) += s.error * s.error;
      out_.peak_force = std::max(out_.peak_force, s.largest_force);
      out_.peak_speed = std::max(out_.peak_speed, s.speed);
      out_.slack_ticks += s.slack > 1e-3 * scenario_.controller.lambda_max;
      if (!made || s.time < *made + options_.settle) continue;
      ++out_.settled_ticks;
      force_sum += s.largest_force;
      out_.settled_peak = std::max(out_.settled_peak, s.largest_force);
      if (!s.bounded) continue;
      bounded.push_back(s.largest_force);
      out_.bound_error += std::abs(s.largest_force - scenario_.controller.lambda_max);
    }
    for (std::size_t k = 1; k < out_.samples.size(); ++k) {
      const double fall = out_.samples[k - 1].largest_force - out_.samples[k].largest_force;
      if (is_settled(k - 1)) out_.peak_force_rate = std::max(out_.peak_force_rate, fall / scenario_.period);
    }
    out_.bounded_ticks = static_cast<int>(bounded.size());
    if (!bounded.empty()) out_.bound_error /= static_cast<double>(bounded.size());
    out_.bound_p95 = quantile_or_0(bounded, 0.95);
    if (out_.settled_ticks > 0) out_.mean_force = force_sum / out_.settled_ticks;
    if (in_contact > 0) out_.rms_error_contact = std::sqrt(error_contact / in_contact);
    if (free > 0) out_.rms_error_free = std::sqrt(error_free / free);
    out_.tick_median_s = quantile_or_0(tick_s_, 0.5);
    out_.tick_p99_s = quantile_or_0(tick_s_, 0.99);
    out_.sense_median_s = quantile_or_0(sense_s_, 0.5);
    out_.sense_p99_s = quantile_or_0(sense_s_, 0.99);
  }

 private:
  bool is_estimated() const { return scenario_.contacts == ContactSource::Estimated; }

  bool is_settled(std::size_t k) const {
    const auto settle = static_cast<std::size_t>(options_.settle / scenario_.period);
    if (k < settle) return false;
    for (std::size_t i = k - settle; i <= k; ++i)
      if (!(out_.samples[i].largest_force > 0)) return false;
    return true;
  }

  world::Pose calc_tool_pose() {
    world::calc_kinematics(model_, plant_.q(), kinematics_work_, kinematics_);
    return kinematics_.X_WB[at(scenario_.tool)] * scenario_.X_BT;
  }

  /// What is known of contacts after the delay: as a skin would measure them, or from torques.
  void measure() {
    const Eigen::VectorXd q = plant_.q().tail(model_.n_a());
    measured_.push_back({q, plant_.observed(), contacts_});
    const auto delay = static_cast<std::size_t>(std::lround(scenario_.delay / scenario_.period));
    if (measured_.size() > delay + 1) measured_.pop_front();
    if (measured_.size() <= delay) {
      told_.clear();
      return;
    }
    const Measured& m = measured_.front();
    if (!is_estimated()) {
      told_ = m.contacts;
      return;
    }
    const auto started = std::chrono::steady_clock::now();
    const auto contacts = estimator_->update(m.q, m.external, q, scenario_.period);
    sense_s_.push_back(std::chrono::duration<double>(std::chrono::steady_clock::now() - started).count());
    told_.assign(contacts.begin(), contacts.end());
  }

  /// Forces on robots by anything else.
  void read_contacts() {
    contacts_.clear(), forces_.clear();
    for (const simulation::PairForce& f : plant_.forces()) {
      const world::Pair& pair = model_.pairs()[at(f.pair)];
      const int body_a = model_.geometries()[at(pair.geometry_a)].body, body_b = model_.geometries()[at(pair.geometry_b)].body;
      const bool a_is_robot = model_.bodies()[at(body_a)].kind == world::BodyKind::Robot;
      const bool b_is_robot = model_.bodies()[at(body_b)].kind == world::BodyKind::Robot;
      if (a_is_robot == b_is_robot || !(f.force_W.norm() > 0)) continue;
      simulation::PairForce on_robot = f;
      if (b_is_robot) on_robot.force_W = -f.force_W;  // it is given as acting on A
      forces_.push_back(on_robot);
      contacts_.push_back({.id = f.pair, .body = a_is_robot ? body_a : body_b, .p_WC = f.p_WC, .force_W = on_robot.force_W});
    }
  }

  void tick(double time) {
    control::ToolReference tool;
    const Eigen::VectorXd q = plant_.q().tail(model_.n_a());
    control::ControllerState state{.time = time, .q = q, .q_ref = scenario_.tool >= 0 ? scenario_.start : reference_, .contacts = told_};
    if (scenario_.tool >= 0) {
      tool = {.body = scenario_.tool, .X_BT = scenario_.X_BT, .X_WT = calc_tool_reference()};
      state.tool = &tool;
    }
    const auto started = std::chrono::steady_clock::now();
    const control::ControllerCommand& command = controller_.update(state, scenario_.period);
    tick_s_.push_back(std::chrono::duration<double>(std::chrono::steady_clock::now() - started).count());
    if (command.status != Status::Solved) ++out_.unsolved_ticks;
    record(time, q, tool, command);
    q_cmd_ = command.q_cmd;
  }

  world::Pose calc_tool_reference() const {
    const Eigen::Vector3d turn = reference_.tail<3>();
    const double angle = turn.norm();
    const Eigen::Matrix3d R = angle > 0 ? Eigen::AngleAxisd(angle, turn / angle).toRotationMatrix() : Eigen::Matrix3d::Identity();
    return {R * X_WT_start_.R, X_WT_start_.p + reference_.head<3>()};
  }

  void record(double time, const Eigen::VectorXd& q, const control::ToolReference& tool, const control::ControllerCommand& command) {
    ControlSample s;
    s.time = time;
    s.q = q, s.q_cmd = command.q_cmd, s.reference = reference_;
    s.torque = plant_.torque();
    s.forces = forces_;
    s.told = told_;
    for (const auto& f : forces_) s.largest_force = std::max(s.largest_force, f.force_W.norm());
    s.speed = plant_.v().tail(model_.n_a()).norm();
    if (scenario_.tool >= 0) {
      const world::Pose X_WT = calc_tool_pose();
      s.error = (tool.X_WT.p - X_WT.p).norm();
      s.angle_error = std::abs(Eigen::AngleAxisd(tool.X_WT.R * X_WT.R.transpose()).angle());
    } else {
      s.error = (q - reference_).norm();
    }
    if (scenario_.controller.law == control::Law::ContactAware) {
      for (Eigen::Index i = 0; i < command.qp.lambda.size(); ++i) {
        s.bounded = s.bounded || command.qp.lambda[i] > (1 - 1e-3) * scenario_.controller.lambda_max;
        s.slack = std::max(s.slack, command.qp.slack[i]);
      }
    } else {
      s.bounded = !command.taken.empty();
    }
    out_.samples.push_back(std::move(s));
  }

  const ControlScenario& scenario_;
  const world::Model& model_;
  const ControlRunOptions& options_;
  ControlRunResult& out_;
  simulation::DrivenPlant plant_;
  control::ContactController controller_;
  world::KinematicsWorkspace kinematics_work_;
  world::Kinematics kinematics_;
  world::Pose X_WT_start_;
  Eigen::VectorXd reference_, q_cmd_;
  struct Measured {
    Eigen::VectorXd q, external;
    std::vector<control::ContactForce> contacts;
  };
  std::optional<ContactEstimator> estimator_;
  std::deque<Measured> measured_;  ///< the oldest is what the controller is told of
  std::vector<control::ContactForce> contacts_, told_;
  std::vector<simulation::PairForce> forces_;
  std::vector<double> tick_s_, sense_s_;
};

}  // namespace

Status run_control(const ControlScenario& scenario, const ControlRunOptions& options, ControlRunResult& out) {
  options.validate();
  Run run(scenario, options, out);
  out.status = run.go();
  run.summarise();
  return out.status;
}

}  // namespace stiction::execution
