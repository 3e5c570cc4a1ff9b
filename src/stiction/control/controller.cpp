#include "stiction/control/controller.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "stiction/control/baseline.hpp"
#include "stiction/control/contact_filter.hpp"
#include "stiction/core/invalid_input.hpp"
#include "stiction/world/point_jacobian.hpp"

namespace stiction::control {

using core::Status;
using Eigen::Index;
using Eigen::Vector3d;

void ControllerOptions::validate() const {
  qp.validate();
  damping.validate();
  core::require_positive("lambda_max", lambda_max);
  core::require_nonnegative("force_threshold", force_threshold);
  if (!(force_threshold < lambda_max))
    core::throw_invalid("force_threshold", std::to_string(force_threshold), "less than lambda_max, " + std::to_string(lambda_max));
  core::require_nonnegative("force_time_constant", force_time_constant);
  core::require_positive("release_time", release_time);
  core::require_nonnegative("posture_time_constant", posture_time_constant);
  if (max_contacts < 0 || max_contacts > kMaxContacts)
    core::throw_invalid("max_contacts", std::to_string(max_contacts), "an integer from 0 to " + std::to_string(kMaxContacts));
  core::require_positive("revolute_speed", revolute_speed);
  core::require_positive("prismatic_speed", prismatic_speed);
  core::require_positive("tool_length", tool_length);
}

ControllerOptions make_early_form(ControllerOptions options) {
  constexpr double kCutoff_Hz = 0.5, kThreshold = 10.0 / 15;
  options.law = Law::ForceEquality;
  options.force_threshold = kThreshold * options.lambda_max;
  options.force_time_constant = 1 / (2 * std::numbers::pi * kCutoff_Hz);
  options.max_contacts = 1;
  return options;
}

namespace {
constexpr double kEarlyRate = 0.1;    ///< weight of ‖q_cmd − q_cmd⁻‖² in the early form
constexpr double kLeastBound = 1e-3;  ///< smallest share of its bound that a wall keeps after the arm has come into it: bounds are positive
constexpr double kMostExcess = 0.5;   ///< largest share of the bound by which (C.18) lowers it
}  // namespace

struct ContactController::Impl {
  std::shared_ptr<const world::Model> model;
  ControllerOptions options;
  Eigen::VectorXd speed;
  RobotLimits robot;
  ForceDamping damping;
  ControllerCommand command;
  double last_time = -std::numeric_limits<double>::infinity();
  struct Predicted {
    int id;
    double force, at_rest;  ///< predicted for the next tick; the same for springs at rest [N]
  };
  std::vector<Predicted> predicted;  // contacts of the last tick

  ContactFilter filter;
  double release_damping = 0;  // w while a lost contact is released, and afterwards (C.17)
  bool touched = false;        // a contact was in the model of the last tick
  std::vector<char> seen;      // per contact in `taken`: whether it is measured now
  std::vector<int> groups;     // per contact in `taken`: 0 measured; > 0 set that excludes the other sets; < 0 unseen, a group of its own

  // Scratch
  world::KinematicsWorkspace kinematics_work;
  world::Kinematics kinematics;
  ContactQpWorkspace qp_work;
  BaselineWorkspace baseline_work;
  Eigen::VectorXd q_full, wanted, lambda, lambda_max, null_command;
  RowMatrix J_u, J_point, E, H;
  Eigen::VectorXd e;

  explicit Impl(std::shared_ptr<const world::Model> made, const ControllerOptions& given)
      : model(std::move(made)), options(given), damping(given.damping), filter(options), kinematics_work(*model) {
    const Index n = model->n_a(), m = options.max_contacts;
    robot = {.stiffness = model->stiffness(),
             .rate = Eigen::VectorXd::Ones(n),
             .lower = model->lower(),
             .upper = model->upper(),
             .torque =
                 options.torque.size() > 0 ? options.torque : Eigen::VectorXd::Constant(n, std::numeric_limits<double>::infinity()).eval()};
    robot.validate();
    speed.resize(n);
    for (Index j = 0; j < n; ++j) {
      const bool turns = model->dofs()[static_cast<std::size_t>(model->n_vu() + j)].kind == world::DofKind::Revolute;
      speed[j] = turns ? options.revolute_speed : options.prismatic_speed;
    }
    q_full = model->neutral();
    qp_work.reserve(n, m);
    baseline_work.reserve(n, m);
    J_u.setZero(m, n), J_point.setZero(6, n), E.setZero(6, n), e.setZero(6), H.setZero(n, n);
    lambda.setZero(m), lambda_max.setZero(m), null_command.setZero(n), wanted.setZero(n);
    command.taken.reserve(static_cast<std::size_t>(m));
    groups.assign(static_cast<std::size_t>(m), 0), seen.assign(static_cast<std::size_t>(m), 0);
    predicted.reserve(static_cast<std::size_t>(m));
  }

