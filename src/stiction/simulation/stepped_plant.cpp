#include "stiction/simulation/stepped_plant.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "stiction/core/invalid_input.hpp"
#include "stiction/simulation/plant_impl.hpp"
#include "stiction/simulation/servos.hpp"

namespace stiction::simulation {

using core::Status;

namespace {
std::size_t at(Eigen::Index i) { return static_cast<std::size_t>(i); }
}  // namespace

struct SteppedPlant::Impl {
  std::shared_ptr<const Plant> plant;
  Servos servos;
  std::unique_ptr<mjData, DeleteMujoco> data;
  Eigen::VectorXd q, v, u, peak;
  std::vector<Push> pushes;
  long steps = 0;
  double largest_effort = 0, max_depth = 0;
  std::string message;

  explicit Impl(std::shared_ptr<const Plant> given) : plant(std::move(given)), servos(plant->impl()), data(mj_makeData(servos.mujoco())) {}

  double timestep() const { return plant->options().timestep; }

  /// Makes one timestep with the commands u, which move at u̇.
  bool step(const Eigen::VectorXd& commands, const Eigen::VectorXd& rate) {
    const Plant::Impl& p = plant->impl();
    servos.damp(*data);
    for (Eigen::Index j = 0; j < commands.size(); ++j) data->ctrl[p.actuator_id[at(j)]] = commands[j] + servos.lead()[j] * rate[j];
    servos.overcome_damping(*data);
    const auto good = [&](const world::MujocoReport& report) {
      message = find_fault(p, data.get(), report, static_cast<double>(steps) * timestep());
      return message.empty();
    };
    auto forward = [&] {
      if (!pushes.empty()) {
        mj_kinematics(servos.mujoco(), data.get());
        mj_comPos(servos.mujoco(), data.get());
        apply_pushes(p, pushes, data.get());
      }
      mj_forward(servos.mujoco(), data.get());
    };
    if (!good(world::call_mujoco(forward))) return false;
    watch();
    if (!good(world::call_mujoco([&] { mj_implicit(servos.mujoco(), data.get()); }))) return false;
    ++steps;
    return true;
  }

  void watch() {
    for (int c = 0; c < data->ncon; ++c) max_depth = std::max(max_depth, -data->contact[c].dist);
    raise_peaks(plant->impl(), data.get(), peak);
    const Eigen::VectorXd& effort = plant->model().effort();
    for (Eigen::Index j = 0; j < effort.size(); ++j)
      largest_effort = std::max(largest_effort, std::abs(data->actuator_force[plant->impl().actuator_id[at(j)]]) / effort[j]);
  }

  void read() {
    copy_from_qpos(plant->impl(), data->qpos, q);
    for (Eigen::Index i = 0; i < v.size(); ++i) v[i] = data->qvel[plant->impl().v_address[at(i)]];
  }
};

SteppedPlant::SteppedPlant(std::shared_ptr<const Plant> plant) {
  if (!plant) core::throw_invalid("plant", "nothing", "a plant");
  impl_ = std::make_unique<Impl>(std::move(plant));
  const Eigen::VectorXd q = impl_->plant->model().neutral();
  reset(q, q.tail(impl_->plant->model().n_a()));
}
SteppedPlant::~SteppedPlant() = default;
SteppedPlant::SteppedPlant(SteppedPlant&&) noexcept = default;

void SteppedPlant::reset(VectorRef q, VectorRef u) {
  Impl& d = *impl_;
  const world::Model& model = d.plant->model();
  world::require_configuration(model, "q", q);
  core::require_size("u", u.size(), model.n_a());
  core::require_finite("u", std::span(u.data(), at(u.size())));
  mj_resetData(d.plant->impl().mujoco.get(), d.data.get());
  start_at(d.plant->impl(), q, d.data.get());
  d.q.resize(model.n_q()), d.v.resize(model.n_v());
  d.u = u;
  d.peak.setZero(model.n_a());
  d.steps = 0;
  d.largest_effort = d.max_depth = 0;
  d.message.clear();
  d.pushes.clear();
  d.read();
}

void SteppedPlant::set_pushes(std::span<const Push> pushes) {
  require_pushes(plant().model(), pushes);
  impl_->pushes.assign(pushes.begin(), pushes.end());
  mju_zero(impl_->data->qfrc_applied, impl_->plant->impl().mujoco->nv);
}

Status SteppedPlant::advance(VectorRef u, double duration) {
  Impl& d = *impl_;
  core::require_size("u", u.size(), plant().model().n_a());
  core::require_finite("u", std::span(u.data(), at(u.size())));
  core::require_positive("duration", duration);
  if (!d.message.empty()) return Status::NumericalFailure;
  const long n = std::max(1L, std::lround(duration / d.timestep()));
  const Eigen::VectorXd change = u - d.u, rate = change / (static_cast<double>(n) * d.timestep());
  for (long k = 0; k < n; ++k) {
    if (!d.step(d.u + static_cast<double>(k) / static_cast<double>(n) * change, rate)) return Status::NumericalFailure;
  }
  d.u = u;
  d.read();
  return Status::Solved;
}

const Plant& SteppedPlant::plant() const { return *impl_->plant; }
double SteppedPlant::time() const { return static_cast<double>(impl_->steps) * impl_->timestep(); }
const Eigen::VectorXd& SteppedPlant::q() const { return impl_->q; }
const Eigen::VectorXd& SteppedPlant::v() const { return impl_->v; }
const Eigen::VectorXd& SteppedPlant::u() const { return impl_->u; }
double SteppedPlant::largest_effort() const { return impl_->largest_effort; }
Eigen::VectorXd SteppedPlant::take_torques() { return std::exchange(impl_->peak, Eigen::VectorXd::Zero(impl_->peak.size())); }
double SteppedPlant::max_depth() const { return impl_->max_depth; }
std::vector<PairForce> SteppedPlant::forces() const {
  std::vector<PairForce> out;
  read_forces(impl_->plant->impl(), impl_->data.get(), out);
  return out;
}
const std::string& SteppedPlant::message() const { return impl_->message; }

}  // namespace stiction::simulation
