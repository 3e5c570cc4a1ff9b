#include "stiction/execution/poke.hpp"

#include <algorithm>
#include <cmath>

#include "stiction/simulation/driven_plant.hpp"

namespace stiction::execution {

using core::Status;
using Eigen::VectorXd;

namespace {

/// Index of the push that acts at a time, −1: none.
int find_push(const sensing::Poke& poke, double time) {
  for (std::size_t i = 0; i < poke.pushes.size(); ++i)
    if (time >= poke.pushes[i].begin && time < poke.pushes[i].begin + poke.pushes[i].duration) return static_cast<int>(i);
  return -1;
}

simulation::DrivenPlant::Push make_push(const sensing::Scenario& scenario, int push) {
  if (push < 0) return {};
  const sensing::Poke::Push& acting = scenario.poke->pushes[static_cast<std::size_t>(push)];
  const sensing::KnownContact& contact = scenario.contacts[static_cast<std::size_t>(acting.contact)];
  const int body = scenario.sensor->links()[static_cast<std::size_t>(contact.link)].surface.body;
  return {.body = body, .p_BP = contact.p_L, .force_W = acting.force_W};
}

}  // namespace

Status simulate_poke(sensing::Scenario& scenario, std::string& message) {
  if (!scenario.poke) return Status::Solved;
  const sensing::Poke& poke = *scenario.poke;
  const world::Model& model = scenario.sensor->model();
  simulation::PlantOptions options;
  options.damping_ratio = 0;
  const simulation::ObserverOptions observer{poke.time_constant, poke.noise, poke.bias, poke.bias_reach, poke.inertia_error, poke.seed};
  simulation::DrivenPlant plant(simulation::Plant::make(scenario.sensor->model_ptr(), options), {}, observer);
  plant.reset(sensing::place_robots(model, poke.start));

  const auto moments = std::max<Eigen::Index>(1, std::llround(poke.duration / poke.period));
  sensing::Series& series = scenario.series;
  series = {};
  series.q.resize(model.n_a(), moments);
  series.tau.resize(model.n_a(), moments);
  for (Eigen::Index i = 0; i < moments; ++i) {
    const double s = static_cast<double>(i + 1) / static_cast<double>(moments);
    const int push = find_push(poke, static_cast<double>(i) * poke.period);
    plant.set_push(make_push(scenario, push));
    const VectorXd command = poke.start + s * s * (3 - 2 * s) * (poke.end - poke.start);
    if (const Status status = plant.advance(command, poke.period); status != Status::Solved) {
      message = plant.message();
      return status;
    }
    series.times.push_back(plant.time());
    series.q.col(i) = plant.q().tail(model.n_a());
    series.tau.col(i) = plant.observed();
    series.pushed.push_back(push);
  }
  return Status::Solved;
}

}  // namespace stiction::execution
