#include "stiction/sensing/posterior.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "sensing/random_contact.hpp"
#include "sensing/robots.hpp"
#include "stiction/sensing/known_contacts.hpp"
#include "stiction/sensing/sense.hpp"

namespace stiction::sensing::test {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// ln B by drawing forces from the prior.
struct Drawn {
  double log_evidence, deviation;
};
Drawn draw_evidence(const FrictionCone& cone, double force, const Matrix3d& H, const Vector3d& b, int count, core::Random& random) {
  const Matrix3d A = H - Matrix3d::Identity() / (force * force);
  std::vector<double> exponents;
  double most = -1e300;
  while (static_cast<int>(exponents.size()) < count) {
    const Vector3d f = force * random_matrix(random, 3, 1);
    if (!cone.contains(f)) continue;
    exponents.push_back(b.dot(f) - 0.5 * f.dot(A * f));
    most = std::max(most, exponents.back());
  }
  double sum = 0, square = 0;
  for (const double x : exponents) {
    sum += std::exp(x - most);
    square += std::exp(2 * (x - most));
  }
  const double n = count, mean = sum / n;
  return {most + std::log(mean), std::sqrt(std::max(0.0, square / n - mean * mean) / n) / mean};
}

/// Precision of forces that so many torques of arms give, and the torque of some force.
void make_case(core::Random& random, double force, double signal, Matrix3d& H, Vector3d& b) {
  const int rows = 1 + static_cast<int>(random.uniform(0, 5));
  const Eigen::MatrixXd M =
      random_matrix(random, rows, 3) * Vector3d(1, std::exp(random.uniform(-3, 1)), std::exp(random.uniform(-3, 1))).asDiagonal();
  const Eigen::MatrixXd scaled = signal / force * M;
  H = scaled.transpose() * scaled + Matrix3d::Identity() / (force * force);
  Vector3d f = force * random_matrix(random, 3, 1);
  f[0] = std::abs(f[0]);
  b = scaled.transpose() * (scaled * f + random_matrix(random, rows, 1));
}

TEST(ConeEvidence, Forces_DrawnFromThePrior_GiveTheSame) {
  core::Random random(3, 0);
  const double force = 20;
  double worst = 0;
  for (const auto& [friction, rays] : {std::pair(1.0, 4), std::pair(0.3, 4), std::pair(0.7, 8), std::pair(2.0, 3), std::pair(0.8, 0)}) {
    const FrictionCone cone(friction, rays);
    const ConeEvidence evidence(cone, {force});
    for (int i = 0; i < 10; ++i) {
      Matrix3d H;
      Vector3d b;
      make_case(random, force, std::exp(random.uniform(-2, 1.5)), H, b);
      const Drawn drawn = draw_evidence(cone, force, H, b, 16000, random);
      if (drawn.deviation > 0.1) continue;  // says too little
      worst = std::max(worst, drawn.deviation);
      EXPECT_NEAR(evidence.log_evidence(H - Matrix3d::Identity() / (force * force), b), drawn.log_evidence,
                  4 * drawn.deviation + (rays == 0 ? 0.01 : 1e-3))
          << friction << " " << rays << " " << i;
    }
  }
  EXPECT_GT(worst, 0) << "no case was looked at";
}

/// ln ∫_K of the cone of four rays over slopes f = s (1, x, y), |x| + |y| ≤ μ, by the midpoint rule, with the integral over s in closed form.
double integrate_slopes(const FrictionCone& cone, const Matrix3d& H, const Vector3d& b, int steps) {
  double most = -1e300;
  std::vector<std::pair<double, double>> terms;  // exponent, factor
  const double reach = cone.friction(), step = 2 * reach / steps;
  for (int i = 0; i < steps; ++i)
    for (int k = 0; k < steps; ++k) {
      const double a = -reach + (i + 0.5) * step, c = -reach + (k + 0.5) * step;
      const Vector3d u(1, (a + c) / 2, (a - c) / 2);
      const double h = u.dot(H * u), t = b.dot(u) / std::sqrt(h), exponent = std::max(0.0, 0.5 * t * std::abs(t));
      const double below = 0.5 * std::erfc(-t / std::numbers::sqrt2);
      const double factor =
          (1 + t * t) * std::sqrt(2 * std::numbers::pi) * below * std::exp(0.5 * t * t - exponent) + t * std::exp(-exponent);
      terms.emplace_back(exponent, factor * std::pow(h, -1.5));
      most = std::max(most, exponent);
    }
  double sum = 0;
  for (const auto& [exponent, factor] : terms) sum += factor * std::exp(exponent - most);
  return most + std::log(sum * step * step / 2);
}

TEST(ConeEvidence, TorquesFarAboveNoise_AgreeWithAGridOfDirections) {
  core::Random random(4, 0);
  const double force = 20;
  const FrictionCone cone(1, 4);
  const ConeEvidence evidence(cone, {force});
  const Matrix3d H_prior = Matrix3d::Identity() / (force * force);
  const double prior = integrate_slopes(cone, H_prior, Vector3d::Zero(), 500);
  int sharp = 0;
  for (int i = 0; i < 16; ++i) {
    Matrix3d H;
    Vector3d b;
    make_case(random, force, std::exp(random.uniform(0.5, 2.5)), H, b);
    const double coarse = integrate_slopes(cone, H, b, 400), fine = integrate_slopes(cone, H, b, 800);
    EXPECT_NEAR(evidence.log_evidence(H - Matrix3d::Identity() / (force * force), b), fine - prior, std::abs(fine - coarse) + 2e-3) << i;
    sharp += fine - prior > 50;
  }
  EXPECT_GT(sharp, 2) << "hardly any case is far above noise";
}

TEST(ConeEvidence, NoTorque_SaysNothing) {
  for (const int rays : {0, 3, 4, 16}) {
    const ConeEvidence evidence(FrictionCone(0.6, rays), {2, 10});
    EXPECT_NEAR(evidence.log_evidence(Matrix3d::Zero(), Vector3d::Zero()), 0, 1e-12);
  }
}

TEST(ConeEvidence, SeveralForces_AreAMean) {
  core::Random random(8, 0);
  const FrictionCone cone(0.6, 4);
  for (int i = 0; i < 10; ++i) {
    Matrix3d H;
    Vector3d b;
    make_case(random, 20, 2, H, b);
    const double few = ConeEvidence(cone, {5}).log_evidence(H, b), many = ConeEvidence(cone, {50}).log_evidence(H, b);
    EXPECT_NEAR(ConeEvidence(cone, {5, 50}).log_evidence(H, b), std::log(0.5 * (std::exp(few) + std::exp(many))), 1e-9);
  }
}

TEST(ConeEvidence, OneRay_HasTheIntegralOfAHalfNormal) {
  const double force = 5, h = 3, g = 2;  // ∫ exp(g s − h s²/2) ds / ∫ exp(−s²/2F²) ds
  const ConeEvidence evidence(FrictionCone(0, 4), {force});
  const double t = g / std::sqrt(h), below = 0.5 * std::erfc(-t / std::numbers::sqrt2);
  EXPECT_NEAR(evidence.log_evidence(Vector3d(h - 1 / (force * force), 1, 1).asDiagonal(), {g, 0, 0}),
              std::log(2 * below / (std::sqrt(h) * force)) + t * t / 2, 1e-12);
}

/// The arm of capsules; its inner faces, which take seconds to find, do not matter here.
std::shared_ptr<const Sensor> make_iiwa(int samples) {
  SensorOptions options;
  options.surface.rays = 0;
  options.samples = samples;
  return Sensor::make(make_arm(kIiwa), options);
}

SenseOptions with_posterior(double noise) {
  SenseOptions out;
  out.noise = noise;
  out.posterior = true;
  out.cone = FrictionCone(0.5, 4);
  return out;
}

TEST(Posterior, FewSamples_SayNearlyWhatManyDo) {
  const auto few = make_iiwa(500), many = make_iiwa(40000);
  SenseWorkspace work(few), work_many(many);
  core::Random random(5, 0);
  const SenseOptions options = with_posterior(0.05);
  SenseOptions without_descents = options;
  without_descents.max_descents = 1;
  std::vector<int> links(few->links().size());
  for (std::size_t i = 0; i < links.size(); ++i) links[i] = static_cast<int>(i);
  double difference = 0;
  constexpr int kCases = 20;
  for (int i = 0; i < kCases; ++i) {
    KnownCase c = make_random_case(*few, links, options.cone, 15, random);
    for (double& x : c.tau) x += 0.05 * random.normal();
    SenseResult a, b;
    sense(*few, {c.q, c.tau}, without_descents, work, a);
    sense(*many, {c.q, c.tau}, without_descents, work_many, b);
    double total = std::abs(a.posterior.nothing - b.posterior.nothing);
    for (std::size_t k = 0; k < a.posterior.links.size(); ++k) total += std::abs(a.posterior.links[k] - b.posterior.links[k]);
    difference += total / 2 / kCases;
  }
  EXPECT_LT(difference, 0.05);  // mean total variation
}

TEST(Posterior, Probabilities_HoldAsOftenAsTheySay) {
  // Cases drawn from the prior itself: of answers that a link is touched with probability p, p are right.
  const auto sensor = make_iiwa(300);
  SenseWorkspace work(sensor);
  core::Random random(6, 0);
  SenseOptions options = with_posterior(0.1);
  options.plausible_force = 20;
  options.touch_prior = 0.7;
  options.max_descents = 1;
  double area = 0;
  for (const SensedLink& link : sensor->links()) area += link.surface.area;
  constexpr int kCases = 600;
  double expected = 0, variance = 0, brier = 0;
  int first = 0, credible = 0, touches = 0;
  for (int i = 0; i < kCases; ++i) {
    int link = -1;
    VectorXd q, tau;
    double at = random.uniform(0, area);
    std::size_t k = 0;
    while (k + 1 < sensor->links().size() && at > sensor->links()[k].surface.area) at -= sensor->links()[k++].surface.area;
    const int one[] = {static_cast<int>(k)};
    KnownCase c = make_random_case(*sensor, one, options.cone, 1, random);
    if (random.uniform(0, 1) < options.touch_prior) {
      link = static_cast<int>(k);
      const ContactPoint& p = c.contact;
      const Surface& surface = sensor->links()[k].surface;
      const auto closest = surface.tree.closest(p.p_L);
      const Matrix3d R = make_contact_frame(surface.normal(closest.triangle, closest.point, Normals::Flat));
      Vector3d f;
      do f = *options.plausible_force * random_matrix(random, 3, 1);
      while (!options.cone.contains(f));
      c.tau = calc_contact_torque(sensor->model(), c.q, surface.body, p.p_L, R * f);
      ++touches;
    } else {
      c.tau.setZero();
    }
    for (double& x : c.tau) x += 0.1 * random.normal();
    SenseResult result;
    sense(*sensor, {c.q, c.tau}, options, work, result);
    const Posterior& posterior = result.posterior;
    const auto best = static_cast<std::size_t>(std::max_element(posterior.links.begin(), posterior.links.end()) - posterior.links.begin());
    const bool says_nothing = posterior.nothing > posterior.links[best];
    const double p = says_nothing ? posterior.nothing : posterior.links[best];
    const bool right = says_nothing ? link < 0 : static_cast<int>(best) == link;
    expected += p;
    variance += p * (1 - p);
    first += right;
    brier += std::pow(p - right, 2);
    if (link >= 0) credible += std::find(posterior.credible.begin(), posterior.credible.end(), link) != posterior.credible.end();
  }
  EXPECT_NEAR(first, expected, 3 * std::sqrt(variance) + 0.01 * kCases);
  EXPECT_GE(credible, 0.93 * touches);
  EXPECT_LT(brier / kCases, 0.25);
}

TEST(Posterior, CandidatesThatExplain_AreOrderedByIt) {
  const auto sensor = make_iiwa(500);
  SenseWorkspace work(sensor);
  core::Random random(7, 0);
  const SenseOptions options = with_posterior(0.1);
  const int links[] = {2, 3, 4, 5};
  int several = 0;
  for (int i = 0; i < 20; ++i) {
    KnownCase c = make_random_case(*sensor, links, options.cone, 15, random);
    SenseResult result;
    sense(*sensor, {c.q, c.tau}, options, work, result);
    double before = 2, sum = 0;
    for (const Candidate& candidate : result.candidates) {
      sum += candidate.probability;
      if (!candidate.explains) continue;
      const double link = result.posterior.links[static_cast<std::size_t>(candidate.best.link)];
      EXPECT_LE(link, before);
      several += link < before && before <= 1;
      before = link;
    }
    EXPECT_LE(sum, 1 + 1e-9);
  }
  EXPECT_GT(several, 5) << "hardly any case has candidates on two links";
}

TEST(Posterior, MomentsOfOneTouch_SayMoreThanOne) {
  const auto sensor = make_iiwa(300);
  SenseWorkspace work(sensor);
  core::Random random(9, 0);
  SenseOptions options = with_posterior(0.1);
  options.plausible_force = 15;
  double one = 0, three = 0, brier = 0;
  int right = 0;
  constexpr int kCases = 60;
  for (int i = 0; i < kCases; ++i) {
    const int links[] = {1 + i % 6};
    const KnownCase c = make_random_case(*sensor, links, options.cone, 1, random);
    const Surface& surface = sensor->links()[static_cast<std::size_t>(links[0])].surface;
    const auto closest = surface.tree.closest(c.contact.p_L);
    const Matrix3d R = make_contact_frame(surface.normal(closest.triangle, closest.point, Normals::Flat));
    Eigen::MatrixXd q = c.q.replicate(1, 3), tau(7, 3);
    for (int k = 0; k < 3; ++k) {
      Vector3d f;
      do f = 15 * random_matrix(random, 3, 1);
      while (!options.cone.contains(f));
      tau.col(k) = calc_contact_torque(sensor->model(), c.q, surface.body, c.contact.p_L, R * f) + 0.1 * random_matrix(random, 7, 1);
    }
    SenseResult single, same, all;
    sense_touch(*sensor, q.leftCols(1), tau.leftCols(1), 0, options, work, single);
    sense(*sensor, {q.col(0), tau.col(0)}, options, work, same);
    EXPECT_EQ(single.posterior.links, same.posterior.links) << "one moment";
    sense_touch(*sensor, q, tau.col(0).replicate(1, 3), 1, options, work, same);
    for (std::size_t k = 0; k < same.posterior.links.size(); ++k)
      EXPECT_NEAR(same.posterior.links[k], single.posterior.links[k], 1e-9) << "three times the same";
    sense_touch(*sensor, q, tau, 0, options, work, all);
    const auto link = static_cast<std::size_t>(links[0]);
    one += single.posterior.links[link] / kCases;
    three += all.posterior.links[link] / kCases;
    const auto best = std::max_element(all.posterior.links.begin(), all.posterior.links.end());
    right += static_cast<std::size_t>(best - all.posterior.links.begin()) == link;
    brier += std::pow(1 - all.posterior.links[link], 2) / kCases;
  }
  EXPECT_GT(three, one + 0.02);
  EXPECT_GT(right, 0.8 * kCases);
  EXPECT_LT(brier, 0.15);
}

/// Where samples are far apart and torques far above their noise, no sample is near enough to the touched place to be accepted.
TEST(Posterior, LargeTorquesThatNoSampleExplains_AreATouch) {
  const auto sensor = make_iiwa(10);
  SenseWorkspace work(sensor);
  core::Random random(9, 0);
  SenseOptions options = with_posterior(0.001);
  options.accept_share = 1e-9;
  const int links[] = {3, 4, 5, 6};
  int without = 0, right = 0;
  for (int i = 0; i < 40; ++i) {
    const KnownCase c = make_random_case(*sensor, links, options.cone, 30, random);
    SenseResult result;
    sense(*sensor, {c.q, c.tau}, options, work, result);
    if (result.accepted > 0) continue;
    ++without;
    EXPECT_LT(result.posterior.nothing, 1e-6) << i;
    const auto& p = result.posterior.links;
    right += std::max_element(p.begin(), p.end()) - p.begin() == c.contact.link;
  }
  EXPECT_GT(without, 20) << "or the test would say nothing";
  EXPECT_GT(right, 0.6 * without);
}

TEST(Posterior, TorquesBelowTheThreshold_AreProbablyNothing) {
  const auto sensor = make_iiwa(300);
  SenseWorkspace work(sensor);
  SenseResult result;
  const VectorXd q = VectorXd::Constant(7, 0.5);
  VectorXd tau = VectorXd::Zero(7);
  tau[1] = 0.02;
  sense(*sensor, {q, tau}, with_posterior(0.05), work, result);
  EXPECT_EQ(result.verdict, Verdict::BelowThreshold);
  EXPECT_GT(result.posterior.nothing, 0.7);
  EXPECT_DOUBLE_EQ(result.largest.torque, 0.02);
  EXPECT_DOUBLE_EQ(result.threshold, 0.2);
}

}  // namespace
}  // namespace stiction::sensing::test
