// Contacts from torques, and the force of an arm that is told of them.
#include "stiction/execution/contact_estimator.hpp"

#include <gtest/gtest.h>

#include "stiction/execution/control_run.hpp"
#include "stiction/sensing/scenario.hpp"
#include "support/message_of.hpp"
#include "support/paths.hpp"

namespace stiction::execution::test {
namespace {

using core::Status;
using Eigen::Vector3d;
using Eigen::VectorXd;
using stiction::test::message_of;
using stiction::test::source_dir;

constexpr double kTick = 0.005;

ControlScenario load(const char* name) {
  ControlScenario out = load_control_scenario(source_dir() / "scenarios" / name);
  out.contacts = ContactSource::Estimated;
  return out;
}

ContactEstimatorOptions exact() {
  ContactEstimatorOptions out;
  out.sense.noise = 1e-3, out.time_constant = 0;
  return out;
}

class Estimator : public testing::Test {
 protected:
  ControlScenario scenario = load("box_in_the_way.yaml");
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

TEST_F(Estimator, SeveralCandidates_AreAlternativesAndKeepTheirNumbers) {
  ContactEstimatorOptions options = exact();
  options.sense.noise = 0.2;
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

TEST_F(Estimator, NoTorque_IsNoContact) {
  ContactEstimator estimator(scenario.model, exact());
  EXPECT_TRUE(estimator.update(q, VectorXd::Zero(7), q, kTick).empty());
  EXPECT_FALSE(estimator.update(q, push(estimator, "arm/link_6", 20), q, kTick).empty());
  EXPECT_TRUE(estimator.update(q, VectorXd::Zero(7), q, kTick).empty());
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
}

class EstimatedLoop : public testing::TestWithParam<const char*> {};

TEST_P(EstimatedLoop, NoisyTorques_ForceStaysAtItsBound) {
  for (const std::uint64_t seed : {0, 1}) {
    ControlScenario scenario = load(GetParam());
    scenario.observer.seed = seed;
    ControlRunResult out;
    ASSERT_EQ(run_control(scenario, {}, out), Status::Solved) << out.message;
    EXPECT_EQ(out.unsolved_ticks, 0);
    ASSERT_GT(out.bounded_ticks, 300) << "the bound is never felt";
    EXPECT_LE(out.bound_error, 2.0) << seed;
    EXPECT_LE(out.bound_p95, 18.0) << seed;
  }
}
INSTANTIATE_TEST_SUITE_P(Scenarios, EstimatedLoop, testing::Values("box_in_the_way.yaml", "mug_placement.yaml"));

TEST(EstimatedControl, SameSeed_GivesTheSameBitsAndAnotherDoesNot) {
  ControlScenario scenario = load("box_in_the_way.yaml");
  scenario.duration = 3.5;
  ControlRunResult a, b, c;
  ASSERT_EQ(run_control(scenario, {}, a), Status::Solved);
  ASSERT_EQ(run_control(scenario, {}, b), Status::Solved);
  scenario.observer.seed = 1;
  ASSERT_EQ(run_control(scenario, {}, c), Status::Solved);
  EXPECT_EQ(a.samples.back().q, b.samples.back().q);
  EXPECT_NE(a.samples.back().q, c.samples.back().q);
}

TEST(EstimatedControl, Delay_TellsOfContactsLaterByThat) {
  const auto first_told = [](double delay) {
    ControlScenario scenario = load("box_in_the_way.yaml");
    scenario.contacts = ContactSource::True;
    scenario.duration = 3, scenario.delay = delay;
    ControlRunResult out;
    EXPECT_EQ(run_control(scenario, {}, out), Status::Solved);
    double touched = -1, told = -1;
    for (const ControlSample& s : out.samples) {
      if (touched < 0 && s.largest_force > 0) touched = s.time;
      if (told < 0 && !s.told.empty()) told = s.time;
    }
    EXPECT_GT(touched, 0);
    return told - touched;
  };
  EXPECT_NEAR(first_told(0), 0, 1e-9);
  EXPECT_NEAR(first_told(0.02), 0.02, 1e-9);
}

}  // namespace
}  // namespace stiction::execution::test
