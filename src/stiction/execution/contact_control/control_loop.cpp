#include "stiction/execution/contact_control/control_loop.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <optional>

#include "stiction/core/invalid_input.hpp"
#include "stiction/core/processor_time.hpp"
#include "stiction/simulation/driven_plant.hpp"

namespace stiction::execution {

using core::Status;

namespace {

std::size_t at(Eigen::Index i) { return static_cast<std::size_t>(i); }

/// Controller options with the damping that estimated contacts need. The error (5.28) responds to a force with the lag of observer, low-pass, delay and tick.
/// Within this lag the command of a reference that asks for R λ_max adds the force R λ_max lag/T_w, with T_w = w_max h. w_max is such that this force is a
/// share of the bound. The force scale is a share of the least force that counts.                                                                   (C.14)
control::ControllerOptions make_controller_options(const ControlScenario& scenario, double filter) {
  constexpr double kShare = 0.125, kOfThreshold = 0.2;
  control::ControllerOptions out = scenario.controller;
  if (out.law == control::Law::ForceEquality) out = control::make_early_form(out);
  if (scenario.contacts == ContactSource::True) return out;
  const double lag = scenario.observer.time_constant + filter + scenario.delay + scenario.period;
  out.damping.largest = scenario.demand / kShare * lag / out.damping.period;
  out.damping.force_scale = kOfThreshold * out.force_threshold;
  const ContactEstimatorOptions& e = scenario.estimator;  // room for all contacts that the estimator reports, and as many walls
  out.max_contacts = std::clamp(2 * e.max_contacts * e.max_candidates, out.max_contacts, control::kMaxContacts);
  return out;
}

/// Processor time of this thread that f() takes [s].
template <class F>
double time_of(F&& f) {
  const double started = core::processor_time(CLOCK_THREAD_CPUTIME_ID);
  f();
  return core::processor_time(CLOCK_THREAD_CPUTIME_ID) - started;
}

}  // namespace

struct ControlLoop::Impl {
  /// Measurement that becomes known after the delay.
  struct Measured {
    Eigen::VectorXd q, external;
    std::vector<control::ContactForce> contacts;
    std::optional<sensing::BaseWrench> base;
  };

  Impl(const ControlScenario& s, std::shared_ptr<const world::Model> world_model)
      : scenario(s),
        model(*s.model),
        world(*world_model),
        plant(simulation::Plant::make(world_model, s.plant), s.impedance, is_estimated() ? std::optional(s.observer) : std::nullopt),
        estimator(is_estimated() ? std::make_optional<ContactEstimator>(s.model, make_estimator_options(s)) : std::nullopt),
        base_sensor(is_estimated() && s.estimator.base
                        ? std::make_optional<BaseSensor>(s.model->n_a(), s.period, s.observer, *s.estimator.base)
                        : std::nullopt),
        controller(s.model, make_controller_options(s, estimator ? estimator->time_constant() : 0)),
        kinematics_work(model) {
    if (!(s.period >= s.impedance.period))
      core::throw_invalid("controller.period", fmt::format("{} s", s.period),
                          fmt::format("at least {} s, the period of the impedance controller", s.impedance.period));
    core::require_size("world: joints", world.n_a(), model.n_a());
    core::require_size("world: configuration", world.n_q(), model.n_q());
    plant.reset(calc_start(s));
    controller.configure(s.start);
    q_cmd = s.start;
    if (s.tool >= 0) X_WT_start = calc_tool_pose();
    if (s.hand.body >= 0) X_WL_start = calc_pose(s.hand.body);
  }

  bool is_estimated() const { return scenario.contacts == ContactSource::Estimated; }

  world::Pose calc_pose(int body) {
    world::calc_kinematics(model, plant.q(), kinematics_work, kinematics);
    return kinematics.X_WB[at(body)];
  }

  world::Pose calc_tool_pose() { return calc_pose(scenario.tool) * scenario.X_BT; }