  void require(const ControllerState& state, double dt) const {
    core::require_positive("dt", dt);
    core::require_finite("time", state.time);
    if (!(state.speed_share > 0 && state.speed_share <= 1))
      core::throw_invalid("speed_share", std::to_string(state.speed_share), "a number in (0, 1]");
    core::require_size("q", state.q.size(), model->n_a());
    core::require_size("q_ref", state.q_ref.size(), model->n_a());
    for (Index j = 0; j < state.q.size(); ++j) core::require_finite("q", state.q[j]), core::require_finite("q_ref", state.q_ref[j]);
    for (const ContactForce& c : state.contacts) {
      require_link("contact.body", c.body);
      if (!c.p_WC.allFinite() || !c.force_W.allFinite()) core::throw_invalid("contact", "a number that is not finite", "finite numbers");
      if (c.lambda_max) core::require_positive("contact.lambda_max", *c.lambda_max);
      if (c.set < 0) core::throw_invalid("contact.set", std::to_string(c.set), "an integer ≥ 0");
    }
    if (state.tool == nullptr) return;
    require_link("tool.body", state.tool->body);
    for (const world::Pose* X : {&state.tool->X_BT, &state.tool->X_WT})
      if (!X->p.allFinite() || !X->R.allFinite()) core::throw_invalid("tool", "a number that is not finite", "finite poses");
  }

  void require_link(const char* field, int body) const {
    const bool exists = body >= 0 && body < static_cast<int>(model->bodies().size());
    if (!exists || model->bodies()[static_cast<std::size_t>(body)].kind != world::BodyKind::Robot)
      core::throw_invalid(field, std::to_string(body), "the index of a robot's link");
  }

  /// Compliance of the arm at a contact, J_u K⁻¹ J_uᵀ [m/N]. @param row  index of the row of J_u
  double calc_softness(Index row) const {
    double out = 0;
    for (Index j = 0; j < J_u.cols(); ++j) out += J_u(row, j) * J_u(row, j) / robot.stiffness[j];
    return out;
  }

  /// Distance by which tracking alone would move into a contact, −J_u (q_track − q) [m].
  double calc_advance(Index row, const ControllerState& state) const {
    double out = 0;
    for (Index j = 0; j < J_u.cols(); ++j) out -= J_u(row, j) * (null_command[j] - state.q[j]);
    return out;
  }

  /// A contact modelled as a wall at the place where it was last seen, (C.15).
  struct Wall {
    double beyond = 0;   ///< penetration of the arm into the wall, as a force of the joint springs [N]
    double allowed = 0;  ///< largest force on the wall [N]
    bool holds = false;  ///< whether tracking alone would exceed this force
  };
  /// @param row  index of the row of J_u    @param bound  λ_max [N]
  Wall calc_wall(FilteredContact& k, Index row, const ControllerState& state, double bound) const {
    Wall out;
    const double softness = calc_softness(row);
    if (!(softness > 0)) return out;
    out.beyond = -k.u.dot(k.contact.p_WC - k.p_W) / softness;
    const double demand = calc_advance(row, state) / softness + out.beyond;
    if (k.seen) k.demand = demand;
    out.allowed = bound * (1 + k.unseen_for / options.release_time) + std::max(0.0, demand - k.demand);
    out.holds = demand > out.allowed;
    return out;
  }

  /// Part of a contact force that springs at rest do not explain: moving joints and contacts too weak to count cause it [N].              (C.18)
  double calc_excess(FilteredContact& k, double dt) {
    const auto last = std::find_if(predicted.begin(), predicted.end(), [&](const Predicted& p) { return p.id == k.contact.id; });
    if (last == predicted.end()) return 0;
    const double before = k.at_rest.value_or(last->at_rest);
    k.at_rest = before + dt / (options.force_time_constant + dt) * (last->at_rest - before);
    return k.contact.force_W.norm() - *k.at_rest;
  }

