#include "stiction/simulation/driven_plant.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "stiction/core/invalid_input.hpp"
#include "stiction/simulation/plant_impl.hpp"
#include "stiction/world/call_mujoco.hpp"

namespace stiction::simulation {

using core::Status;

namespace {
std::size_t at(Eigen::Index i) { return static_cast<std::size_t>(i); }
}  // namespace

struct DrivenPlant::Impl {
  std::shared_ptr<const Plant> plant;
  std::unique_ptr<mjData, DeleteMujoco> data;
  ImpedanceController impedance;
  int steps_per_period = 1;
  long periods = 0;
  std::vector<Push> pushes;
  Eigen::VectorXd q, v, torque, external, q_a, v_a, inertia;
  std::optional<MomentumObserver> observer;
  std::vector<mjtNum> last_M;                 ///< mass matrix at the last update of the observer; empty before the first
  Eigen::VectorXd last_n, momentum, n, zero;  ///< passive forces − bias at that update; arguments of the observer
  std::vector<mjtNum> product;
  std::vector<PairForce> forces, acting;  ///< forces at the end of the last step; forces acting in it
  Eigen::Matrix<double, 6, 1> wrench = Eigen::Matrix<double, 6, 1>::Zero(),
                              summed = wrench;  ///< of base_wrench(); over the steps of a period
  std::string message;

  Impl(std::shared_ptr<const Plant> given, const ImpedanceOptions& options, const std::optional<ObserverOptions>& observing)
      : plant(std::move(given)), data(mj_makeData(plant->impl().mujoco.get())), impedance(plant->model().stiffness(), options) {
    const world::Model& model = plant->model();
    if (plant->options().damping_ratio != 0)
      core::throw_invalid("plant.damping_ratio", fmt::format("{}", plant->options().damping_ratio), "0: the impedance controller damps");
    const double steps = options.period / plant->options().timestep;
    steps_per_period = static_cast<int>(std::lround(steps));
    if (steps_per_period < 1 || std::abs(steps - steps_per_period) > 1e-9 * steps)
      core::throw_invalid("impedance.period", fmt::format("{} s", options.period),
                          fmt::format("whole timesteps of {} s", plant->options().timestep));
    q.setZero(model.n_q()), v.setZero(model.n_v());
    for (Eigen::VectorXd* x : {&torque, &external, &q_a, &v_a, &inertia, &last_n, &momentum, &n, &zero}) x->setZero(model.n_a());
    if (observing) observer.emplace(model.n_a(), options.period, *observing);
    product.resize(at(plant->impl().mujoco->nv));
    last_M.reserve(at(plant->impl().mujoco->nC));
  }

  int v_address(Eigen::Index joint) const { return plant->impl().v_address[at(plant->model().n_vu() + joint)]; }

  /// State, forces and the diagonal of the mass matrix after positions and velocities were evaluated.
  void read() {
    const Plant::Impl& p = plant->impl();
    copy_from_qpos(p, data->qpos, q);
    for (Eigen::Index i = 0; i < v.size(); ++i) v[i] = data->qvel[p.v_address[at(i)]];
    q_a = q.tail(q_a.size());
    for (Eigen::Index j = 0; j < q_a.size(); ++j) {
      const int address = v_address(j);
      v_a[j] = data->qvel[address];
      external[j] = data->qfrc_constraint[address] + data->qfrc_applied[address];
      inertia[j] = data->M[p.mujoco->M_rowadr[address] + p.mujoco->M_rownnz[address] - 1];  // lower triangle by rows
    }
  }

  /// The robot's part of M v, for a mass matrix stored as the rows of its lower triangle.
  void multiply_mass(const mjtNum* M, Eigen::VectorXd& out) {
    const mjModel* m = plant->impl().mujoco.get();
    std::fill(product.begin(), product.end(), 0);
    for (int i = 0; i < m->nv; ++i)
      for (int k = m->M_rowadr[i]; k < m->M_rowadr[i] + m->M_rownnz[i]; ++k) {
        const int j = m->M_colind[k];
        product[at(i)] += M[k] * data->qvel[j];
        if (i != j) product[at(j)] += M[k] * data->qvel[i];
      }
    for (Eigen::Index j = 0; j < out.size(); ++j) out[j] = product[at(v_address(j))];
  }

