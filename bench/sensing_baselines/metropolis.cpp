#include "sensing_baselines/metropolis.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "sensing_baselines/particle_filter.hpp"
#include "stiction/core/invalid_input.hpp"
#include "stiction/sensing/residual_map.hpp"

namespace stiction::bench {

using sensing::DescentProblem;
using sensing::LinkTorque;
using sensing::make_contact_frame;
using sensing::make_link_torques;

void MetropolisOptions::validate() const {
  core::require_positive("noise", noise);
  core::require_positive("walk", walk);
  if (chains < 1) core::throw_invalid("chains", fmt::format("{}", chains), "an integer ≥ 1");
  if (steps < 1) core::throw_invalid("steps", fmt::format("{}", steps), "an integer ≥ 1");
}

std::vector<ContactPoint> walk_metropolis(const Sensor& sensor, VectorRef q, VectorRef tau, const MetropolisOptions& options) {
  options.validate();
  const std::vector<LinkTorque> torques = make_link_torques(sensor, q, tau);
  std::vector<double> areas_below;
  double area = 0;
  for (const auto& link : sensor.links()) areas_below.push_back(area += link.surface.area);
  std::vector<ContactPoint> out;
  for (int chain = 0; chain < options.chains; ++chain) {
    core::Random random(options.seed, static_cast<std::uint64_t>(chain));
    const ContactPoint start = draw_surface_point(sensor, areas_below, random);
    const auto link = static_cast<std::size_t>(start.link);
    const DescentProblem problem{sensor.links()[link], start.link, torques[link], options.cone, sensor.options().normals, 0};
    const double length = options.walk * problem.link.surface.size;
    ContactPoint here = evaluate(problem, start.triangle, start.p_L), best = here;
    for (int step = 0; step < options.steps; ++step) {
      const Eigen::Vector2d u(random.normal(), random.normal());
      const ContactPoint next = retract(problem, here.p_L + length * (make_contact_frame(here.n_L).rightCols<2>() * u), here.triangle);
      if (random.uniform() < std::exp((here.residual - next.residual) / (2 * options.noise * options.noise))) here = next;
      if (here.residual < best.residual) best = here;
    }
    out.push_back(best);
  }
  std::stable_sort(out.begin(), out.end(), [](const ContactPoint& a, const ContactPoint& b) { return a.residual < b.residual; });
  return out;
}

}  // namespace stiction::bench
