// Contacts from torques, and the force of an arm that is told of them.
#include "stiction/execution/contact_control/contact_estimator.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "stiction/execution/contact_control/control_run.hpp"
#include "stiction/sensing/scenario.hpp"
#include "stiction/tasks/control_scenario_file.hpp"
#include "support/message_of.hpp"
#include "support/paths.hpp"

namespace stiction::execution::test {
namespace {

using core::Status;
using Eigen::Vector3d;
using Eigen::VectorXd;
using stiction::test::message_of;
using stiction::test::source_dir;
using tasks::load_control_scenario;

constexpr double kTick = 0.005;

ControlScenario load_estimated(const char* name) {
  ControlScenario out = load_control_scenario(source_dir() / "scenarios" / name);
  out.contacts = ContactSource::Estimated;
  return out;
}

ContactEstimatorOptions exact() {
  ContactEstimatorOptions out;
  out.noise = 1e-3;
  return out;
}

class Estimator : public testing::Test {
 protected:
  ControlScenario scenario = load_estimated("box_in_the_way.yaml");
  VectorXd q = scenario.start;

  /// Torques of a force along the inward normal of the middle of a link.
  VectorXd push(const ContactEstimator& estimator, const char* link, double force, Vector3d* p_W = nullptr) {
    const auto& sensor = estimator.sensor();
    const auto& sensed = sensor.links()[static_cast<std::size_t>(sensor.link_index(link))];
    const sensing::SurfacePoint& at = sensed.samples[7];
    const VectorXd full = sensing::place_robots(*scenario.model, q);
    if (p_W != nullptr) {
      world::KinematicsWorkspace work(*scenario.model);
      world::Kinematics kinematics;
      world::calc_kinematics(*scenario.model, full, work, kinematics);
      *p_W = kinematics.X_WB[static_cast<std::size_t>(sensed.surface.body)] * at.p_L;
    }
    const Vector3d n = sensed.surface.normal(at.triangle, at.p_L, sensor.options().normals);
    return sensing::calc_contact_torque(*scenario.model, full, sensed.surface.body, at.p_L, -force * n);
  }
};

TEST_F(Estimator, PushOnALink_IsAmongTheContactsWithItsForce) {
  ContactEstimatorOptions options = exact();
  options.max_candidates = 8;
  ContactEstimator estimator(scenario.model, options);
  Vector3d p_W;
  const auto contacts = estimator.update(q, push(estimator, "arm/link_6", 20, &p_W), q, kTick);
  ASSERT_FALSE(contacts.empty());
  double nearest = 1, force = 0;
  for (const auto& c : contacts)
    if ((c.p_WC - p_W).norm() < nearest) nearest = (c.p_WC - p_W).norm(), force = c.force_W.norm();
  EXPECT_LT(nearest, 0.01);
  EXPECT_NEAR(force, 20, 0.5);
}

/// As a robot gives them that reports what it does to its surroundings, with offsets.
TEST_F(Estimator, RestAndSignOfTheTorques_AreTakenOff) {
  ContactEstimatorOptions options = exact();
  ContactEstimator plain(scenario.model, options);
  options.sense.torques.rest = VectorXd::LinSpaced(7, -0.4, 0.3);
  options.sense.torques.sign = -1;
  ContactEstimator told(scenario.model, options);
  const VectorXd tau = push(plain, "arm/link_6", 20);
  const auto want = plain.update(q, tau, q, kTick);
  const auto got = told.update(q, options.sense.torques.rest - tau, q, kTick);
  ASSERT_FALSE(want.empty());
  ASSERT_EQ(got.size(), want.size());
  for (std::size_t i = 0; i < got.size(); ++i) {
    EXPECT_EQ(got[i].body, want[i].body);
    EXPECT_LT((got[i].p_WC - want[i].p_WC).norm(), 1e-6);
    EXPECT_LT((got[i].force_W - want[i].force_W).norm(), 1e-6);
  }
}

/// Torques within what joints that stick may hide are no contact, also once offsets were learned well; more than that is one.
TEST_F(Estimator, FrictionOfJointsThatStick_IsNoContact) {
  ContactEstimatorOptions options = exact();
  options.bias = 0.02;
  ContactEstimator plain(scenario.model, options);
  options.friction = VectorXd::Constant(7, 0.1);
  ContactEstimator told(scenario.model, options);
  VectorXd zero = VectorXd::Zero(7), stuck = push(told, "arm/link_6", 1);
  stuck *= 0.1 / stuck.cwiseAbs().maxCoeff();
  for (int k = 0; k < 200; ++k) {
    ASSERT_TRUE(told.update(q, zero, q, kTick).empty());
    (void)plain.update(q, zero, q, kTick);
  }
  std::size_t taken_for_touch = 0, felt = 0;
  for (int k = 0; k < 20; ++k) {
    EXPECT_TRUE(told.update(q, stuck, q, kTick).empty());
    taken_for_touch += plain.update(q, stuck, q, kTick).size();
  }
  EXPECT_GT(taken_for_touch, 0u) << "without friction these are contacts: the test would say nothing";
  const VectorXd pushed = stuck + push(told, "arm/link_6", 20);
  for (int k = 0; k < 20; ++k) felt = told.update(q, pushed, q, kTick).size();
  EXPECT_GT(felt, 0u);
  options.friction = VectorXd::Constant(3, 0.1);
  EXPECT_NE(message_of([&] { ContactEstimator(scenario.model, options); }).find("estimator.friction"), std::string::npos);
}

/// The wrist of a real arm is thirty times as quiet as its shoulder: what its torques show is felt, though one noise for all would hide it.
TEST_F(Estimator, NoiseOfEachJoint_ShowsWeakTouchesOfTheHand) {
  ContactEstimatorOptions options;
  options.noise = 0.0538, options.least_force = 500;  // without a low-pass
  ContactEstimator uniform(scenario.model, options);
  const VectorXd noise = (VectorXd(7) << 0.0538, 0.0327, 0.0386, 0.049, 0.0047, 0.0044, 0.0016).finished();
  options.sense.torques.covariance = noise.array().square().matrix().asDiagonal();
  ContactEstimator by_joint(scenario.model, options);
  const VectorXd tau = sensing::calc_contact_torque(*scenario.model, sensing::place_robots(*scenario.model, q),
                                                    by_joint.sensor().links().back().surface.body, {0.031, 0, 0.06}, {-0.3, 0, 0});
  EXPECT_LT(tau.cwiseAbs().maxCoeff(), 4 * 0.0538);
  std::size_t felt = 0, hidden = 0;
  for (int k = 0; k < 100; ++k) felt = by_joint.update(q, tau, q, kTick).size(), hidden = uniform.update(q, tau, q, kTick).size();
  EXPECT_GT(felt, 0u);
  EXPECT_EQ(hidden, 0u);
  EXPECT_NEAR(by_joint.noise(), std::exp(noise.array().log().mean()), 1e-4) << "s of (Y.17)";
}

TEST_F(Estimator, SeveralContacts_AreFoundWithNoiseOfEachJointToo) {
  ContactEstimatorOptions options = exact();
  options.least_force = 500;
  options.sense.torques.covariance = 1e-6 * VectorXd::LinSpaced(7, 1, 2).asDiagonal().toDenseMatrix();
  ContactEstimator estimator(scenario.model, options);
  const VectorXd tau = push(estimator, "arm/link_3", 20) + push(estimator, "arm/link_7", 15);
  std::vector<control::ContactForce> got;
  for (int k = 0; k < 50; ++k) {
    const auto told = estimator.update(q, tau, q, kTick);
    got.assign(told.begin(), told.end());
  }
  ASSERT_GE(got.size(), 2u);
  const VectorXd full = sensing::place_robots(*scenario.model, q);
  world::KinematicsWorkspace work(*scenario.model);
  world::Kinematics kinematics;
  world::calc_kinematics(*scenario.model, full, work, kinematics);
  VectorXd made = VectorXd::Zero(7);
  for (const auto& c : got) {
    if (c.set != got.front().set) continue;
    const world::Pose X_LW = kinematics.X_WB[static_cast<std::size_t>(c.body)].inverse();
    made += sensing::calc_contact_torque(*scenario.model, full, c.body, X_LW * c.p_WC, X_LW.R * c.force_W);
  }
  EXPECT_LT((made - tau).norm(), 0.02 * tau.norm()) << "together they make the torques";
}

TEST_F(Estimator, TorquesThatCannotBeMeant_AreRefused) {
  const auto message = [&](const sensing::TorqueModel& torques) {
    ContactEstimatorOptions options = exact();
    options.sense.torques = torques;
    return message_of([&] { ContactEstimator(scenario.model, options); });
  };
  EXPECT_NE(message({.rest = VectorXd::Zero(6)}).find("rest"), std::string::npos);
  EXPECT_NE(message({.sign = 2}).find("sign: got 2"), std::string::npos);
  EXPECT_NE(message({.covariance = Eigen::MatrixXd::Zero(7, 7)}).find("noise: got a variance of 0 in joint 0"), std::string::npos);
}

/// The arm of a scenario whose torques have offsets and a noise of their own in each joint.
TEST(EstimatedLoop, RestAndNoiseOfAScenario_KeepForcesBounded) {
  ControlScenario scenario = load_estimated("box_in_the_way.yaml");
  scenario.observer.rest = (VectorXd(7) << -0.39, -0.06, -0.16, 0.11, -0.14, -0.08, -0.38).finished();
  scenario.observer.joint_noise = (VectorXd(7) << 0.0538, 0.0327, 0.0386, 0.049, 0.0047, 0.0044, 0.0016).finished();
  ControlRunResult out;
  ASSERT_EQ(run_control(scenario, {}, out), Status::Solved);
  for (const ControlSample& sample : out.samples) {
    if (sample.largest_force > 0) break;
    ASSERT_TRUE(sample.reported.empty()) << "at rest nothing touches: offsets are no contact";
  }
  EXPECT_GE(out.makes, 1);
  EXPECT_LE(out.settled_peak, 18);
}

TEST_F(Estimator, SeveralCandidates_AreAlternativesAndKeepTheirNumbers) {
  ContactEstimatorOptions options = exact();
  options.noise = 0.2, options.least_force = 500;  // without a low-pass, so that the first tick sees all of the torque
  ContactEstimator estimator(scenario.model, options);
  const VectorXd tau = push(estimator, "arm/link_5", 15);
  const auto told = estimator.update(q, tau, q, kTick);
  const std::vector<control::ContactForce> first(told.begin(), told.end());
  ASSERT_GT(first.size(), 1u) << "noise leaves one candidate: the test would say nothing";
  EXPECT_LE(first.size(), static_cast<std::size_t>(options.max_candidates));
  for (const auto& c : first) EXPECT_TRUE(c.alternative);
  for (const auto& c : estimator.update(q, tau, q, kTick))
    EXPECT_TRUE(std::any_of(first.begin(), first.end(), [&](const auto& f) { return f.id == c.id; })) << c.id;
}

/// A second push beside one that lasts: both are told as one set, the first where it was, and the work of a tick stays bounded.
TEST_F(Estimator, SecondContact_IsToldBesideTheFirst) {
  ContactEstimator estimator(scenario.model, exact());
  Vector3d first, second;
  const VectorXd one = push(estimator, "arm/link_4", 15, &first), other = push(estimator, "arm/link_7", 15, &second);
  for (int k = 0; k < 10; ++k) (void)estimator.update(q, one, q, kTick);
  ASSERT_EQ(estimator.hypotheses().front().count, 1);
  std::span<const control::ContactForce> told;
  for (int k = 0; k < 40; ++k) told = estimator.update(q, one + other, q, kTick);
  ASSERT_FALSE(told.empty());
  ASSERT_EQ(estimator.hypotheses().front().count, 2);
  const double explained = estimator.sensed().explained;
  EXPECT_LE(estimator.hypotheses().front().residual, explained);
  EXPECT_FALSE(estimator.sensed().candidates.front().explains) << "one contact would do: the test says nothing";
  double near_first = 1, near_second = 1;
  for (const auto& c : told) {
    near_first = std::min(near_first, (c.p_WC - first).norm()), near_second = std::min(near_second, (c.p_WC - second).norm());
    EXPECT_EQ(c.set >= 0 && c.set < static_cast<int>(estimator.hypotheses().size()), true);
    EXPECT_EQ(c.alternative, estimator.hypotheses().size() > 1);
  }
  EXPECT_LT(near_first, 0.1);
  EXPECT_LT(near_second, 0.1);
  std::vector<int> ids;
  for (const auto& c : told) ids.push_back(c.id);
  std::sort(ids.begin(), ids.end());
  EXPECT_EQ(std::adjacent_find(ids.begin(), ids.end()), ids.end()) << "two contacts under one number";
  for (int k = 0; k < 10; ++k) (void)estimator.update(q, one, q, kTick);
  EXPECT_EQ(estimator.hypotheses().front().count, 1) << "the second is gone";
}

/// Seven torques leave two contacts open. With the wrench at the base thirteen numbers do not: both are told where they are, as one set.
TEST_F(Estimator, WrenchAtTheBase_TellsTwoContactsApart) {
  ContactEstimatorOptions options = exact();
  options.base = BaseSensorOptions{.force_noise = 1e-3, .moment_noise = 1e-3};
  ContactEstimator with_base(scenario.model, options), alone(scenario.model, exact());
  Vector3d first, second;
  const VectorXd one = push(alone, "arm/link_4", 15, &first), other = push(alone, "arm/link_7", 12, &second);
  const auto on_link = [&](const char* link, double force) {  // the force of push() in W
    const auto& sensed = alone.sensor().links()[static_cast<std::size_t>(alone.sensor().link_index(link))];
    world::KinematicsWorkspace work(*scenario.model);
    world::Kinematics kinematics;
    world::calc_kinematics(*scenario.model, sensing::place_robots(*scenario.model, q), work, kinematics);
    const sensing::SurfacePoint& at = sensed.samples[7];
    return Vector3d(kinematics.X_WB[static_cast<std::size_t>(sensed.surface.body)].R *
                    (-force * sensed.surface.normal(at.triangle, at.p_L, alone.sensor().options().normals)));
  };
  const auto a = sensing::calc_base_wrench(first, on_link("arm/link_4", 15)),
             b = sensing::calc_base_wrench(second, on_link("arm/link_7", 12));
  sensing::BaseWrench both = a;
  both.force_W += b.force_W, both.moment_W += b.moment_W;
  const auto worst = [&](std::span<const control::ContactForce> told) {
    double near_first = 1, near_second = 1;
    for (const auto& c : told)
      near_first = std::min(near_first, (c.p_WC - first).norm()), near_second = std::min(near_second, (c.p_WC - second).norm());
    return std::max(near_first, near_second);
  };
  for (int k = 0; k < 10; ++k) (void)with_base.update(q, one, q, kTick, &a), (void)alone.update(q, one, q, kTick);
  for (int k = 0; k < 60; ++k) (void)with_base.update(q, one + other, q, kTick, &both), (void)alone.update(q, one + other, q, kTick);
  const auto told = with_base.update(q, one + other, q, kTick, &both);
  ASSERT_EQ(with_base.hypotheses().size(), 1u);
  ASSERT_EQ(told.size(), 2u);
  EXPECT_LT(worst(told), 0.01);
  EXPECT_NEAR(told[0].force_W.norm() + told[1].force_W.norm(), 27, 0.5);
  EXPECT_GT(worst(alone.update(q, one + other, q, kTick)), 0.01) << "torques alone would do: the test says nothing";
}

TEST_F(Estimator, WrenchAtTheBase_IsToldWhereThereIsASensorAndOnlyThere) {
  ContactEstimatorOptions options = exact();
  ContactEstimator without(scenario.model, options);
  options.base.emplace();
  ContactEstimator with(scenario.model, options);
  const sensing::BaseWrench base;
  EXPECT_NE(message_of([&] { (void)with.update(q, VectorXd::Zero(7), q, kTick); }).find("base: got none"), std::string::npos);
  EXPECT_NE(message_of([&] { (void)without.update(q, VectorXd::Zero(7), q, kTick, &base); }).find("base: got a wrench"), std::string::npos);
  EXPECT_TRUE(with.update(q, VectorXd::Zero(7), q, kTick, &base).empty());
}

/// A sensor that is never quiet at zero: its offset is learned with those of the torques, and is no contact.
TEST_F(Estimator, OffsetsOfTheBase_AreLearnedToo) {
  ContactEstimatorOptions options = exact();
  options.base = BaseSensorOptions{.force_noise = 0.1, .moment_noise = 0.02, .force_offset = 5, .moment_offset = 1};
  ContactEstimator estimator(scenario.model, options);
  sensing::BaseWrench base;
  base.force_W = {4, -3, 6}, base.moment_W = {0.8, 1, -0.5};
  for (int k = 0; k < 100; ++k) EXPECT_TRUE(estimator.update(q, VectorXd::Zero(7), q, kTick, &base).empty()) << k;
  ASSERT_TRUE(estimator.is_ready());
  EXPECT_LT((estimator.offset().segment<3>(7) - base.force_W).norm(), 0.05);
  EXPECT_LT((estimator.offset().tail<3>() - base.moment_W).norm(), 0.01);
}

TEST_F(Estimator, NoTorque_IsNoContact) {
  ContactEstimator estimator(scenario.model, exact());
  EXPECT_TRUE(estimator.update(q, VectorXd::Zero(7), q, kTick).empty());
  EXPECT_FALSE(estimator.update(q, push(estimator, "arm/link_6", 20), q, kTick).empty());
  EXPECT_TRUE(estimator.update(q, VectorXd::Zero(7), q, kTick).empty());
}

/// Two new descents a tick find in some ticks what one search of everything finds, and a tick never makes more than its share of descents.
TEST_F(Estimator, SearchOverTicks_FindsWhatAFullSearchFinds) {
  ContactEstimatorOptions options = exact();
  options.noise = 0.2, options.least_force = 500;
  ContactEstimatorOptions full = options;
  full.sense.max_descents = 10000;
  ContactEstimator some(scenario.model, options), all(scenario.model, full);
  int told = 0;
  for (const char* link : {"arm/link_4", "arm/link_5", "arm/link_6", "arm/link_7"}) {
    some.reset(), all.reset();
    const VectorXd tau = push(all, link, 15);
    std::vector<control::ContactForce> found;
    for (int k = 0; k < 20; ++k) {
      const auto contacts = some.update(q, tau, q, kTick);
      found.assign(contacts.begin(), contacts.end());
      ASSERT_LE(some.sensed().descents, options.pool + *options.sense.max_descents);
    }
    const auto best = all.update(q, tau, q, kTick);
    ASSERT_FALSE(best.empty()) << link;
    EXPECT_GT(all.sensed().descents, options.pool + *options.sense.max_descents) << "the full search is no longer than a tick's";
    const double spacing = all.sensor().links()[static_cast<std::size_t>(all.sensor().link_index(link))].spacing;
    told += std::any_of(found.begin(), found.end(),
                        [&](const auto& c) { return c.body == best[0].body && (c.p_WC - best[0].p_WC).norm() < spacing; });
  }
  EXPECT_EQ(told, 4);
}

/// What is told follows the torques when they end, and what comes next is another contact.
TEST_F(Estimator, ContactThatIsLost_IsNoLongerToldAndTheNextHasAnotherNumber) {
  ContactEstimator estimator(scenario.model, exact());
  const VectorXd tau = push(estimator, "arm/link_6", 20);
  const auto first = estimator.update(q, tau, q, kTick);
  ASSERT_FALSE(first.empty());
  const int id = first[0].id;
  ASSERT_EQ(estimator.update(q, tau, q, kTick)[0].id, id) << "it stays the same while it lasts";
  EXPECT_TRUE(estimator.update(q, VectorXd::Zero(7), q, kTick).empty());
  const auto next = estimator.update(q, tau, q, kTick);
  ASSERT_FALSE(next.empty());
  for (const auto& c : next) EXPECT_NE(c.id, id);
}

TEST_F(Estimator, LowPassFollowsFromNoiseAndTheLeastForce) {
  ContactEstimatorOptions options;
  options.noise = 1e-3, options.lag = 0.01, options.least_force = 5;
  const ContactEstimator quiet(scenario.model, options);
  EXPECT_EQ(quiet.time_constant(), 0);
  double spacing = 0;
  for (const auto& link : quiet.sensor().links()) spacing = std::max(spacing, link.spacing);
  options.noise = 5 * spacing;  // three deviations move the point of 5 N by three spacings: of their square a ninth may stay
  const ContactEstimator noisy(scenario.model, options);
  EXPECT_NEAR(noisy.time_constant(), 8 * 0.01, 1e-12);
}

/// Offsets that no contact makes, and then a contact.
TEST_F(Estimator, OffsetsAreLearnedWhileNothingTouches_AndAForceIsNotForgotten) {
  ContactEstimatorOptions options = exact();
  options.bias = 1.5;
  ContactEstimator estimator(scenario.model, options);
  VectorXd offset(7);
  offset << 1.5, -1.2, 0.9, -1.5, 0.3, 0.6, -0.4;
  EXPECT_TRUE(estimator.update(q, offset, q, kTick).empty()) << "a contact would explain that";
  EXPECT_FALSE(estimator.is_ready());
  for (int k = 0; k < 20; ++k) EXPECT_TRUE(estimator.update(q, offset, q, kTick).empty()) << k;
  EXPECT_TRUE(estimator.is_ready());
  EXPECT_LT((estimator.offset() - offset).norm(), 1e-6) << "(s/b)² of it is the prior's";
  for (int k = 0; k < 200; ++k) {  // it moves by 0.2 rad, over which they change
    q[0] += 1e-3, offset[1] += 1e-3;
    EXPECT_TRUE(estimator.update(q, offset, q, kTick).empty()) << k;
  }
  EXPECT_LT((estimator.offset() - offset).norm(), 0.02);
  Vector3d p_W;
  const VectorXd tau = offset + push(estimator, "arm/link_6", 20, &p_W);
  for (int k = 0; k < 400; ++k) ASSERT_FALSE(estimator.update(q, tau, q, kTick).empty()) << "forgotten in tick " << k;
  double nearest = 1;
  for (const auto& c : estimator.update(q, tau, q, kTick)) nearest = std::min(nearest, (c.p_WC - p_W).norm());
  EXPECT_LT(nearest, 0.05);
}

/// One datagram with a number that is none: nothing is learned from it, and the loop goes on.
TEST_F(Estimator, SampleThatIsNotFinite_IsLeftOut) {
  ContactEstimatorOptions options = exact();
  options.noise = 0.5;  // with a low-pass, which has a memory
  ContactEstimator broken(scenario.model, options), other(scenario.model, options);
  ASSERT_GT(broken.time_constant(), 0);
  const VectorXd tau = push(broken, "arm/link_6", 60);
  for (int k = 0; k < 200; ++k) (void)broken.update(q, tau, q, kTick), (void)other.update(q, tau, q, kTick);
  const auto copy = [](std::span<const control::ContactForce> told) {
    return std::vector<control::ContactForce>(told.begin(), told.end());
  };
  const std::vector<control::ContactForce> before = copy(broken.update(q, tau, q, kTick));
  (void)other.update(q, tau, q, kTick);
  ASSERT_FALSE(before.empty());

  const double nan = std::nan(""), inf = std::numeric_limits<double>::infinity();
  int missed = 0;
  for (const double value : {nan, inf, -inf}) {
    VectorXd bad = tau;
    bad[3] = value;
    const std::vector<control::ContactForce> told = copy(broken.update(q, bad, q, kTick));
    EXPECT_EQ(broken.missed(), ++missed);
    ASSERT_EQ(told.size(), before.size()) << "what was told before is told on";
    for (std::size_t i = 0; i < told.size(); ++i) {
      EXPECT_EQ(told[i].id, before[i].id);
      EXPECT_EQ(told[i].p_WC, before[i].p_WC);
    }
  }
  VectorXd q_bad = q, q_moved = q;
  q_bad[0] = nan, q_moved[0] += 0.5;
  const auto moved = copy(broken.update(q_bad, tau, q_moved, kTick));
  ASSERT_EQ(moved.size(), before.size());
  EXPECT_GT((moved[0].p_WC - before[0].p_WC).norm(), 0.01) << "contacts move on with their links";

  const auto after = copy(broken.update(q, tau, q, kTick)), same = copy(other.update(q, tau, q, 5 * kTick));
  EXPECT_EQ(broken.missed(), 0);
  ASSERT_EQ(after.size(), same.size());
  for (std::size_t i = 0; i < after.size(); ++i) {
    EXPECT_EQ(after[i].p_WC, same[i].p_WC) << "as if the time of the samples that were left out had belonged to this one";
    EXPECT_EQ(after[i].force_W, same[i].force_W);
  }
  q_bad = q, q_bad[1] = nan;
  EXPECT_EQ(message_of([&] { (void)broken.update(q, tau, q_bad, kTick); }), "q_now[1]: got nan, expected a finite number");
  EXPECT_FALSE(broken.update(q, tau, q, kTick).empty());
}

TEST_F(Estimator, BadInput_IsNamed) {
  ContactEstimator estimator(scenario.model, exact());
  EXPECT_NE(message_of([&] { (void)estimator.update(q.head(3), q, q, kTick); }).find("q: got 3 numbers, expected 7"), std::string::npos);
  EXPECT_NE(message_of([&] { (void)estimator.update(q, q.head(3), q, kTick); }).find("tau: got 3 numbers, expected 7"), std::string::npos);
  EXPECT_NE(message_of([&] { (void)estimator.update(q, q, q.head(3), kTick); }).find("q_now: got 3 numbers, expected 7"),
            std::string::npos);
  EXPECT_NE(message_of([&] { (void)estimator.update(q, q, q, 0); }).find("dt: got 0"), std::string::npos);
  ContactEstimatorOptions options;
  options.max_candidates = 0;
  EXPECT_NE(message_of([&] { options.validate(); }).find("estimator.max_candidates"), std::string::npos);
  options.max_candidates = 4, options.max_contacts = 4;
  EXPECT_NE(message_of([&] { options.validate(); }).find("estimator.max_contacts: got 4, expected an integer from 1 to 3"),
            std::string::npos);
  options.max_contacts = 3, options.pool = 3;
  EXPECT_NE(message_of([&] { options.validate(); }).find("estimator.pool: got 3, expected at least max_candidates, 4"), std::string::npos);
  options.pool = 8, options.noise = 0;
  EXPECT_NE(message_of([&] { options.validate(); }).find("estimator.noise: got 0"), std::string::npos);
  options.sensor.links = {"nowhere"};
  EXPECT_NE(message_of([&] { ContactEstimator(scenario.model, options); }).find("estimator.noise: got 0"), std::string::npos)
      << "options are looked at before a sensor is made of them";
  EXPECT_EQ(message_of([&] { ContactEstimator(nullptr, exact()); }), "model: got nothing, expected a model");
}

TEST(EstimatedControl, SameSeed_GivesTheSameBitsAndAnotherDoesNot) {
  ControlScenario scenario = load_estimated("box_in_the_way.yaml");
  scenario.duration = 3.5;
  ControlRunResult a, b, c;
  ASSERT_EQ(run_control(scenario, {}, a), Status::Solved);
  ASSERT_EQ(run_control(scenario, {}, b), Status::Solved);
  scenario.observer.seed = 1;
  ASSERT_EQ(run_control(scenario, {}, c), Status::Solved);
  EXPECT_EQ(a.samples.back().q, b.samples.back().q);
  EXPECT_NE(a.samples.back().q, c.samples.back().q);
}

/// F and the force from which contacts count follow the bound, whoever sets it, unless the scenario names F.
TEST(EstimatedControl, AnotherBound_IsKnownToTheEstimator) {
  ControlScenario scenario = load_estimated("box_in_the_way.yaml");
  EXPECT_EQ(make_estimator_options(scenario).plausible_force, 30);
  EXPECT_EQ(make_estimator_options(scenario).least_force, 5);
  set_lambda_max(scenario, 9);
  EXPECT_EQ(make_estimator_options(scenario).plausible_force, 18);
  EXPECT_EQ(make_estimator_options(scenario).least_force, 3);
  scenario.plausible_force = 50;
  EXPECT_EQ(make_estimator_options(scenario).plausible_force, 50);
  EXPECT_EQ(message_of([&] { set_lambda_max(scenario, 0); }), "lambda_max: got 0, expected a finite number > 0");
}

TEST(EstimatedControl, Delay_TellsOfContactsLaterByThat) {
  const auto first_told = [](double delay) {
    ControlScenario scenario = load_estimated("box_in_the_way.yaml");
    scenario.contacts = ContactSource::True;
    scenario.duration = 3, scenario.delay = delay;
    ControlRunResult out;
    EXPECT_EQ(run_control(scenario, {}, out), Status::Solved);
    double touched = -1, told = -1;
    for (const ControlSample& s : out.samples) {
      if (touched < 0 && s.largest_force > 0) touched = s.time;
      if (told < 0 && !s.reported.empty()) told = s.time;
    }
    EXPECT_GT(touched, 0);
    return told - touched;
  };
  EXPECT_NEAR(first_told(0), 0, 1e-9);
  EXPECT_NEAR(first_told(0.02), 0.02, 1e-9);
}

}  // namespace
}  // namespace stiction::execution::test
