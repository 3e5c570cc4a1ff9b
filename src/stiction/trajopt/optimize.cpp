#include "stiction/trajopt/optimize.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "stiction/core/invalid_input.hpp"
#include "stiction/core/overloaded.hpp"
#include "stiction/core/parallel.hpp"
#include "stiction/trajopt/stage_model.hpp"

namespace stiction::trajopt {

using core::Status;
using Eigen::VectorXd;
using world::Model;

namespace {

struct Trajectory {
  std::vector<VectorXd> q, u;
  CostTerms cost;
};

int thread_count(int threads) { return threads == 0 ? core::hardware_threads() : threads; }

}  // namespace

struct OptimizeWorkspace::Impl {
  Impl(const std::shared_ptr<const Model>& model, int threads) : pool(threads), rollout(model) {
    for (int i = 0; i < threads; ++i) models.emplace_back(model);
  }
  core::ThreadPool pool;
  std::vector<StageModelWorkspace> models;  // one per thread
  std::vector<Status> solved;               // status of the local model of each time
  dynamics::StepWorkspace rollout;
  dynamics::StepResult step;
  Trajectory nominal, trial, best;
  BoxLqProblem qp;
  BoxLqWorkspace qp_work;
  BoxLqResult qp_result;
};

OptimizeWorkspace::OptimizeWorkspace(std::shared_ptr<const Model> model, int threads)
    : impl_(std::make_unique<Impl>(model, thread_count(threads))) {}
OptimizeWorkspace::~OptimizeWorkspace() = default;
OptimizeWorkspace::OptimizeWorkspace(OptimizeWorkspace&&) noexcept = default;

std::vector<VectorXd> constant_inputs(const Model& model, VectorRef q, int horizon) {
  return {static_cast<std::size_t>(std::max(horizon, 0)), VectorXd(q.tail(model.n_a()))};
}
std::vector<VectorXd> constant_reference(VectorRef q, int horizon) {
  return {static_cast<std::size_t>(std::max(horizon, 0)) + 1, VectorXd(q)};
}

namespace {

std::string element(const char* name, std::size_t i) { return std::string(name) + "[" + std::to_string(i) + "]"; }

void validate(const Model& model, const OptimizeInput& in) {
  world::require_configuration(model, "q_start", in.q_start);
  if (in.u_guess.empty()) core::throw_invalid("u_guess", "no command", "at least one: the horizon is their number");
  for (std::size_t t = 0; t < in.u_guess.size(); ++t) {
    const VectorXd& u = in.u_guess[t];
    const std::string field = element("u_guess", t);
    core::require_size(field, u.size(), model.n_a());
    core::require_finite(field, std::span(u.data(), static_cast<std::size_t>(u.size())));
    for (int j = 0; j < model.n_a(); ++j) {
      if (u[j] < model.command_lower()[j] - 1e-9 || u[j] > model.command_upper()[j] + 1e-9) {
        core::throw_invalid(field + "[" + std::to_string(j) + "]", std::to_string(u[j]),
                            "inside the range of commands [" + std::to_string(model.command_lower()[j]) + ", " +
                                std::to_string(model.command_upper()[j]) + "]");
      }
    }
  }
  core::require_size("reference", static_cast<long>(in.reference.size()), static_cast<long>(in.u_guess.size()) + 1);
  for (std::size_t t = 0; t < in.reference.size(); ++t) {
    core::require_size(element("reference", t), in.reference[t].size(), model.n_q());
    world::require_configuration(model, element("reference", t), in.reference[t]);
  }
  if (in.u_before != nullptr) {
    core::require_size("u_before", in.u_before->size(), model.n_a());
    core::require_finite("u_before", std::span(in.u_before->data(), static_cast<std::size_t>(in.u_before->size())));
  }
}

class Optimizer {
 public:
  Optimizer(const Model& model, const OptimizeInput& in, const OptimizeOptions& options, const core::RunControl& control,
            OptimizeWorkspace::Impl& work, OptimizeResult& out)
      : model_(model),
        in_(in),
        options_(options),
        control_(control),
        w_(work),
        out_(out),
        T_(in.u_guess.size()),
        n_(model.n_v()),
        m_(model.n_a()),
        weights_(options.weights.expanded(model)),
        u_before_(in.u_before != nullptr ? *in.u_before : VectorXd(in.q_start.tail(model.n_a()))),
        exact_(options.step) {
    exact_.smoothing = dynamics::Exact{};
    exact_.with_A = exact_.with_B = exact_.with_force_derivatives = false;
    exact_.joint_limits = options.step.joint_limits;
  }

