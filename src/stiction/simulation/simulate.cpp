#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "stiction/core/invalid_input.hpp"
#include "stiction/simulation/plant_impl.hpp"
#include "stiction/simulation/servos.hpp"

namespace stiction::simulation {

using core::Status;

struct Workspace::Impl {
  std::shared_ptr<const Plant> plant;
  Servos servos;
  std::unique_ptr<mjData, DeleteMujoco> data;

  explicit Impl(std::shared_ptr<const Plant> given) : plant(std::move(given)), servos(plant->impl()) {}
};

Workspace::Workspace(std::shared_ptr<const Plant> plant) : impl_(std::make_unique<Impl>(std::move(plant))) {}
Workspace::~Workspace() = default;
Workspace::Workspace(Workspace&&) noexcept = default;

void SimulationOptions::validate() const { core::require_positive("record_interval", record_interval); }

namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

void validate(const world::Model& model, const SimulationInput& in) {
  world::require_configuration(model, "q0", in.q0);
  if (in.times.size() < 1) core::throw_invalid("times", "no knot", "at least one");
  core::require_size("u.cols", in.u.cols(), in.times.size());
  core::require_size("u.rows", in.u.rows(), model.n_a());
  core::require_finite("times", std::span(in.times.data(), static_cast<std::size_t>(in.times.size())));
  if (!in.u.allFinite()) core::throw_invalid("u", "a number that is not finite", "finite numbers");
  if (in.times[0] != 0) core::throw_invalid("times[0]", fmt::format("{}", in.times[0]), "0");
  for (Eigen::Index k = 1; k < in.times.size(); ++k) {
    if (!(in.times[k] > in.times[k - 1])) {
      core::throw_invalid(fmt::format("times[{}]", k), fmt::format("{}", in.times[k]), fmt::format("more than {}", in.times[k - 1]));
    }
  }
  if (in.v0 == nullptr) return;
  core::require_size("v0", in.v0->size(), model.n_v());
  if (!in.v0->allFinite()) core::throw_invalid("v0", "a number that is not finite", "finite numbers");
}

/// Computes u(t) + K_a⁻¹ D u̇(t) at increasing times: with this command a spring with damping −D q̇ acts as one with damping D (u̇ − q̇).
class Commands {
 public:
  explicit Commands(const SimulationInput& in) : in_(in) {}

  /// @param lead  K_a⁻¹ D of the joint [s], or 0
  double operator()(int joint, double t, double lead) {
    const Eigen::Index last = in_.times.size() - 1;
    while (knot_ < last && t >= in_.times[knot_ + 1]) ++knot_;
    if (knot_ == last) return in_.u(joint, last);
    const double duration = in_.times[knot_ + 1] - in_.times[knot_], change = in_.u(joint, knot_ + 1) - in_.u(joint, knot_);
    return in_.u(joint, knot_) + (t - in_.times[knot_] + lead) / duration * change;
  }

 private:
  const SimulationInput& in_;
  Eigen::Index knot_ = 0;
};

/// One simulation in progress.
class Run {
 public:
  Run(const Plant::Impl& plant, const SimulationInput& in, const SimulationOptions& options, Servos& servos, mjData* data,
      SimulationResult& out)
      : plant_(plant), in_(in), options_(options), servos_(servos), d_(data), out_(out), commands_(in) {
    const double h = plant.options.timestep, end = in.times[in.times.size() - 1];
    constexpr double kMostSteps = 1e12, kMostSamples = 1e7;
    if (!(end / h < kMostSteps) || !(end / std::max(h, options.record_interval) < kMostSamples))
      core::throw_invalid("times", fmt::format("a motion of {:.3g} s, recorded every {:g} s", end, options.record_interval),
                          fmt::format("at most {:g} records; a higher speed, or a longer record_interval", kMostSamples));
    steps_ = static_cast<long>(std::ceil(end / h * (1 - 1e-12)));
    stride_ = std::max(1L, std::lround(options.record_interval / h));
    const auto samples = static_cast<std::size_t>(steps_ / stride_ + 2);
    out.times.clear(), out.forces.clear();
    out.times.reserve(samples), out.forces.reserve(samples);
    out.q.resize(plant.model->n_q(), static_cast<Eigen::Index>(samples));
    out.v.resize(plant.model->n_v(), static_cast<Eigen::Index>(samples));
    out.torque.resize(plant.model->n_a(), static_cast<Eigen::Index>(samples));
    peak_.setZero(plant.model->n_a());
    out.message.clear();
    out.max_depth = 0;
    out.steps = 0;
    start();
  }