  world::Pose calc_tool_reference(const Eigen::VectorXd& reference) const {
    const Eigen::Vector3d turn = reference.tail<3>();
    const double angle = turn.norm();
    const Eigen::Matrix3d R = angle > 0 ? Eigen::AngleAxisd(angle, turn / angle).toRotationMatrix() : Eigen::Matrix3d::Identity();
    return {R * X_WT_start.R, X_WT_start.p + reference.head<3>()};
  }

  /// Reads the forces on robots by other bodies.
  void read_contacts() {
    contacts.clear(), forces.clear();
    for (const simulation::PairForce& f : plant.forces()) {
      const world::Pair& pair = world.pairs()[at(f.pair)];
      const int body_a = world.geometries()[at(pair.geometry_a)].body, body_b = world.geometries()[at(pair.geometry_b)].body;
      const bool a_is_robot = world.bodies()[at(body_a)].kind == world::BodyKind::Robot;
      const bool b_is_robot = world.bodies()[at(body_b)].kind == world::BodyKind::Robot;
      if (a_is_robot == b_is_robot || !(f.force_W.norm() > 0)) continue;
      simulation::PairForce on_robot = f;
      if (b_is_robot) on_robot.force_W = -f.force_W;  // the simulation gives the force on A
      forces.push_back(on_robot);
      contacts.push_back({.id = f.pair, .body = a_is_robot ? body_a : body_b, .p_WC = f.p_WC, .force_W = on_robot.force_W});
    }
  }

  /// Applies the forces of the hands until the next tick, and adds them to the forces on the robot.
  void press() {
    if (scenario.hand.body < 0 && held.body < 0) return;
    simulation::Push hand;
    if (scenario.hand.body >= 0) hand = calc_push(scenario.hand, X_WL_start, calc_pose(scenario.hand.body), time);
    const std::array pushes{hand, held};
    plant.set_pushes(pushes);
    for (std::size_t i = 0; i < pushes.size(); ++i) {
      const simulation::Push& push = pushes[i];
      if (push.body < 0 || push.force_W.isZero(0)) continue;
      const Eigen::Vector3d p_W = calc_pose(push.body) * push.p_BP;
      forces.push_back({.normal = push.force_W.norm(), .force_W = push.force_W, .p_WC = p_W});
      contacts.push_back({.id = static_cast<int>(world.pairs().size() + i), .body = push.body, .p_WC = p_W, .force_W = push.force_W});
    }
  }

  /// Sets the contacts known after the delay: as a skin would measure them, or estimated from torques.
  void measure() {
    const Eigen::VectorXd q = plant.q().tail(model.n_a());
    measured.push_back(
        {q, plant.observed(), contacts, base_sensor ? std::optional(base_sensor->update(plant.base_wrench(), q)) : std::nullopt});
    const auto delay = static_cast<std::size_t>(std::lround(scenario.delay / scenario.period));
    if (measured.size() > delay + 1) measured.pop_front();
    if (measured.size() <= delay) {
      reported.clear();
      return;
    }
    const Measured& m = measured.front();
    told = m.external;
    if (!is_estimated()) {
      reported = m.contacts;
      return;
    }
    sense_s.push_back(time_of([&] {
      const auto estimated = estimator->update(m.q, m.external, q, scenario.period, m.base ? &*m.base : nullptr);
      reported.assign(estimated.begin(), estimated.end());
    }));
  }

  void command(const Eigen::VectorXd& reference, ControlSample& out) {
    control::ToolReference tool;
    const Eigen::VectorXd q = plant.q().tail(model.n_a());
    control::ControllerState state{.time = time, .q = q, .q_ref = scenario.tool >= 0 ? scenario.start : reference, .contacts = reported};
    state.speed_share = speed_share;
    if (scenario.tool >= 0) {
      tool = {.body = scenario.tool, .X_BT = scenario.X_BT, .X_WT = calc_tool_reference(reference)};
      state.tool = &tool;
    }
    const control::ControllerCommand* command = nullptr;
    update_s.push_back(time_of([&] { command = &controller.update(state, scenario.period); }));
    if (command->status != Status::Solved) ++unsolved;
    record(q, reference, tool, *command, out);
    q_cmd = command->q_cmd;
  }