  Status run() {
    started_ = core::RunControl::Clock::now();
    Status status = begin();
    if (status == Status::Solved) {
      for (int i = 0; i < options_.iterations; ++i) {
        if (control_.stop()) {
          status = control_.status_when_stopped();
          break;
        }
        const double before = w_.best.cost.total();
        if (!iterate(i)) {
          status = control_.status_when_stopped();
          break;
        }
        report(i + 1);
        const double gain = before - w_.best.cost.total();
        if (options_.tolerance > 0 && gain > 0 && gain < options_.tolerance * before) break;
      }
      keep_best();
    }
    out_.wall_s = elapsed();
    return out_.status = status;
  }

 private:
  double elapsed() const { return core::seconds_since(started_); }

  void report(int iteration) {
    if (!control_.on_progress) return;
    control_.on_progress({.iteration = iteration,
                          .fraction = static_cast<double>(iteration) / options_.iterations,
                          .best = w_.best.cost.total(),
                          .size = static_cast<long>(T_),
                          .elapsed_s = elapsed()});
  }

  /// Rolls out the guess.
  Status begin() {
    Trajectory& n = w_.nominal;
    n.q.assign(T_ + 1, in_.q_start);
    n.u = in_.u_guess;
    w_.trial = n;
    w_.rollout.forget();
    for (std::size_t t = 0; t < T_; ++t) {
      n.u[t] = n.u[t].cwiseMax(model_.command_lower()).cwiseMin(model_.command_upper());
      if (const Status status = advance(n, t); status != Status::Solved) return status;
    }
    n.cost = cost_of(n);
    w_.best = n;
    log({.cost = n.cost, .best = n.cost.total()});
    return Status::Solved;
  }

  CostTerms cost_of(const Trajectory& trajectory) const {
    return calc_cost(model_, weights_, in_.reference, trajectory.q, trajectory.u, u_before_);
  }

  /// Computes q_{t+1} with the exact dynamics.
  Status advance(Trajectory& trajectory, std::size_t t) {
    ++out_.steps;
    const Status status = dynamics::step(model_, {trajectory.q[t], trajectory.u[t]}, exact_, w_.rollout, w_.step);
    if (status == Status::Solved) trajectory.q[t + 1] = w_.step.q_next;
    return status;
  }

  void log(IterationLog entry) {
    entry.elapsed_s = elapsed();
    out_.history.push_back(entry);
  }

  /// @returns false if it was stopped before the end
  bool iterate(int i) {
    IterationLog entry;
    linearise(i, entry);
    if (control_.stop()) return false;
    const bool done = std::visit(
        core::Overloaded{[&](const SweepSolver& s) { return sweep(s, entry); }, [&](const RecedingSolver&) { return recede(entry); }},
        options_.solver);
    if (!done) return false;
    if (w_.nominal.cost.total() < w_.best.cost.total()) w_.best = w_.nominal;
    entry.cost = w_.nominal.cost;
    entry.best = w_.best.cost.total();
    log(entry);
    return true;
  }

  // ---- local models