  /// Fills the rows (5.4) of the contacts that count: contacts above the threshold, and contacts that counted in the last tick, as long as
  /// their bound
  /// still limits the motion.     (C.15)
  void take_contacts(const ControllerState& state, double dt) {
    command.taken.clear();
    const bool gradual = options.law == Law::ContactAware && solve_tracking(state) == Status::Solved;
    for (FilteredContact& k : filter.known) {
      const double force = k.contact.force_W.norm(), bound = k.contact.lambda_max.value_or(options.lambda_max);
      const auto row = static_cast<Index>(command.taken.size());
      world::calc_point_jacobian(*model, kinematics, k.contact.body, k.contact.p_WC, J_point);
      for (Index j = 0; j < J_u.cols(); ++j) J_u(row, j) = k.u.dot(J_point.col(j).head<3>());
      const Wall wall = gradual ? calc_wall(k, row, state, bound) : Wall{};
      const bool felt = force >= options.force_threshold && force > 0 && (k.seen || !gradual);
      k.counts = felt || (k.counts && wall.holds);
      if (!k.counts) continue;
      const bool is_wall = gradual && !k.seen;
      command.taken.push_back(k.contact);
      groups[command.taken.size() - 1] = !k.seen ? -static_cast<int>(command.taken.size()) : k.contact.alternative ? 1 + k.contact.set : 0;
      seen[command.taken.size() - 1] = k.seen;
      lambda[row] = force;
      const double excess = gradual && k.seen ? std::clamp(calc_excess(k, dt), 0.0, kMostExcess * bound) : 0;
      lambda_max[row] = is_wall ? std::max(wall.allowed - wall.beyond, kLeastBound * wall.allowed) : bound - excess;
    }
    command.bound = lambda_max.head(static_cast<Index>(command.taken.size()));
    std::erase_if(filter.known, [&](const FilteredContact& k) { return !k.seen && !k.counts; });
  }

  /// ‖λ_pred − λ_est‖_∞ over the contacts that are measured now and were predicted in the last tick.
  double calc_force_error() const {
    double worst = 0;
    for (std::size_t k = 0; k < command.taken.size(); ++k) {
      for (const Predicted& p : predicted)
        if (seen[k] && p.id == command.taken[k].id) worst = std::max(worst, std::abs(p.force - lambda[static_cast<Index>(k)]));
    }
    return worst;
  }

  /// After the last contact is lost, the command catches up with the reference within the release time, in every direction.               (C.17)
  void calc_release_damping(double dt) {
    const auto end = seen.begin() + static_cast<std::ptrdiff_t>(command.taken.size());
    const bool felt = std::any_of(seen.begin(), end, [](char s) { return s != 0; });
    const double T = felt ? options.force_time_constant : options.release_time;
    release_damping = !felt && (touched || !command.taken.empty()) ? T / dt : release_damping * T / (T + dt);
    touched = !command.taken.empty();
  }

  /// Fills E and e of the tool at the measured joint positions: position divided by the tool length, then rotation vector.
  void calc_task(const ToolReference& tool) {
    const world::Pose& X_WB = kinematics.X_WB[static_cast<std::size_t>(tool.body)];
    const world::Pose X_WT = X_WB * tool.X_BT;
    world::calc_point_jacobian(*model, kinematics, tool.body, X_WT.p, E);
    E.topRows<3>() /= options.tool_length;
    e.head<3>() = (tool.X_WT.p - X_WT.p) / options.tool_length;
    const Eigen::AngleAxisd turn(tool.X_WT.R * X_WT.R.transpose());
    e.tail<3>() = turn.angle() * turn.axis();
  }

  /// Sets the wanted posture: the joint reference. If a tool is tracked, the posture approaches the reference with its time constant, so a
  /// deviation caused by contacts is not corrected in one tick.
  void calc_wanted(const ControllerState& state, double dt) {
    wanted = state.q_ref;
    if (state.tool != nullptr) wanted = command.q_cmd + dt / (options.posture_time_constant + dt) * (wanted - command.q_cmd);
  }

  ContactQpInput make_input(const ControllerState& state) {
    const auto m = static_cast<Index>(command.taken.size());
    ContactQpInput in{state.q,        command.q_cmd,      wanted,          J_u.topRows(m),
                      lambda.head(m), lambda_max.head(m), command.damping, std::span(groups.data(), command.taken.size())};
    if (state.tool != nullptr) in.task_jacobian = &E, in.task_error = &e;
    return in;
  }

  Status solve_contact_aware(const ControllerState& state) {
    const Status status = solve_contact_qp(robot, make_input(state), options.qp, qp_work, command.qp);
    predicted.clear();
    if (status == Status::NumericalFailure) return status;
    command.q_cmd = command.qp.q_cmd;
    for (std::size_t k = 0; k < command.taken.size(); ++k)
      if (seen[k])
        predicted.push_back({command.taken[k].id, command.qp.lambda[static_cast<Index>(k)], qp_work.lambda0[static_cast<Index>(k)]});
    return status;
  }