  void record(const Eigen::VectorXd& q, const Eigen::VectorXd& reference, const control::ToolReference& tool,
              const control::ControllerCommand& command, ControlSample& out) {
    out = {.time = time,
           .q = q,
           .q_cmd = command.q_cmd,
           .reference = reference,
           .external = told,
           .torque = plant.torque(),
           .forces = forces,
           .reported = reported};
    for (const auto& f : forces) out.largest_force = std::max(out.largest_force, f.force_W.norm());
    out.speed = plant.v().tail(model.n_a()).norm();
    if (scenario.tool >= 0) {
      const world::Pose X_WT = calc_tool_pose();
      out.error = (tool.X_WT.p - X_WT.p).norm();
      out.angle_error = std::abs(Eigen::AngleAxisd(tool.X_WT.R * X_WT.R.transpose()).angle());
    } else {
      out.error = (q - reference).norm();
    }
    if (scenario.controller.law == control::Law::ContactAware) {
      for (Eigen::Index i = 0; i < command.qp.lambda.size(); ++i) {
        out.bounded = out.bounded || command.qp.lambda[i] > (1 - 1e-3) * command.bound[i];
        out.slack = std::max(out.slack, command.qp.slack[i]);
      }
    } else {
      out.bounded = !command.taken.empty();
    }
  }

  const ControlScenario& scenario;
  const world::Model &model, &world;
  simulation::DrivenPlant plant;
  std::optional<ContactEstimator> estimator;
  std::optional<BaseSensor> base_sensor;
  control::ContactController controller;
  world::KinematicsWorkspace kinematics_work;
  world::Kinematics kinematics;
  world::Pose X_WT_start, X_WL_start;  ///< poses at the start of the tool, and of the link that a hand presses on
  simulation::Push held;
  Eigen::VectorXd q_cmd, told;
  std::deque<Measured> measured;  ///< the controller gets the oldest one
  std::vector<control::ContactForce> contacts, reported;
  std::vector<simulation::PairForce> forces;
  std::vector<double> update_s, sense_s;
  double time = 0, speed_share = 1;
  long ticks = 0;
  int unsolved = 0;
};

ControlLoop::ControlLoop(const ControlScenario& scenario, std::shared_ptr<const world::Model> world)
    : impl_(std::make_unique<Impl>(scenario, std::move(world))) {}
ControlLoop::~ControlLoop() = default;
ControlLoop::ControlLoop(ControlLoop&&) noexcept = default;

Status ControlLoop::tick(const Eigen::VectorXd& reference, ControlSample& out) {
  Impl& loop = *impl_;
  loop.read_contacts();
  loop.press();
  loop.measure();
  loop.command(reference, out);
  loop.time = static_cast<double>(++loop.ticks) * loop.scenario.period;
  return loop.plant.advance(loop.q_cmd, loop.time - loop.plant.time());  // the impedance controller may have other periods
}

void ControlLoop::hold_push(const simulation::Push& push) {
  impl_->plant.set_push(push);  // throws if the push is invalid
  impl_->held = push;
}

void ControlLoop::limit_speed(double share) { impl_->speed_share = share; }

double ControlLoop::time() const { return impl_->time; }
const Eigen::VectorXd& ControlLoop::q() const { return impl_->plant.q(); }
const world::Model& ControlLoop::world() const { return impl_->world; }
const std::string& ControlLoop::message() const { return impl_->plant.message(); }
double ControlLoop::lag() const {
  return impl_->estimator ? impl_->scenario.observer.time_constant + impl_->estimator->time_constant() : 0;
}
int ControlLoop::unsolved_ticks() const { return impl_->unsolved; }
const std::vector<double>& ControlLoop::update_times() const { return impl_->update_s; }
const std::vector<double>& ControlLoop::sense_times() const { return impl_->sense_s; }

}  // namespace stiction::execution