  /// Computes the local models along the nominal trajectory, transported to the exact states, and the expansion of the cost.
  void linearise(int i, IterationLog& entry) {
    entry.sharpness = sharpness(scheme_of(options_, i, 0, T_));
    w_.solved.resize(T_);
    w_.qp.stages.resize(T_);
    w_.pool.run(static_cast<int>(T_), [&](int item, int worker) {
      const auto t = static_cast<std::size_t>(item);
      if (control_.stop()) return;
      const Trajectory& n = w_.nominal;
      LqStage& stage = w_.qp.stages[t];
      w_.solved[t] = calc_stage_model(model_, {n.q[t], n.u[t], n.q[t + 1]}, scheme_of(options_, i, t, T_), options_,
                                      w_.models[static_cast<std::size_t>(worker)], stage);
      expand_state_cost(model_, t + 1 < T_ ? weights_.Q : weights_.Qd, in_.reference[t + 1], n.q[t + 1], stage.q, stage.Q);
    });
    if (control_.stop()) return;
    out_.linearisations += static_cast<long>(T_);
    for (const Status solved : w_.solved) entry.failed_models += solved == Status::Solved ? 0 : 1;
    w_.qp.R = 2 * weights_.R;
  }

  // ---- bounds

  /// Input bound of joint j. With effort limits it is at most the deflection at which the motor reaches its effort limit.
  double bound(int j) const {
    const double most = options_.input_bound.size() == 1 ? options_.input_bound[0] : options_.input_bound[j];
    return options_.step.effort_limits ? std::min(most, model_.effort()[j] / model_.stiffness()[j]) : most;
  }

  /// Sets the bounds |u_t − q̄ᵃ_t| ≤ bound and the joint limits, as increments of ū_t. If a joint violates its limits by the tolerance of a
  /// step, the bounds still contain the nearest command.
  void fill_box(std::size_t t, bool with_nominal) {
    LqStage& stage = w_.qp.stages[t];
    stage.lower.resize(m_), stage.upper.resize(m_);
    for (int j = 0; j < m_; ++j) {
      const double qa = w_.nominal.q[t][model_.n_q() - model_.n_a() + j], u = w_.nominal.u[t][j];
      const double low = model_.command_lower()[j], high = model_.command_upper()[j];
      stage.lower[j] = std::clamp(qa - bound(j), low, high) - u;
      stage.upper[j] = std::clamp(qa + bound(j), low, high) - u;
      if (with_nominal) {  // keep the zero step feasible, so that a short enough step always lowers the cost
        stage.lower[j] = std::min(stage.lower[j], 0.0);
        stage.upper[j] = std::max(stage.upper[j], 0.0);
      }
    }
  }

  // ---- one QP per iteration

  bool sweep(const SweepSolver& solver, IterationLog& entry) {
    const Trajectory& n = w_.nominal;
    w_.qp.x0.setZero(n_);
    for (std::size_t t = 0; t < T_; ++t) {
      w_.qp.stages[t].r = n.u[t] - (t == 0 ? u_before_ : n.u[t - 1]);
      fill_box(t, true);
    }
    const Status status = solve_qp(w_.qp, entry);
    if (status == Status::NumericalFailure) return true;
    const double now = n.cost.total();
    double input = 0;
    for (const auto& stage : w_.qp.stages) input += 0.5 * stage.r.cwiseAbs2().dot(w_.qp.R);
    entry.predicted = input - w_.qp_result.cost;
    double length = 1;
    for (int k = 0; k <= solver.max_halvings; ++k, length *= 0.5) {
      if (control_.stop()) return false;
      if (follow(length) && w_.trial.cost.total() < now) {
        entry.length = length;
        std::swap(w_.nominal, w_.trial);
        break;
      }
    }
    return true;
  }

  Status solve_qp(const BoxLqProblem& qp, IterationLog& entry) {
    const BoxLqOptions options{.tolerance = options_.qp_tolerance * std::max(w_.nominal.cost.total(), 1e-12)};
    const Status status = solve_box_lq(qp, options, w_.qp_work, w_.qp_result);
    entry.qp_iterations += w_.qp_result.iterations;
    return status;
  }

