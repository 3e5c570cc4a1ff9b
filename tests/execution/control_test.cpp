// Acceptance of contact-aware control in the second-order simulation, with contacts as simulated.
#include <gtest/gtest.h>

#include <fstream>

#include "stiction/execution/contact_control/control_run.hpp"
#include "stiction/tasks/control_scenario_file.hpp"
#include "support/message_of.hpp"
#include "support/paths.hpp"
#include "support/temporary_folder.hpp"

namespace stiction::execution::test {
namespace {

using core::Status;
using stiction::test::message_of;
using stiction::test::source_dir;
using tasks::load_control_scenario;

ControlScenario box() { return load_control_scenario(source_dir() / "scenarios" / "box_in_the_way.yaml"); }

ControlRunResult run(const ControlScenario& scenario) {
  ControlRunResult out;
  EXPECT_EQ(run_control(scenario, {}, out), Status::Solved) << out.message;
  EXPECT_EQ(out.unsolved_ticks, 0);
  return out;
}

ControlRunResult run(ControlScenario scenario, control::Law law) {
  scenario.controller.law = law;
  return run(scenario);
}

/// From the last tick with more than 0.9 λ_max to the last one with more than 0.1 λ_max: hops between them do not count [s].
double calc_fall_time(const ControlRunResult& r) {
  double high = 0, low = 0;
  for (const ControlSample& s : r.samples) {
    if (s.largest_force > 0.9 * 15) high = s.time;
    if (s.largest_force > 0.1 * 15) low = s.time;
  }
  return low - high;
}

/// Over the edge of a table the tracking error is 45 mm when the contact is lost: joints are slower than those of the baseline, which jumps.
TEST(ContactControl, OverAnEdge_JointsAreSlowerThanWithNullSpace) {
  const ControlScenario mug = load_control_scenario(source_dir() / "scenarios" / "mug_moving.yaml");
  const ControlRunResult ours = run(mug), equality = run(mug, control::Law::NullSpace);
  EXPECT_LT(ours.peak_speed, equality.peak_speed);
  EXPECT_LT(ours.peak_force, equality.peak_force);
  EXPECT_LE(ours.bound_p95, 18.0);
}

class SeveralContacts : public testing::TestWithParam<const char*> {};

TEST_P(SeveralContacts, ForcesStayAtTheirBound) {
  const ControlScenario scenario = load_control_scenario(source_dir() / "scenarios" / GetParam());
  const ControlRunResult ours = run(scenario), tracking = run(scenario, control::Law::Unconstrained);
  std::size_t most = 0;
  for (const ControlSample& s : ours.samples) most = std::max(most, s.forces.size());
  EXPECT_GE(most, 2u) << "never two contacts at once";
  ASSERT_GT(ours.bounded_ticks, 500);
  EXPECT_LE(ours.bound_error, 2.0);
  EXPECT_LE(ours.bound_p95, 18.0);
  EXPECT_LE(ours.above_ticks, 0.01 * ours.settled_ticks);
  EXPECT_LT(ours.commanded_rise, 0.2 * ours.peak_rise) << "the largest rise in a tick is the command's";
  EXPECT_GT(tracking.mean_force, 5 * 15);
  EXPECT_LT(ours.peak_force, tracking.peak_force);
}
/// A plate on its rim rests on one corner in this tick and on the other in the next: the command does not follow from corner to corner.
TEST(ContactControl, PlateOnItsRim_DoesNotRock) {
  ControlScenario scenario = load_control_scenario(source_dir() / "scenarios" / "plate.yaml");
  const ControlRunResult out = run(scenario);
  EXPECT_LE(out.bound_error, 1.0);
  EXPECT_LE(out.settled_peak, 18.0);
  EXPECT_EQ(out.above_ticks, 0);
}

INSTANTIATE_TEST_SUITE_P(Scenarios, SeveralContacts, testing::Values("two_contacts.yaml", "three_contacts.yaml"));

/// A pair is judged from when it touches on, whatever the others do.
TEST(ContactControl, SecondContactThatArrives_IsSettledOnItsOwn) {
  const ControlScenario scenario = load_control_scenario(source_dir() / "scenarios" / "two_contacts.yaml");
  const ControlRunResult out = run(scenario);
  ControlRunResult again, all;
  again.samples = all.samples = out.samples;
  ControlLoop loop(scenario, scenario.model);
  summarise(scenario, loop, 1e3, again);
  EXPECT_EQ(again.settled_ticks, 0) << "none touches for 1000 s";
  summarise(scenario, loop, 0, all);
  EXPECT_EQ(all.settled_peak, all.peak_force) << "every tick counts";
  EXPECT_LT(out.settled_peak, out.peak_force / 2) << "impacts of the second contact do not";
}

TEST(ContactControl, BoxInTheWay_ForceStaysAtItsBoundWhereTheReferenceAsksForMore) {
  const ControlRunResult ours = run(box()), tracking = run(box(), control::Law::Unconstrained),
                         equality = run(box(), control::Law::NullSpace);
  ASSERT_GT(ours.bounded_ticks, 500) << "the bound is never felt";
  EXPECT_LE(ours.bound_error, 2.0);
  EXPECT_LE(ours.bound_p95, 18.0);
  EXPECT_LE(ours.settled_peak, 18.0);
  EXPECT_GT(tracking.mean_force, 2 * 15) << "tracking alone would do";
  EXPECT_LE(ours.peak_force, (1 + 1e-9) * tracking.peak_force) << "impact: up to rounding both laws come in alike";
  EXPECT_LT(ours.rms_error_contact, tracking.rms_error_contact);
  EXPECT_GT(calc_fall_time(ours), 2 * calc_fall_time(equality)) << "leaves gradually";
  EXPECT_NEAR(ours.samples.back().error, 0, 1e-3) << "back on the reference";
}

TEST(ContactControl, BoundsFrom8To30_SettleWhereTheyAre) {
  double sum_x = 0, sum_y = 0, sum_xx = 0, sum_xy = 0;
  int n = 0;
  for (const double bound : {8.0, 10.0, 15.0, 20.0, 30.0}) {
    ControlScenario scenario = box();
    scenario.controller.lambda_max = bound;
    scenario.controller.force_threshold = std::min(5.0, bound / 3);
    const ControlRunResult out = run(scenario);
    ASSERT_GT(out.bounded_ticks, 300) << bound;
    double force = 0;
    int ticks = 0;
    for (const ControlSample& s : out.samples) {
      if (s.time < 4.5 || s.time > 6) continue;  // the reference rests, 45 mm inside the box
      force += s.largest_force;
      ++ticks;
    }
    force /= ticks;
    EXPECT_NEAR(force, bound, 2.0);
    sum_x += bound, sum_y += force, sum_xx += bound * bound, sum_xy += bound * force, ++n;
  }
  EXPECT_NEAR((n * sum_xy - sum_x * sum_y) / (n * sum_xx - sum_x * sum_x), 1.0, 0.1);
}

TEST(ContactControl, SameScenario_GivesTheSameBits) {
  const ControlRunResult a = run(box()), b = run(box());
  ASSERT_EQ(a.samples.size(), b.samples.size());
  EXPECT_EQ(a.samples.back().q, b.samples.back().q);
  EXPECT_EQ(a.peak_force, b.peak_force);
}

TEST(ControlScenarioFile, BadInput_NamesFileAndField) {
  std::ifstream in(source_dir() / "scenarios" / "box_in_the_way.yaml");
  std::string good((std::istreambuf_iterator<char>(in)), {});
  const std::string relative = "../models";
  good.replace(good.find(relative), relative.size(), (source_dir() / "models").string());
  const std::filesystem::path file = stiction::test::folder_of_the_process() / "control_test_bad.yaml";
  const auto message = [&](const std::string& from, const std::string& to) {
    std::string text = good;
    const auto at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    text.replace(at, from.size(), to);
    std::ofstream(file) << text;
    const std::string out = message_of([&] { (void)load_control_scenario(file); });
    std::filesystem::remove(file);
    return out;
  };
  EXPECT_NE(message("lambda_max: 15", "lambda_max: 0").find("controller.lambda_max: got 0"), std::string::npos);
  EXPECT_NE(message("period: 0.005", "period: 0").find("controller.period: got 0"), std::string::npos);
  EXPECT_NE(message("lambda_max: 15", "lambda_maxi: 15").find("lambda_maxi"), std::string::npos);
  EXPECT_NE(message("time: 4,", "time: 6,").find("time"), std::string::npos);
  EXPECT_NE(message("link: arm/link_7", "link: arm/link_8").find("arm/link_7"), std::string::npos);
  EXPECT_NE(message("start: [0,", "start: [9,").find("limits"), std::string::npos);
  EXPECT_NE(message("force_threshold: 5", "force_threshold: 20").find("force_threshold: got 20"), std::string::npos);
  EXPECT_NE(message("joint_1: 800", "joint_1: 0").find("joint_1"), std::string::npos);
  EXPECT_NE(message("name: box_in_the_way", "name: box_in_the_way\nplant: {contact_time_constant: 1e-5}")
                .find("contact.time_constant: got 1e-05 s"),
            std::string::npos);
  const std::string estimator = "contacts: true, noise: 0.05";
  EXPECT_NE(message(estimator, "contacts: felt, noise: 0.05").find("estimator.contacts: got 'felt'"), std::string::npos);
  EXPECT_NE(message(estimator, "contacts: true, noise: 0").find("estimator.noise: got 0"), std::string::npos);
  EXPECT_NE(message(estimator, "contacts: true, nose: 0.05").find("estimator.nose"), std::string::npos);
  EXPECT_NE(message(estimator, estimator + ", delay: -0.01").find("estimator.delay: got -0.01"), std::string::npos);
  EXPECT_NE(message(estimator, estimator + ", links: [arm/link_8]").find("arm/link_8"), std::string::npos);
}

}  // namespace
}  // namespace stiction::execution::test