  /// Joint friction that the observer compensates.
  void take_off_friction() {
    const ObserverOptions& known = observer->options();
    if (known.coulomb.size() > 0) {
      n -= known.coulomb.cwiseProduct((v_a / known.stiction_speed).array().tanh().matrix()) + known.viscous.cwiseProduct(v_a);
      return;
    }
    const std::optional<double>& error = known.friction_error;
    if (!error || !plant->options().joint_friction) return;
    const world::Model& model = plant->model();
    for (Eigen::Index j = 0; j < n.size(); ++j) {
      const world::Dof& dof = model.dofs()[at(model.n_vu() + j)];
      n[j] -= (1 + *error) * (dof.friction * std::tanh(v_a[j] / known.stiction_speed) + dof.damping * v_a[j]);
    }
  }

  /// (C.11) over the period that ends now: Cᵀ v = Ṁ v − C v, and C v + g is MuJoCo's bias, which passive forces compensate.
  void observe() {
    const mjModel* m = plant->impl().mujoco.get();
    const double known = 1 + observer->options().inertia_error, period = impedance.options().period;
    multiply_mass(data->M, momentum);
    momentum *= known;
    if (last_M.empty()) {
      observer->start(momentum);
    } else {
      multiply_mass(last_M.data(), n);
      n = (momentum - known * n) / period + last_n;
      take_off_friction();
      observer->update(momentum, n, torque, q_a);
    }
    last_M.assign(data->M, data->M + m->nC);
    for (Eigen::Index j = 0; j < n.size(); ++j) {
      const int address = v_address(j);
      last_n[j] = data->qfrc_passive[address] - data->qfrc_damper[address] - known * data->qfrc_bias[address];  // friction unknown to it
    }
  }

  bool is_robot(int geometry) const {
    const world::Model& model = plant->model();
    return model.bodies()[at(model.geometries()[at(geometry)].body)].kind == world::BodyKind::Robot;
  }

  /// Collects the forces that anything else exerted on the robots in the last step.
  void add_wrench() {
    const auto add = [&](const Eigen::Vector3d& p_W, const Eigen::Vector3d& f_W) {
      summed.head<3>() += f_W;
      summed.tail<3>() += p_W.cross(f_W);
    };
    read_forces(plant->impl(), data.get(), acting);
    for (const PairForce& f : acting) {
      const world::Pair& pair = plant->model().pairs()[at(f.pair)];
      const bool a = is_robot(pair.geometry_a), b = is_robot(pair.geometry_b);
      if (a != b) add(f.p_WC, a ? f.force_W : -f.force_W);
    }
    for (const Push& push : pushes) {
      if (push.body < 0 || plant->model().bodies()[at(push.body)].kind != world::BodyKind::Robot) continue;
      const int body = plant->impl().body_id[at(push.body)];
      const Eigen::Map<const Eigen::Matrix<mjtNum, 3, 3, Eigen::RowMajor>> R(data->xmat + 9 * body);
      add(R * push.p_BP + Eigen::Map<const Eigen::Vector3d>(data->xpos + 3 * body), push.force_W);
    }
  }

  /// Applies the lag of the observer to the base wrench, once per period.
  void delay_wrench() {
    const double period = impedance.options().period;
    wrench += period / (observer->options().time_constant + period) * (summed / steps_per_period - wrench);
    summed.setZero();
  }

  /// Writes torques as position controls: u is chosen such that the spring K (u − q) exerts the torque.
  void write_torque() {
    const Eigen::VectorXd& K = plant->model().stiffness();
    for (Eigen::Index j = 0; j < q_a.size(); ++j)
      data->ctrl[plant->impl().actuator_id[at(j)]] = data->qpos[q_address(j)] + torque[j] / K[j];
  }

  int q_address(Eigen::Index joint) const {
    const mjModel* m = plant->impl().mujoco.get();
    return m->jnt_qposadr[m->dof_jntid[v_address(joint)]];
  }

