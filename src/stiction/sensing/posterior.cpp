#include "stiction/sensing/posterior.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "stiction/sensing/residual.hpp"

namespace stiction::sensing {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

constexpr double kDrop = 14;  // places e^−14 less likely than the best carry no weight
constexpr double kCredible = 0.95;
constexpr int kMostPatches = 120, kMostIntegrals = 20;  // on each link
constexpr int kFewIntegrals = 6;                        // on a link with less than kUnlikely times the probability of the likeliest link
constexpr double kUnlikely = 1e-3;

using Columns = Eigen::Matrix<double, LinkTorque::kSize, 3>;
using Tangents = Eigen::Matrix<double, LinkTorque::kSize, 2>;

double area_per_sample(const SensedLink& link) { return link.surface.area / static_cast<double>(link.batch.size); }

/// The fewest links that hold the share, ordered by probability.
void find_credible(Posterior& out) {
  std::vector<int>& links = out.credible;
  links.resize(out.links.size());
  std::iota(links.begin(), links.end(), 0);
  const auto of = [&](int link) { return out.links[static_cast<std::size_t>(link)]; };
  std::sort(links.begin(), links.end(), [&](int a, int b) { return std::pair(-of(a), a) < std::pair(-of(b), b); });
  const double all = std::accumulate(out.links.begin(), out.links.end(), 0.0);
  double held = 0;
  std::size_t count = 0;
  while (count < links.size() && held < kCredible * all) held += of(links[count++]);
  links.resize(count);
}

/// Keeps `most` places of each link, evenly spaced in their order.
void thin(int most, std::size_t links, PosteriorWorkspace& work) {
  const auto at = [](int link) { return static_cast<std::size_t>(link); };
  work.counts.assign(links, 0);
  work.seen.assign(links, 0);
  for (const TouchedPlace& place : work.kept) ++work.counts[at(place.link)];
  std::size_t kept = 0;
  for (std::size_t i = 0; i < work.kept.size(); ++i) {
    const int count = work.counts[at(work.kept[i].link)], number = work.seen[at(work.kept[i].link)]++;
    const bool keeps = count <= most || (2 * number + 1) * most / (2 * count) != (2 * number + 3) * most / (2 * count);
    if (!keeps) continue;
    work.kept[kept] = work.kept[i];
    work.shares[kept] = work.shares[i] * std::max(1.0, static_cast<double>(count) / most);
    ++kept;
  }
  work.kept.resize(kept);
  work.shares.resize(kept);
}

/// Draws the places whose evidence is computed, at equal distances of the cumulative bounds. On a link the ratio of evidence to bound
/// hardly changes, so each place drawn represents the same share of the evidence.
void choose(const Sensor& sensor, double best, PosteriorWorkspace& work) {
  const std::size_t links = sensor.links().size();
  work.counts.assign(links, 0);
  work.weights.assign(2 * links, 0);
  const std::span promised(work.weights.data(), links), passed(work.weights.data() + links, links);
  const auto promise = [&](std::size_t i) { return work.shares[i] * std::exp(work.patches[i].bound - best); };
  for (std::size_t i = 0; i < work.kept.size(); ++i) {
    const auto link = static_cast<std::size_t>(work.kept[i].link);
    ++work.counts[link];
    promised[link] += promise(i) * area_per_sample(sensor.links()[link]);
  }
  const double likeliest = *std::max_element(promised.begin(), promised.end());
  std::size_t kept = 0;
  for (std::size_t i = 0; i < work.kept.size(); ++i) {
    const auto link = static_cast<std::size_t>(work.kept[i].link);
    const int most = promised[link] < kUnlikely * likeliest ? kFewIntegrals : kMostIntegrals;
    double share = work.shares[i];
    if (work.counts[link] > most) {
      const double step = promised[link] / area_per_sample(sensor.links()[link]) / most, weight = promise(i);
      const double before = std::floor(passed[link] / step + 0.5), after = std::floor((passed[link] + weight) / step + 0.5);
      passed[link] += weight;
      if (after == before) continue;
      share *= (after - before) * step / weight;
    }
    work.kept[kept] = work.kept[i];
    work.patches[kept] = work.patches[i];
    work.shares[kept++] = share;
  }
  work.kept.resize(kept);
  work.shares.resize(kept);
  work.patches.resize(kept);
}

}  // namespace

