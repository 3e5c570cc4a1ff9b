#include "stiction/sensing/contact_sets.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <thread>

#include "cone_allocations.hpp"
#include "sensing/robots.hpp"
#include "stiction/sensing/known_contacts.hpp"
#include "support/message_of.hpp"

namespace stiction::sensing::test {
namespace {

using Eigen::VectorXd;

std::shared_ptr<const Sensor> ur5() {
  static const auto sensor = Sensor::make(make_arm(kUr5));
  return sensor;
}

ContactSetOptions noiseless(int max_contacts) {
  ContactSetOptions out;
  out.sense.noise = 1e-3;
  out.sense.tolerance = 1e-3;
  out.max_contacts = max_contacts;
  return out;
}

BaseWrench exact(BaseWrench base) {
  base.force_noise = base.moment_noise = 1e-3;
  return base;
}

int link(const char* name) { return ur5()->link_index(std::string("arm/") + name); }

/// Distance of the nearest set that explains.
double distance(const ContactSetResult& result, std::span<const ContactPoint> contacts) {
  double out = std::numeric_limits<double>::infinity();
  for (const ContactSet& set : result.sets) out = std::min(out, calc_distance(set, contacts));
  return out;
}

TEST(ContactSets, OneContact_IsOneContact) {
  core::Random random(1, 0);
  ContactSetWorkspace work(ur5());
  ContactSetResult out;
  const int links[] = {link("wrist_2_link"), link("wrist_3_link")};
  for (int trial = 0; trial < 5; ++trial) {
    const KnownCases c = make_random_cases(*ur5(), links, FrictionCone(1, 4), 10, 1, random);
    sense_contacts(*ur5(), {c.q, c.tau}, noiseless(3), work, out);
    ASSERT_EQ(out.verdict, Verdict::Explained);
    EXPECT_EQ(out.contacts, 1);
    EXPECT_LT(distance(out, c.contacts), 0.01);
  }
}

TEST(ContactSets, TwoLinksAndWrenchAtTheBase_BothAreFound) {
  // The wrench shows the sum, six numbers; the five joints between the two links show the farther contact alone: eleven against ten.
  core::Random random(2, 0);
  ContactSetWorkspace work(ur5());
  ContactSetResult out;
  const int links[] = {link("shoulder_link"), link("wrist_3_link")};
  int found = 0;
  constexpr int kCases = 10;
  for (int trial = 0; trial < kCases; ++trial) {
    const KnownCases c = make_random_cases(*ur5(), links, FrictionCone(1, 4), 10, 2, random);
    const BaseWrench base = exact(c.base);
    EXPECT_EQ(calc_freedom(*ur5(), c, true, 1e-3), 0);
    sense_contacts(*ur5(), {c.q, c.tau, &base}, noiseless(2), work, out);
    found += out.verdict == Verdict::Explained && distance(out, c.contacts) < 0.01;
  }
  EXPECT_GE(found, 8);
}

TEST(ContactSets, JointsBetweenTheLinks_AreWhatTellsContactsApart) {
  core::Random random(8, 0);
  const FrictionCone cone(1, 4);
  // Six numbers of the wrench and one a joint between the links, against ten; torques alone: as many as joints move the farther link.
  for (const auto& [near, far, between] : {std::tuple(2, 4, 2), std::tuple(1, 4, 3), std::tuple(1, 5, 4), std::tuple(0, 5, 5)}) {
    const KnownCases c = make_random_cases(*ur5(), std::array{near, far}, cone, 10, 2, random);
    EXPECT_EQ(calc_freedom(*ur5(), c, true, 1e-3), std::max(0, 10 - 6 - between)) << near << ", " << far;
    EXPECT_EQ(calc_freedom(*ur5(), c, false, 1e-3), 10 - (far + 1)) << near << ", " << far;
  }
}

TEST(ContactSets, ContactBehindFiveJointsOfItsOwn_IsFoundBesideOneAtTheShoulder) {
  core::Random random(3, 0);
  ContactSetWorkspace work(ur5());
  ContactSetResult out;
  const int links[] = {link("shoulder_link"), link("wrist_3_link")};
  int found = 0, asked = 0;
  for (int trial = 0; trial < 8; ++trial) {
    const KnownCases c = make_random_cases(*ur5(), links, FrictionCone(1, 4), 10, 2, random);
    sense_contacts(*ur5(), {c.q, c.tau}, noiseless(2), work, out);
    ASSERT_EQ(out.verdict, Verdict::Explained);
    if (out.contacts < 2) continue;  // the shoulder turns about one axis: a force on the wrist may do
    ++asked;
    EXPECT_TRUE(out.ambiguous);
    double nearest = std::numeric_limits<double>::infinity();
    for (const ContactSet& set : out.sets) {
      EXPECT_GE(set.freedom, 4);  // six torques against ten
      if (set.contacts[0].link != links[0] || set.contacts[1].link != links[1]) continue;
      EXPECT_TRUE(set.point_is_unique[1]);
      EXPECT_FALSE(set.point_is_unique[0]);
      nearest = std::min(nearest, (set.contacts[1].p_L - c.contacts[1].p_L).norm());
    }
    found += nearest < 0.01;
  }
  EXPECT_GE(asked, 4);
  EXPECT_GE(found, asked - 1);
}

TEST(ContactSets, TwoForcesThatNothingTellsApart_AreSaidToBeAmbiguous) {
  // Two contacts on one link: torques and wrench show only the sum of their wrenches.
  const Sensor& sensor = *ur5();
  const int wrist = link("wrist_3_link");
  core::Random random(4, 0);
  const FrictionCone cone(1, 4);
  KnownCases c = make_random_cases(sensor, std::array{wrist}, cone, 10, 1, random);
  const KnownCases other = make_random_cases(sensor, std::array{wrist}, cone, 10, 1, random);
  c.contacts.push_back(other.contacts[0]);
  calc_known_rows(sensor, c.q, c.contacts, c.tau, c.base);
  ContactSetWorkspace work(ur5());
  ContactSetResult out;
  const BaseWrench base = exact(c.base);
  sense_contacts(sensor, {c.q, c.tau, &base}, noiseless(2), work, out);
  ASSERT_EQ(out.verdict, Verdict::Explained);
  EXPECT_EQ(out.contacts, 2);
  EXPECT_TRUE(out.ambiguous);
  int same_link = 0;
  for (const ContactSet& set : out.sets) {
    if (set.contacts[0].link != wrist || set.contacts[1].link != wrist) continue;
    ++same_link;
    EXPECT_GE(set.freedom, 4);  // a wrench against ten
    const double size = sensor.links()[static_cast<std::size_t>(wrist)].surface.size;
    EXPECT_GT(set.deviation[0], 0.1 * size);
  }
  EXPECT_GT(same_link, 0);
}

TEST(ContactSets, OrderOfContacts_DoesNotMatter) {
  core::Random random(5, 0);
  const Sensor& sensor = *ur5();
  const KnownCases c = make_random_cases(sensor, std::array{2, 3, 4, 5}, FrictionCone(1, 4), 10, 3, random);
  world::KinematicsWorkspace kinematics_work(sensor.model());
  world::Kinematics kinematics;
  world::calc_kinematics(sensor.model(), c.q, kinematics_work, kinematics);
  std::vector<int> bodies;
  for (const auto& sensed : sensor.links()) bodies.push_back(sensed.surface.body);
  ContactRowsWorkspace rows_work;
  ContactRows rows;
  const BaseWrench base = exact(c.base);
  calc_contact_rows(sensor.model(), kinematics, bodies, c.tau, &base, 1e-3, rows_work, rows);
  const FrictionCone cone(1, 4);
  const JointProblem problem{sensor, rows, cone, 1e-10, 1e-3};
  JointWorkspace work;
  ContactSet first = make_set(sensor, c.contacts);
  evaluate(problem, work, first);
  EXPECT_LT(first.residual, 1e-10 * rows.tau.squaredNorm());  // the forces are in the cone and make the rows
  std::array<int, 3> order{0, 1, 2};
  while (std::next_permutation(order.begin(), order.end())) {
    ContactSet other = first;
    for (std::size_t i = 0; i < 3; ++i) other.contacts[i] = first.contacts[static_cast<std::size_t>(order[i])];
    evaluate(problem, work, other);
    EXPECT_NEAR(other.objective, first.objective, 1e-10 * rows.tau.squaredNorm());
    EXPECT_NEAR(calc_distance(other, c.contacts), 0, 1e-9);
    for (std::size_t i = 0; i < 3; ++i)
      EXPECT_NEAR((other.contacts[i].f_L - first.contacts[static_cast<std::size_t>(order[i])].f_L).norm(), 0, 1e-4);
  }
}

bool operator==(const ContactSet& a, const ContactSet& b) {
  bool same = a.count == b.count && a.objective == b.objective && a.freedom == b.freedom;
  for (std::size_t i = 0; i < static_cast<std::size_t>(a.count); ++i)
    same &= a.contacts[i].p_L == b.contacts[i].p_L && a.contacts[i].f_L == b.contacts[i].f_L;
  return same;
}

TEST(ContactSets, ThreadsThatShareASensor_GiveTheSameBits) {
  core::Random random(6, 0);
  const KnownCases c = make_random_cases(*ur5(), std::array{2, 4}, FrictionCone(1, 4), 10, 2, random);
  std::array<ContactSetResult, 3> results;
  std::vector<std::thread> threads;
  for (ContactSetResult& result : results) {
    threads.emplace_back([&] {
      ContactSetWorkspace work(ur5());
      for (int i = 0; i < 2; ++i) sense_contacts(*ur5(), {c.q, c.tau}, noiseless(2), work, result);  // and a workspace that was used
    });
  }
  for (std::thread& thread : threads) thread.join();
  ASSERT_FALSE(results[0].sets.empty());
  for (const ContactSetResult& result : results) {
    ASSERT_EQ(result.sets.size(), results[0].sets.size());
    for (std::size_t i = 0; i < result.sets.size(); ++i) EXPECT_TRUE(result.sets[i] == results[0].sets[i]) << i;
  }
}

TEST(ContactSets, RepeatedCycle_UsesNoHeap) {
  if (!bench::counts_allocations()) GTEST_SKIP() << "mallocs are not counted under sanitizers";
  ASSERT_GT(bench::allocations(), 0) << "the counter does not count";
  core::Random random(7, 0);
  const KnownCases c = make_random_cases(*ur5(), std::array{2, 4}, FrictionCone(1, 4), 10, 2, random);
  ContactSetWorkspace work(ur5());
  ContactSetResult out;
  const ContactSetOptions options = noiseless(3);
  for (int i = 0; i < 2; ++i) sense_contacts(*ur5(), {c.q, c.tau, &c.base}, options, work, out);
  ASSERT_FALSE(out.sets.empty());
  const long before = bench::allocations();
  sense_contacts(*ur5(), {c.q, c.tau, &c.base}, options, work, out);
  EXPECT_EQ(bench::allocations() - before, 0);
}

TEST(ContactSets, SetsOfTheLastCycle_AreFollowedUntilTheyDoNotExplain) {
  core::Random random(2, 0);
  ContactSetWorkspace work(ur5());
  ContactSetResult first, out;
  const int links[] = {link("shoulder_link"), link("wrist_3_link")};
  KnownCases c = make_random_cases(*ur5(), links, FrictionCone(1, 4), 10, 2, random);
  BaseWrench base = exact(c.base);
  sense_contacts(*ur5(), {c.q, c.tau, &base}, noiseless(2), work, first);
  ASSERT_EQ(first.verdict, Verdict::Explained);
  ASSERT_LT(distance(first, c.contacts), 0.01);
  // A little later, in another posture and with stronger forces.
  c.q.array() += 0.02;
  for (ContactPoint& contact : c.contacts) contact.f_L *= 1.1;
  calc_known_rows(*ur5(), c.q, c.contacts, c.tau, c.base);
  base = exact(c.base);
  sense_contacts(*ur5(), {c.q, c.tau, &base, &first.sets}, noiseless(2), work, out);
  EXPECT_EQ(out.verdict, Verdict::Explained);
  EXPECT_LT(distance(out, c.contacts), 0.01);
  ContactSetResult anew;
  sense_contacts(*ur5(), {c.q, c.tau, &base}, noiseless(2), work, anew);
  EXPECT_LT(out.descents, anew.descents) << "no second search";
  // Where the sets before do not help, the answer is that of a search without them; where one contact does, they are not asked.
  for (const int other : {link("upper_arm_link"), link("wrist_2_link")}) {
    const int changed[] = {other, link("wrist_3_link")};
    const KnownCases d = make_random_cases(*ur5(), changed, FrictionCone(1, 4), 10, 2, random);
    const BaseWrench under = exact(d.base);
    sense_contacts(*ur5(), {d.q, d.tau, &under, &first.sets}, noiseless(2), work, out);
    sense_contacts(*ur5(), {d.q, d.tau, &under}, noiseless(2), work, anew);
    EXPECT_EQ(out.verdict, anew.verdict);
    EXPECT_EQ(out.contacts, anew.contacts);
    EXPECT_EQ(distance(out, d.contacts), distance(anew, d.contacts));
  }
  const KnownCases one = make_random_cases(*ur5(), std::array{link("wrist_3_link")}, FrictionCone(1, 4), 10, 1, random);
  const BaseWrench under = exact(one.base);
  sense_contacts(*ur5(), {one.q, one.tau, &under, &first.sets}, noiseless(2), work, out);
  EXPECT_EQ(out.contacts, 1);
}

TEST(ContactSets, SmallTorques_AreBelowTheThreshold) {
  ContactSetWorkspace work(ur5());
  ContactSetResult out;
  VectorXd tau = VectorXd::Zero(6);
  tau[1] = 0.39;  // below 4 · 0.1
  sense_contacts(*ur5(), {VectorXd::Zero(6), tau}, {}, work, out);
  EXPECT_EQ(out.verdict, Verdict::BelowThreshold);
  EXPECT_TRUE(out.sets.empty());
  EXPECT_FALSE(out.ambiguous);
}

TEST(ContactSets, BadInput_IsNamed) {
  using stiction::test::message_of;
  ContactSetWorkspace work(ur5());
  ContactSetResult out;
  const VectorXd q = VectorXd::Zero(6), tau = VectorXd::Ones(6);
  const auto with = [&](const VectorXd& torques, const BaseWrench* base, const ContactSetOptions& options) {
    return message_of([&] { sense_contacts(*ur5(), {q, torques, base}, options, work, out); });
  };
  EXPECT_EQ(with(tau.head(5), nullptr, {}), "tau: got 5 numbers, expected 6");
  ContactSetOptions options;
  options.max_contacts = 4;
  EXPECT_EQ(with(tau, nullptr, options), "max_contacts: got 4, expected an integer from 1 to 3");
  options = {};
  options.sense.cone = FrictionCone(0.5, 0);
  EXPECT_EQ(with(tau, nullptr, options), "rays: got 0 (the exact cone), expected a polyhedral cone, of 3 to 64 rays, for several contacts");
  BaseWrench base;
  base.force_noise = 0;
  EXPECT_EQ(with(tau, &base, {}), "base_wrench.force_noise: got 0, expected a finite number > 0");
  base = {};
  base.moment_W[1] = std::nan("");
  EXPECT_EQ(with(tau, &base, {}), "base_wrench.moment[1]: got nan, expected a finite number");
  std::vector<ContactSet> last(1);
  last[0].count = 1;
  last[0].contacts[0].link = 7;
  EXPECT_EQ(message_of([&] {
              sense_contacts(*ur5(), {q, tau, nullptr, &last}, {}, work, out);
            }),
            "last: got a contact on link 7 of 7, expected contacts of the same sensor");
  last[0].contacts[0].link = 6;
  EXPECT_NE(message_of([&] {
              sense_contacts(*ur5(), {q, tau, nullptr, &last}, {}, work, out);
            }).find("last: got a contact on triangle -1 of "),
            std::string::npos);
  last[0].count = kMostContacts + 1;
  EXPECT_EQ(message_of([&] {
              sense_contacts(*ur5(), {q, tau, nullptr, &last}, {}, work, out);
            }),
            "last: got a set of 4 contacts, expected sets of at most 3");
}

}  // namespace
}  // namespace stiction::sensing::test
