#include "sensing_baselines/particle_filter.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "stiction/core/invalid_input.hpp"
#include "stiction/sensing/residual_map.hpp"

namespace stiction::bench {

using sensing::DescentProblem;
using sensing::make_link_torques;
using sensing::Sampling;
using sensing::SurfacePoint;

using Eigen::Vector3d;

namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

DescentProblem problem_of(const Sensor& sensor, const std::vector<LinkTorque>& torques, const FrictionCone& cone, int link) {
  return {sensor.links()[at(link)], link, torques[at(link)], cone, sensor.options().normals, 0};
}

}  // namespace

void ParticleFilterOptions::validate() const {
  core::require_positive("noise", noise);
  core::require_positive("walk", walk);
  core::require_positive("give_up", give_up);
  core::require_positive("agree", agree);
  if (particles < 1) core::throw_invalid("particles", fmt::format("{}", particles), "an integer ≥ 1");
  if (steady < 1) core::throw_invalid("steady", fmt::format("{}", steady), "an integer ≥ 1");
}

ContactPoint draw_surface_point(const Sensor& sensor, const std::vector<double>& areas_below, core::Random& random) {
  const auto found = std::upper_bound(areas_below.begin(), areas_below.end(), random.uniform() * areas_below.back());
  ContactPoint out;
  out.link = std::min(static_cast<int>(found - areas_below.begin()), static_cast<int>(areas_below.size()) - 1);
  const SurfacePoint point = sample_surface(sensor.links()[at(out.link)].surface, 1, Sampling::Uniform, random.bits())[0];
  out.triangle = point.triangle;
  out.p_L = point.p_L;
  return out;
}

ParticleFilter::ParticleFilter(std::shared_ptr<const Sensor> sensor, const ParticleFilterOptions& options)
    : sensor_(std::move(sensor)), options_(options), random_(options.seed, 0) {
  options.validate();
  double area = 0;
  for (const auto& link : sensor_->links()) areas_below_.push_back(area += link.surface.area);
  particles_.resize(at(options.particles));
  reset();
}

void ParticleFilter::reset() {
  for (ContactPoint& particle : particles_) particle = draw_surface_point(*sensor_, areas_below_, random_);
  measurements_ = 0;
}

void ParticleFilter::walk(const std::vector<LinkTorque>& torques) {
  for (ContactPoint& particle : particles_) {
    const DescentProblem problem = problem_of(*sensor_, torques, options_.cone, particle.link);
    const double step = options_.walk * problem.link.surface.size;
    particle = retract(problem, particle.p_L + step * Vector3d(random_.normal(), random_.normal(), random_.normal()), particle.triangle);
  }
}

/// @returns whether any particle is as likely as noise allows
bool ParticleFilter::resample() {
  const double variance = options_.noise * options_.noise;
  double least = particles_[0].residual, sum = 0;
  for (const ContactPoint& particle : particles_) least = std::min(least, particle.residual);
  if (least > options_.give_up * variance) return false;
  weights_below_.clear();
  for (const ContactPoint& particle : particles_) weights_below_.push_back(sum += std::exp(-(particle.residual - least) / variance));
  drawn_.clear();
  for (std::size_t i = 0; i < particles_.size(); ++i) {
    const auto found = std::upper_bound(weights_below_.begin(), weights_below_.end(), random_.uniform() * sum);
    drawn_.push_back(particles_[std::min(static_cast<std::size_t>(found - weights_below_.begin()), particles_.size() - 1)]);
  }
  particles_.swap(drawn_);
  return true;
}

void ParticleFilter::summarize(const std::vector<LinkTorque>& torques) {
  std::vector<int> counts(sensor_->links().size(), 0);
  for (const ContactPoint& particle : particles_) ++counts[at(particle.link)];
  const auto most = std::max_element(counts.begin(), counts.end());
  const int link = static_cast<int>(most - counts.begin());
  Vector3d mean = Vector3d::Zero(), squares = Vector3d::Zero();
  for (const ContactPoint& particle : particles_)
    if (particle.link == link) mean += particle.p_L / *most;
  for (const ContactPoint& particle : particles_)
    if (particle.link == link) squares += (particle.p_L - mean).cwiseAbs2() / *most;
  estimate_.share = *most;
  estimate_.deviation = squares.cwiseSqrt().mean();
  estimate_.point = retract(problem_of(*sensor_, torques, options_.cone, link), mean, -1);
  estimate_.agrees = measurements_ >= options_.steady && estimate_.deviation <= options_.agree * sensor_->links()[at(link)].surface.size;
}

const ParticleEstimate& ParticleFilter::update(VectorRef q, VectorRef tau) {
  const std::vector<LinkTorque> torques = make_link_torques(*sensor_, q, tau);
  walk(torques);
  ++measurements_;
  const bool likely = resample();
  if (!likely) {
    ++estimate_.resets;
    reset();
  }
  summarize(torques);
  return estimate_;
}

}  // namespace stiction::bench
