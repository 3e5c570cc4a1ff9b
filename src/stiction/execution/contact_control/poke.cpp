#include "stiction/execution/contact_control/poke.hpp"

#include <algorithm>
#include <cmath>
#include <span>

#include "stiction/simulation/driven_plant.hpp"

namespace stiction::execution {

using core::Status;
using Eigen::VectorXd;

namespace {

/// Indices of the pushes that act at the given time.
std::vector<int> find_pushes(const sensing::Poke& poke, double time) {
  std::vector<int> out;
  for (std::size_t i = 0; i < poke.pushes.size(); ++i)
    if (time >= poke.pushes[i].begin && time < poke.pushes[i].begin + poke.pushes[i].duration) out.push_back(static_cast<int>(i));
  return out;
}

simulation::Push make_push(const sensing::Scenario& scenario, int push) {
  const sensing::Poke::Push& acting = scenario.poke->pushes[static_cast<std::size_t>(push)];
  const sensing::ContactPoint& contact = scenario.contacts[static_cast<std::size_t>(acting.contact)];
  const int body = scenario.sensor->links()[static_cast<std::size_t>(contact.link)].surface.body;
  return {.body = body, .p_BP = contact.p_L, .force_W = acting.force_W};
}

/// Measurement of the pushes by a sensor under the base, with its noise. The wrench of the moving masses is assumed to be known.
sensing::BaseWrench measure_base(const sensing::BaseWrench& sensor, const world::Kinematics& kinematics,
                                 std::span<const simulation::Push> pushes, core::Random& random) {
  sensing::BaseWrench out = sensor;
  for (double& force : out.force_W) force = sensor.force_noise * random.normal();
  for (double& moment : out.moment_W) moment = sensor.moment_noise * random.normal();
  for (const auto& push : pushes) {
    const sensing::BaseWrench one =
        sensing::calc_base_wrench(kinematics.X_WB[static_cast<std::size_t>(push.body)] * push.p_BP, push.force_W);
    out.force_W += one.force_W;
    out.moment_W += one.moment_W;
  }
  return out;
}

}  // namespace

Status simulate_poke(sensing::Scenario& scenario, std::string& message) {
  if (!scenario.poke) return Status::Solved;
  const sensing::Poke& poke = *scenario.poke;
  const world::Model& model = scenario.sensor->model();
  simulation::PlantOptions options;
  options.damping_ratio = 0;
  const simulation::ObserverOptions observer{.time_constant = poke.time_constant,
                                             .noise = poke.noise,
                                             .bias = poke.bias,
                                             .bias_reach = poke.bias_reach,
                                             .inertia_error = poke.inertia_error,
                                             .seed = poke.seed};
  simulation::DrivenPlant plant(simulation::Plant::make(scenario.sensor->model_ptr(), options), {}, observer);
  plant.reset(sensing::place_robots(model, poke.start));

  const auto moments = std::max<Eigen::Index>(1, std::llround(poke.duration / poke.period));
  sensing::Series& series = scenario.series;
  series = {};
  series.q.resize(model.n_a(), moments);
  series.tau.resize(model.n_a(), moments);
  std::vector<simulation::Push> pushes;
  world::KinematicsWorkspace kinematics_work(model);
  world::Kinematics kinematics;
  constexpr std::uint64_t kBaseStream = 1;  // the observer has another stream
  core::Random random(poke.seed, kBaseStream);
  for (Eigen::Index i = 0; i < moments; ++i) {
    const double s = static_cast<double>(i + 1) / static_cast<double>(moments);
    const std::vector<int> acting = find_pushes(poke, static_cast<double>(i) * poke.period);
    pushes.clear();
    for (const int push : acting) pushes.push_back(make_push(scenario, push));
    plant.set_pushes(pushes);
    const VectorXd command = poke.start + s * s * (3 - 2 * s) * (poke.end - poke.start);
    const double until = static_cast<double>(i + 1) * poke.period;
    if (const Status status = plant.advance(command, until - plant.time()); status != Status::Solved) {
      message = plant.message();
      return status;
    }
    series.times.push_back(plant.time());
    series.q.col(i) = plant.q().tail(model.n_a());
    series.tau.col(i) = plant.observed();
    series.pushed.push_back(acting);
    if (!scenario.base) continue;
    world::calc_kinematics(model, plant.q(), kinematics_work, kinematics);
    series.base.push_back(measure_base(*scenario.base, kinematics, pushes, random));
  }
  return Status::Solved;
}

}  // namespace stiction::execution