  /// Computes q_track, the best tracking command without contacts. @param rate  weight of ‖q_cmd − q_cmd⁻‖²; H then holds the factor of the
  /// cost
  Status solve_tracking(const ControllerState& state, double rate = 0) {
    const Index n = model->n_a();
    if (state.tool == nullptr && rate == 0) {
      null_command = wanted;
      return Status::Solved;
    }
    const double posture = state.tool == nullptr ? 1 : options.qp.posture_weight;
    H.setZero();
    for (Index j = 0; j < n; ++j) H(j, j) = posture + rate;
    null_command = posture * (wanted - state.q) + rate * (command.q_cmd - state.q);
    for (Index r = 0; r < 6 && state.tool != nullptr; ++r)
      for (Index j = 0; j < n; ++j) {
        null_command[j] += E(r, j) * e[r];
        for (Index k = 0; k < n; ++k) H(j, k) += E(r, j) * E(r, k);
      }
    if (!factor_cholesky(H, n)) return Status::NumericalFailure;
    solve_cholesky(H, n, null_command.data());
    null_command += state.q;
    return Status::Solved;
  }

  BaselineInput make_baseline_input(const ControllerState& state) const {
    const auto m = static_cast<Index>(command.taken.size());
    return {robot.stiffness, state.q, null_command, J_u.topRows(m), lambda_max.head(m)};
  }

  Status solve_null_space(const ControllerState& state) {
    if (solve_tracking(state) != Status::Solved) return Status::NumericalFailure;
    return control::solve_null_space(make_baseline_input(state), baseline_work, command.q_cmd);
  }

  Status solve_force_equality(const ControllerState& state) {
    if (solve_tracking(state, kEarlyRate) != Status::Solved) return Status::NumericalFailure;
    if (!command.taken.empty()) return control::solve_force_equality(make_baseline_input(state), H, baseline_work, command.q_cmd);
    command.q_cmd = null_command;
    return Status::Solved;
  }
};

ContactController::ContactController(std::shared_ptr<const world::Model> model, const ControllerOptions& options) {
  options.validate();
  if (model->n_a() == 0) core::throw_invalid("model", "a scene without a robot", "one with at least one joint");
  impl_ = std::make_unique<Impl>(std::move(model), options);
  configure(robot_part(*impl_->model, impl_->q_full));
}
ContactController::~ContactController() = default;
ContactController::ContactController(ContactController&&) noexcept = default;
const ControllerOptions& ContactController::options() const { return impl_->options; }

void ContactController::configure(VectorRef q) {
  core::require_size("q", q.size(), impl_->model->n_a());
  core::require_finite("q", std::span(q.data(), static_cast<std::size_t>(q.size())));
  impl_->command.q_cmd = q;
  impl_->command.status = Status::Solved;
  impl_->damping.reset();
  impl_->release_damping = 0;
  impl_->touched = false;
  impl_->predicted.clear();
  impl_->filter.known.clear();
  impl_->last_time = -std::numeric_limits<double>::infinity();
}

const ControllerCommand& ContactController::update(const ControllerState& state, double dt) {
  Impl& c = *impl_;
  c.require(state, dt);
  c.command.held = !(state.time > c.last_time);
  if (c.command.held) return c.command;
  c.last_time = state.time;
  c.robot.rate = dt * state.speed_share * c.speed;
  c.q_full.tail(c.model->n_a()) = state.q;
  calc_kinematics(*c.model, c.q_full, c.kinematics_work, c.kinematics);
  c.command.left_out = c.filter.update(state.contacts, c.kinematics, dt);
  c.calc_wanted(state, dt);
  if (state.tool != nullptr) c.calc_task(*state.tool);
  c.take_contacts(state, dt);
  c.calc_release_damping(dt);
  c.command.damping = std::max(c.damping.update(c.calc_force_error(), dt), c.release_damping);
  switch (c.options.law) {
    case Law::ContactAware:
      c.command.status = c.solve_contact_aware(state);
      break;
    case Law::Unconstrained:
      c.command.status = c.solve_tracking(state);
      if (c.command.status == Status::Solved) c.command.q_cmd = c.null_command;
      break;
    case Law::NullSpace:
      c.command.status = c.solve_null_space(state);
      break;
    case Law::ForceEquality:
      c.command.status = c.solve_force_equality(state);
      break;
  }
  return c.command;
}

}  // namespace stiction::control