  bool step(VectorRef command, bool first) {
    const mjModel* m = plant->impl().mujoco.get();
    const auto report = world::call_mujoco([&] {
      mj_step1(m, data.get());
      apply_pushes(plant->impl(), pushes, data.get());
      if (first) {
        read();
        if (observer) observe();
        torque = impedance.update(q_a, v_a, command, inertia);
      }
      write_torque();
      mj_step2(m, data.get());
      if (observer) add_wrench();
    });
    if (report.failed) message = report.error;
    if (!report.failed && !report.warnings.empty()) message = report.warnings.front();
    for (int w = 0; message.empty() && w < mjNWARNING; ++w)
      if (data->warning[w].number > 0) message = mju_warningText(w, static_cast<size_t>(data->warning[w].lastinfo));
    return message.empty();
  }

  Status evaluate() {
    const auto report = world::call_mujoco([&] { mj_forward(plant->impl().mujoco.get(), data.get()); });
    if (report.failed || !report.warnings.empty()) {
      message = report.failed ? report.error : report.warnings.front();
      return Status::NumericalFailure;
    }
    read();
    read_forces(plant->impl(), data.get(), forces);
    return Status::Solved;
  }
};

DrivenPlant::DrivenPlant(std::shared_ptr<const Plant> plant, const ImpedanceOptions& options, std::optional<ObserverOptions> observer)
    : impl_(std::make_unique<Impl>(std::move(plant), options, observer)) {
  reset(impl_->plant->model().neutral());
}
DrivenPlant::~DrivenPlant() = default;
DrivenPlant::DrivenPlant(DrivenPlant&&) noexcept = default;

void DrivenPlant::reset(VectorRef q) {
  world::require_configuration(impl_->plant->model(), "q", q);
  const Plant::Impl& p = impl_->plant->impl();
  mj_resetData(p.mujoco.get(), impl_->data.get());
  copy_to_qpos(p, q, impl_->data->qpos);
  impl_->impedance.reset();
  if (impl_->observer) impl_->observer->reset();
  impl_->last_M.clear();
  impl_->periods = 0;
  impl_->pushes.clear();
  impl_->message.clear();
  impl_->torque.setZero();
  impl_->wrench.setZero(), impl_->summed.setZero();
  impl_->q = q, impl_->q_a = q.tail(impl_->q_a.size());
  impl_->write_torque();
  (void)impl_->evaluate();
}

void DrivenPlant::set_pushes(std::span<const Push> pushes) {
  require_pushes(impl_->plant->model(), pushes);
  impl_->pushes.assign(pushes.begin(), pushes.end());
}

Status DrivenPlant::advance(VectorRef command, double duration) {
  core::require_size("command", command.size(), impl_->plant->model().n_a());
  core::require_finite("command", std::span(command.data(), at(command.size())));
  core::require_positive("duration", duration);
  if (!impl_->message.empty()) return Status::NumericalFailure;
  const long count = std::max(1L, std::lround(duration / impl_->impedance.options().period));
  for (long k = 0; k < count; ++k, ++impl_->periods) {
    for (int s = 0; s < impl_->steps_per_period; ++s)
      if (!impl_->step(command, s == 0)) return Status::NumericalFailure;
    if (impl_->observer) impl_->delay_wrench();
  }
  return impl_->evaluate();
}

const Plant& DrivenPlant::plant() const { return *impl_->plant; }
double DrivenPlant::time() const { return static_cast<double>(impl_->periods) * impl_->impedance.options().period; }
const Eigen::VectorXd& DrivenPlant::q() const { return impl_->q; }
const Eigen::VectorXd& DrivenPlant::v() const { return impl_->v; }
const Eigen::VectorXd& DrivenPlant::damping() const { return impl_->impedance.damping(); }
const Eigen::VectorXd& DrivenPlant::torque() const { return impl_->torque; }
const Eigen::VectorXd& DrivenPlant::external() const { return impl_->external; }
const Eigen::VectorXd& DrivenPlant::observed() const { return impl_->observer ? impl_->observer->external() : impl_->zero; }
const Eigen::Matrix<double, 6, 1>& DrivenPlant::base_wrench() const { return impl_->wrench; }
const std::vector<PairForce>& DrivenPlant::forces() const { return impl_->forces; }
const std::string& DrivenPlant::message() const { return impl_->message; }

}  // namespace stiction::simulation