  Status go() {
    const Status status = loop();
    const auto n = static_cast<Eigen::Index>(out_.times.size());
    out_.q.conservativeResize(Eigen::NoChange, n);
    out_.v.conservativeResize(Eigen::NoChange, n);
    out_.torque.conservativeResize(Eigen::NoChange, n);
    return status;
  }

 private:
  void start() {
    start_at(plant_, in_.q0, d_);
    if (in_.v0 == nullptr) return;
    for (int i = 0; i < plant_.model->n_v(); ++i) d_->qvel[plant_.v_address[at(i)]] = (*in_.v0)[i];
  }

  Status loop() {
    const double h = plant_.options.timestep;
    for (long k = 0;; ++k) {
      if (options_.control != nullptr && options_.control->cancelled()) return Status::Cancelled;
      if (options_.control != nullptr && options_.control->expired()) return Status::MaxIterations;
      // Times are multiples of the timestep, not sums, so that knots are met exactly.
      const double t = static_cast<double>(k) * h;
      servos_.damp(*d_);
      for (int j = 0; j < plant_.model->n_a(); ++j) d_->ctrl[plant_.actuator_id[at(j)]] = commands_(j, t, servos_.lead()[j]);
      servos_.overcome_damping(*d_);
      const bool last = k == steps_;
      const auto report = world::call_mujoco([this] { mj_forward(servos_.mujoco(), d_); });
      if (!is_good(report)) return Status::NumericalFailure;
      for (int c = 0; c < d_->ncon; ++c) out_.max_depth = std::max(out_.max_depth, -d_->contact[c].dist);
      raise_peaks(plant_, d_, peak_);
      const bool sample = k % stride_ == 0 || last;
      if (sample) record(t);
      if (last || (sample && options_.stop && options_.stop(t, out_.q.col(static_cast<Eigen::Index>(out_.times.size()) - 1))))
        return Status::Solved;
      const auto integrated = world::call_mujoco([this] { mj_implicit(servos_.mujoco(), d_); });
      if (!is_good(integrated)) return Status::NumericalFailure;
      ++out_.steps;
    }
  }

  bool is_good(const world::MujocoReport& report) {
    out_.message = find_fault(plant_, d_, report, static_cast<double>(out_.steps) * plant_.options.timestep);
    return out_.message.empty();
  }

  void record(double t) {
    const auto column = static_cast<Eigen::Index>(out_.times.size());
    out_.times.push_back(t);
    copy_from_qpos(plant_, d_->qpos, out_.q.col(column));
    for (int i = 0; i < plant_.model->n_v(); ++i) out_.v(i, column) = d_->qvel[plant_.v_address[at(i)]];
    out_.torque.col(column) = peak_;
    peak_.setZero();
    read_forces(plant_, d_, out_.forces.emplace_back());
  }

  const Plant::Impl& plant_;
  const SimulationInput& in_;
  const SimulationOptions& options_;
  Servos& servos_;
  mjData* d_;
  SimulationResult& out_;
  Commands commands_;
  Eigen::VectorXd peak_;  // largest torques since the last sample
  long steps_ = 0;
  long stride_ = 1;
};

}  // namespace

Status simulate(const Plant& plant, const SimulationInput& input, const SimulationOptions& options, Workspace& work,
                SimulationResult& out) {
  options.validate();
  validate(plant.model(), input);
  Workspace::Impl& w = work.impl();
  if (w.plant.get() != &plant) core::throw_invalid("work", "a workspace of another plant", "one of this plant");
  const auto started = std::chrono::steady_clock::now();
  const mjModel* m = plant.impl().mujoco.get();
  if (w.data == nullptr) {
    w.data.reset(mj_makeData(m));
  } else {
    mj_resetData(m, w.data.get());
  }
  out.status = Run(plant.impl(), input, options, w.servos, w.data.get(), out).go();
  // After an error the state of MuJoCo's scratch is undefined.
  if (out.status == Status::NumericalFailure) w.data.reset();
  out.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - started).count();
  return out.status;
}

}  // namespace stiction::simulation