  /// Rolls out the shortened inputs of the QP with the exact dynamics, with the QP's feedback on the deviation from its predicted states.
  bool follow(double length) {
    const Trajectory& n = w_.nominal;
    Trajectory& trial = w_.trial;
    VectorXd off(n_), off_u = VectorXd::Zero(m_);
    w_.rollout.forget();
    for (std::size_t t = 0; t < T_; ++t) {
      const LqStage& stage = w_.qp.stages[t];
      world::local(model_, n.q[t], trial.q[t], off);
      off -= length * w_.qp_result.x[t];
      VectorXd du = length * w_.qp_result.u[t];
      if (t > 0) {
        du.noalias() += w_.qp_result.gains[t].K_x * off;
        du.noalias() += w_.qp_result.gains[t].K_u * off_u;
      }
      du = du.cwiseMax(stage.lower).cwiseMin(stage.upper);
      off_u = du - length * w_.qp_result.u[t];
      trial.u[t] = (n.u[t] + du).cwiseMax(model_.command_lower()).cwiseMin(model_.command_upper());
      if (advance(trial, t) != Status::Solved) return false;
    }
    trial.cost = cost_of(trial);
    return true;
  }

  // ---- one QP per time

  bool recede(IterationLog& entry) {
    const Trajectory& n = w_.nominal;
    Trajectory& trial = w_.trial;
    for (std::size_t t = 0; t < T_; ++t) fill_box(t, false);
    w_.rollout.forget();
    BoxLqProblem rest;
    rest.R = w_.qp.R;
    rest.x0.resize(n_);
    rest.stages = w_.qp.stages;
    for (std::size_t j = 0; j < T_; ++j) {
      if (control_.stop()) return false;
      world::local(model_, n.q[j], trial.q[j], rest.x0);
      for (std::size_t t = j; t < T_; ++t) rest.stages[t - j].r = n.u[t] - (t == j ? VectorXd(trial.q[j].tail(m_)) : n.u[t - 1]);
      if (solve_qp(rest, entry) == Status::NumericalFailure) return true;
      trial.u[j] = (n.u[j] + w_.qp_result.u[0]).cwiseMax(model_.command_lower()).cwiseMin(model_.command_upper());
      if (advance(trial, j) != Status::Solved) return true;
      rest.stages.erase(rest.stages.begin());
    }
    trial.cost = cost_of(trial);
    entry.length = 1;
    std::swap(w_.nominal, w_.trial);
    return true;
  }

  // ---- result

  /// Repeats the best trajectory to collect its contacts: the same steps from the same start give the same bits.
  void keep_best() {
    out_.u = w_.best.u;
    out_.q = w_.best.q;
    out_.cost = w_.best.cost;
    out_.contacts.assign(T_, {});
    w_.rollout.forget();
    for (std::size_t t = 0; t < T_; ++t) {
      if (advance(w_.best, t) != Status::Solved) return;
      for (const auto& contact : w_.step.contacts) {
        if (contact.active) out_.contacts[t].push_back(contact);
      }
    }
  }

  const Model& model_;
  const OptimizeInput& in_;
  const OptimizeOptions& options_;
  const core::RunControl& control_;
  OptimizeWorkspace::Impl& w_;
  OptimizeResult& out_;
  const std::size_t T_;
  const Eigen::Index n_, m_;
  const Weights weights_;
  const VectorXd u_before_;
  dynamics::StepOptions exact_;
  core::RunControl::Clock::time_point started_;
};

}  // namespace

Status optimize(const Model& model, const OptimizeInput& in, const OptimizeOptions& options, const core::RunControl& control,
                OptimizeWorkspace& work, OptimizeResult& out) {
  options.validate(model);
  validate(model, in);
  out = {};
  return Optimizer(model, in, options, control, work.impl(), out).run();
}

}  // namespace stiction::trajopt
