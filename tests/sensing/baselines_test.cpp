#include <gtest/gtest.h>

#include <algorithm>
#include <array>

#include "sensing/robots.hpp"
#include "sensing_baselines/line_of_action.hpp"
#include "sensing_baselines/metropolis.hpp"
#include "sensing_baselines/particle_filter.hpp"
#include "stiction/sensing/known_contacts.hpp"
#include "support/message_of.hpp"

namespace stiction::sensing::test {
namespace {

using namespace bench;

constexpr double kNear = 0.01;  // [m]
constexpr double kNoise = 0.1;  // assumed by all [N m]

std::shared_ptr<const Sensor> ur5() {
  static const auto sensor = Sensor::make(make_arm(kUr5));
  return sensor;
}

KnownCase make_case(core::Random& random) {
  return make_random_case(*ur5(), std::array{ur5()->link_index("arm/wrist_2_link"), ur5()->link_index("arm/wrist_3_link")},
                          FrictionCone(1, 4), 10, random);
}

bool is_near(const ContactPoint& point, const ContactPoint& contact, double distance) {
  return point.link == contact.link && (point.p_L - contact.p_L).norm() <= distance;
}

TEST(ParticleFilter, ManyParticles_GatherAtTheContact) {
  core::Random random(1, 0);
  int agreed = 0, near = 0;
  for (int trial = 0; trial < 10; ++trial) {
    const KnownCase c = make_case(random);
    ParticleFilterOptions options;
    options.particles = 400;
    options.noise = kNoise;
    options.seed = static_cast<std::uint64_t>(trial);
    ParticleFilter filter(ur5(), options);
    for (int i = 0; i < 30; ++i) (void)filter.update(c.q, c.tau);
    const ParticleEstimate& out = filter.update(c.q, c.tau);
    if (!out.agrees) continue;
    ++agreed;
    near += is_near(out.point, c.contact, 2 * kNear);
    for (const ContactPoint& particle : filter.particles())  // on the surface
      ASSERT_LE(
          std::abs(std::sqrt(ur5()->links()[static_cast<std::size_t>(particle.link)].surface.tree.closest(particle.p_L).squared_distance)),
          1e-9);
  }
  EXPECT_GE(agreed, 3);
  EXPECT_GE(2 * near, agreed);  // the others are at another point that makes the torques
}

TEST(ParticleFilter, TorquesThatNoContactMakes_DrawParticlesAnew) {
  ParticleFilter filter(ur5(), {});
  Eigen::VectorXd tau(6);
  tau << 90, -90, 90, -20, 20, -20;
  for (int i = 0; i < 10; ++i) EXPECT_FALSE(filter.update(Eigen::VectorXd::Constant(6, 0.7), tau).agrees);
  EXPECT_GE(filter.update(Eigen::VectorXd::Constant(6, 0.7), tau).resets, 10);
}

TEST(Metropolis, BestPointOfManyChains_MakesTheTorques) {
  core::Random random(2, 0);
  int found = 0;
  constexpr int kCases = 10;
  for (int trial = 0; trial < kCases; ++trial) {
    const KnownCase c = make_case(random);
    MetropolisOptions options;
    options.noise = kNoise;
    options.chains = 40;
    const std::vector<ContactPoint> points = walk_metropolis(*ur5(), c.q, c.tau, options);
    ASSERT_EQ(points.size(), 40u);
    EXPECT_TRUE(std::is_sorted(points.begin(), points.end(), [](const auto& a, const auto& b) { return a.residual < b.residual; }));
    found += points[0].residual <= calc_noise_bound(kNoise, 6);
  }
  EXPECT_GE(found, 8);
}

TEST(Baselines, SameSeed_GivesTheSameBits) {
  core::Random random(3, 0);
  const KnownCase c = make_case(random);
  ParticleFilter a(ur5(), {}), b(ur5(), {});
  for (int i = 0; i < 5; ++i) EXPECT_EQ(a.update(c.q, c.tau).point.p_L, b.update(c.q, c.tau).point.p_L);
  const auto first = walk_metropolis(*ur5(), c.q, c.tau, {}), second = walk_metropolis(*ur5(), c.q, c.tau, {});
  for (std::size_t i = 0; i < first.size(); ++i) EXPECT_EQ(first[i].p_L, second[i].p_L);
}

TEST(Baselines, KnownContacts_AreFoundLessOftenThanBySense) {
  core::Random random(4, 0);
  SenseOptions options;
  options.noise = 1e-3;
  SenseWorkspace work(ur5());
  SenseResult result;
  int sensed = 0, filtered = 0, walked = 0, by_line = 0;
  constexpr int kCases = 40;
  for (int trial = 0; trial < kCases; ++trial) {
    const KnownCase c = make_case(random);
    sense(*ur5(), {c.q, c.tau}, options, work, result);
    sensed += std::any_of(result.candidates.begin(), result.candidates.end(), [&](const Candidate& candidate) {
      return candidate.explains && calc_distance(result, candidate, c.contact) <= kNear;
    });
    ParticleFilter filter(ur5(), {});
    for (int i = 0; i < 30; ++i) (void)filter.update(c.q, c.tau);
    const ParticleEstimate& estimate = filter.update(c.q, c.tau);
    filtered += estimate.agrees && is_near(estimate.point, c.contact, kNear);
    const auto points = walk_metropolis(*ur5(), c.q, c.tau, {});
    walked += std::any_of(points.begin(), points.end(),
                          [&](const ContactPoint& p) { return p.residual <= calc_noise_bound(kNoise, 6) && is_near(p, c.contact, kNear); });
    const auto line = find_line_of_action(*ur5(), c.q, c.tau, 1e-3).points;
    by_line += std::any_of(line.begin(), line.end(), [&](const ContactPoint& p) { return is_near(p, c.contact, kNear); });
  }
  EXPECT_GE(sensed, kCases - 1);
  EXPECT_LT(filtered, sensed);
  EXPECT_LT(walked, sensed);
  EXPECT_LT(by_line, sensed);
}

TEST(Baselines, BadInput_IsNamed) {
  using stiction::test::message_of;
  ParticleFilterOptions none;
  none.particles = 0;
  EXPECT_EQ(message_of([&] { ParticleFilter(ur5(), none); }), "particles: got 0, expected an integer ≥ 1");
  MetropolisOptions still;
  still.walk = 0;
  const Eigen::VectorXd q = Eigen::VectorXd::Zero(6);
  EXPECT_EQ(message_of([&] { (void)walk_metropolis(*ur5(), q, q, still); }), "walk: got 0, expected a finite number > 0");
  EXPECT_EQ(message_of([&] { (void)walk_metropolis(*ur5(), q, q.head(5), {}); }), "tau: got 5 numbers, expected 6");
}

}  // namespace
}  // namespace stiction::sensing::test
