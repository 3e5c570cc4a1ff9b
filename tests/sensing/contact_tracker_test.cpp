// Sets of contacts followed through a loop.
#include "stiction/sensing/contact_tracker.hpp"

#include <gtest/gtest.h>

#include "sensing/robots.hpp"
#include "stiction/sensing/known_contacts.hpp"
#include "stiction/sensing/sense.hpp"
#include "support/message_of.hpp"

namespace stiction::sensing::test {
namespace {

using stiction::test::message_of;

constexpr double kNoise = 1e-3, kForce = 10;

std::shared_ptr<const Sensor> ur5() {
  static const auto sensor = Sensor::make(make_arm(kUr5), {.samples = 200});
  return sensor;
}

ContactRows make_contact_rows(const KnownCases& c) {
  world::KinematicsWorkspace work(ur5()->model());
  world::Kinematics kinematics;
  world::calc_kinematics(ur5()->model(), c.q, work, kinematics);
  std::vector<int> bodies;
  for (const SensedLink& link : ur5()->links()) bodies.push_back(link.surface.body);
  ContactRowsWorkspace rows_work;
  ContactRows out;
  calc_contact_rows(ur5()->model(), kinematics, bodies, c.tau, nullptr, kNoise, rows_work, out);
  return out;
}

ContactSet make_parent(const KnownCases& c) { return make_set(*ur5(), std::span(c.contacts).first(1)); }

/// Beside a contact that is known from before, calls of bounded work come to a set that makes the torques, and the first contact stays where it was.
TEST(ContactTracker, SecondContact_IsFoundInSomeCallsBesideTheFirst) {
  core::Random random(11, 0);
  const FrictionCone cone(1, 4);
  const ContactTrackerOptions options;
  const double rho = kNoise * kNoise / (4 * kForce * kForce);
  constexpr int kCases = 10;
  int explained = 0, kept = 0;
  for (int trial = 0; trial < kCases; ++trial) {
    const std::array links{2, 5};
    const KnownCases c = make_random_cases(*ur5(), links, cone, kForce, 2, random);
    const ContactRows rows = make_contact_rows(c);
    const ContactSet parent = make_parent(c);
    const double enough = std::max(1e-4 * rows.tau.squaredNorm(), calc_noise_bound(kNoise, rows.tau.size()));
    ContactTracker tracker(ur5(), 2, options);
    for (int call = 0; call < 20; ++call) {
      tracker.update({rows, rho, kNoise, enough, std::span(&parent, 1)});
      ASSERT_LE(tracker.descents(), options.pool + options.descents);
      ASSERT_LE(tracker.sets().size(), static_cast<std::size_t>(options.pool));
    }
    ASSERT_FALSE(tracker.sets().empty());
    const ContactSet& best = tracker.sets().front();
    ASSERT_EQ(best.count, 2);
    explained += best.residual <= enough;
    for (int i = 0; i < 2; ++i)
      if (best.contacts[static_cast<std::size_t>(i)].link == c.contacts[0].link) {
        kept += (best.contacts[static_cast<std::size_t>(i)].p_L - c.contacts[0].p_L).norm() < 0.05;
        break;
      }
    JointWorkspace work;
    ContactSet judged = best;
    calc_identifiability({*ur5(), rows, cone, rho, kNoise}, work, judged);
    EXPECT_GE(judged.freedom, 10 - 6) << "six torques cannot fix ten numbers";
    tracker.reset();
    EXPECT_TRUE(tracker.sets().empty());
  }
  EXPECT_GE(explained, 9);
  EXPECT_GE(kept, 6);
}

/// Torques that change a little from call to call: the best set goes with them.
TEST(ContactTracker, TorquesThatChange_AreFollowed) {
  core::Random random(12, 0);
  const std::array links{1, 5};
  const KnownCases c = make_random_cases(*ur5(), links, FrictionCone(1, 4), kForce, 2, random);
  ContactRows rows = make_contact_rows(c);
  const ContactSet parent = make_parent(c);
  const Eigen::VectorXd tau = rows.tau;
  const double rho = kNoise * kNoise / (4 * kForce * kForce), enough = 1e-4 * tau.squaredNorm();
  ContactTracker tracker(ur5(), 2, {});
  for (int call = 0; call < 20; ++call) tracker.update({rows, rho, kNoise, enough, std::span(&parent, 1)});
  ASSERT_LE(tracker.sets().front().objective, enough);
  for (int call = 0; call < 40; ++call) {
    rows.tau = (1 + 0.01 * call) * tau;
    tracker.update({rows, rho, kNoise, enough, {}});  // nothing new is tried
    ASSERT_LE(tracker.sets().front().objective, 2 * enough) << call;
  }
}

TEST(ContactTracker, BadInput_IsNamed) {
  EXPECT_NE(message_of([] { (void)ContactTracker(ur5(), 1, {}); }).find("count: got 1, expected an integer from 2 to 3"),
            std::string::npos);
  ContactTrackerOptions options;
  options.pool = 0;
  EXPECT_NE(message_of([&] { options.validate(); }).find("tracker.pool: got 0"), std::string::npos);
  options.pool = 6, options.merge = -1;
  EXPECT_NE(message_of([&] { options.validate(); }).find("tracker.merge: got -1"), std::string::npos);
  options.merge = 3, options.cone = FrictionCone(1, 0);
  EXPECT_NE(message_of([&] { options.validate(); }).find("rays: got 0 (the exact cone)"), std::string::npos);
}

}  // namespace
}  // namespace stiction::sensing::test