PatchEvidence calc_patch_evidence(const LinkTorque& link, const Vector3d& p_L, const Matrix3d& R_LC, const ConeEvidence& cone, double noise,
                                  double spacing) {
  const double precision = 1 / (noise * noise), force = cone.forces().back();
  const Matrix3d prior = Matrix3d::Identity() / (force * force);
  const Columns M = link.torque_map(p_L) * R_LC;
  Matrix3d A = M.transpose() * M;
  Vector3d a = M.transpose() * link.R_tau;
  PatchEvidence out;
  if (spacing > 0) {
    const Vector3d f_L = R_LC * minimize_polyhedral(precision * A + prior, precision * a, cone.cone()).force_C;
    Tangents D;
    for (int k = 0; k < 2; ++k) D.col(k) = link.R_w * R_LC.col(k + 1).cross(f_L);
    const Eigen::Matrix2d G = D.transpose() * D;
    const double variance = spacing * spacing / 6;
    const Eigen::Matrix2d S = (G + noise * noise / variance * Eigen::Matrix2d::Identity()).inverse();
    const Eigen::Matrix<double, 3, 2> MD = M.transpose() * D;
    const Eigen::Vector2d d = D.transpose() * link.R_tau;
    A -= MD * S * MD.transpose();
    a -= MD * (S * d);
    const double tau_change = d.dot(S * d);
    out.constant = 0.5 * precision * tau_change - 0.5 * std::log((Eigen::Matrix2d::Identity() + variance * precision * G).determinant());
  }
  out.precision = precision * A;
  out.b = precision * a;
  out.bound = out.constant - 0.5 * minimize_polyhedral(out.precision + prior, out.b, cone.cone()).value;
  return out;
}

void normalize(const Sensor& sensor, std::span<const TouchedPlace> places, std::span<const double> shares,
               std::span<const double> log_evidence, double touch_prior, PosteriorWorkspace& work, Posterior& out) {
  double all_area = 0;
  for (const SensedLink& link : sensor.links()) all_area += link.surface.area;
  const double log_nothing = std::log1p(-touch_prior);
  double most = log_nothing;
  for (const double value : log_evidence) most = std::max(most, value);
  double sum = std::exp(log_nothing - most);
  out.nothing = sum;
  out.links.assign(sensor.links().size(), 0);
  work.weights.clear();
  for (std::size_t i = 0; i < places.size(); ++i) {
    const double area = area_per_sample(sensor.links()[static_cast<std::size_t>(places[i].link)]);
    work.weights.push_back(touch_prior * shares[i] * area / all_area * std::exp(log_evidence[i] - most));
    out.links[static_cast<std::size_t>(places[i].link)] += work.weights.back();
    sum += work.weights.back();
  }
  out.nothing /= sum;
  for (double& link : out.links) link /= sum;
  out.places.clear();
  for (std::size_t i = 0; i < places.size(); ++i)
    if (work.weights[i] > 0) out.places.push_back({places[i].link, places[i].sample, work.weights[i] / sum});
  std::sort(out.places.begin(), out.places.end(), [](const TouchedPlace& a, const TouchedPlace& b) {
    return std::tuple(-a.probability, a.link, a.sample) < std::tuple(-b.probability, b.link, b.sample);
  });
  find_credible(out);
}

void calc_posterior(const Sensor& sensor, std::span<const LinkTorque> torques, std::span<const TouchedPlace> places,
                    const ConeEvidence& cone, double noise, double touch_prior, PosteriorWorkspace& work, Posterior& out) {
  work.kept.assign(places.begin(), places.end());
  work.shares.assign(places.size(), 1);
  work.patches.clear();
  thin(kMostPatches, sensor.links().size(), work);
  double best = -std::numeric_limits<double>::infinity();
  for (const TouchedPlace& place : work.kept) {
    const SensedLink& link = sensor.links()[static_cast<std::size_t>(place.link)];
    work.patches.push_back(calc_patch_evidence(torques[static_cast<std::size_t>(place.link)], link.batch.p_L(place.sample),
                                               link.batch.R_LC(place.sample), cone, noise, link.spacing));
    best = std::max(best, work.patches.back().bound);
  }
  std::size_t likely = 0;
  for (std::size_t i = 0; i < work.kept.size(); ++i) {
    if (work.patches[i].bound < best - kDrop) continue;
    work.kept[likely] = work.kept[i];
    work.shares[likely] = work.shares[i];
    work.patches[likely++] = work.patches[i];
  }
  work.kept.resize(likely);
  work.shares.resize(likely);
  work.patches.resize(likely);
  if (likely > 0) choose(sensor, best, work);
  work.evidence.clear();
  for (const PatchEvidence& patch : work.patches) work.evidence.push_back(patch.constant + cone.log_evidence(patch.precision, patch.b));
  normalize(sensor, work.kept, work.shares, work.evidence, touch_prior, work, out);
}

}  // namespace stiction::sensing
