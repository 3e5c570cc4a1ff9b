// The loop from touch to command: contacts known from noisy torques alone, at several rates, delays, offsets and masses.
#include <gtest/gtest.h>

#include "stiction/execution/contact_control/control_run.hpp"
#include "stiction/tasks/control_scenario_file.hpp"
#include "support/paths.hpp"

namespace stiction::execution::test {
namespace {

using core::Status;
using stiction::test::source_dir;
using tasks::load_control_scenario;

struct Case {
  const char* scenario;
  double period = 0.005, delay = 0;  // [s]
  std::uint64_t seed = 0;
  double bias = 0, inertia_error = 0;  // [N m], [-]
};

void PrintTo(const Case& c, std::ostream* out) {
  *out << c.scenario << ", " << c.period << " s, delay " << c.delay << " s, seed " << c.seed << ", offsets " << c.bias << " N m, masses "
       << c.inertia_error;
}

class EstimatedLoop : public testing::TestWithParam<Case> {};

TEST_P(EstimatedLoop, ForceStaysAtItsBound) {
  const Case& c = GetParam();
  ControlScenario scenario = load_control_scenario(source_dir() / "scenarios" / (std::string(c.scenario) + ".yaml"));
  scenario.contacts = ContactSource::Estimated;
  scenario.period = c.period, scenario.delay = c.delay;
  scenario.observer.seed = c.seed;
  scenario.observer.bias = c.bias, scenario.observer.bias_reach = 1, scenario.observer.inertia_error = c.inertia_error;
  scenario.estimator.bias = c.bias;
  ControlRunResult out;
  ASSERT_EQ(run_control(scenario, {}, out), Status::Solved) << out.message;
  EXPECT_EQ(out.unsolved_ticks, 0);
  ASSERT_GT(out.bounded_ticks * c.period, 1.5) << "the bound is never felt";
  EXPECT_LE(out.bound_error, 2.0);
  EXPECT_LE(out.bound_p95, 18.0);
}
INSTANTIATE_TEST_SUITE_P(Seeds, EstimatedLoop,
                         testing::Values(Case{"box_in_the_way"}, Case{.scenario = "box_in_the_way", .seed = 1}, Case{"mug_placement"},
                                         Case{"mug_moving"}, Case{"egg_under_tray"}, Case{"plate"}, Case{"push_along_arm"}));
INSTANTIATE_TEST_SUITE_P(SeveralContacts, EstimatedLoop,
                         testing::Values(Case{"two_contacts"}, Case{.scenario = "two_contacts", .seed = 1}, Case{"three_contacts"},
                                         Case{.scenario = "three_contacts", .seed = 1}));
INSTANTIATE_TEST_SUITE_P(Rates, EstimatedLoop, testing::Values(Case{.scenario = "box_in_the_way", .period = 0.001}));
INSTANTIATE_TEST_SUITE_P(Delays, EstimatedLoop,
                         testing::Values(Case{.scenario = "box_in_the_way", .delay = 0.005},
                                         Case{.scenario = "box_in_the_way", .delay = 0.015},
                                         Case{.scenario = "mug_placement", .delay = 0.03}));
INSTANTIATE_TEST_SUITE_P(Offsets, EstimatedLoop,
                         testing::Values(Case{.scenario = "box_in_the_way", .bias = 0.3, .inertia_error = 0.01},
                                         Case{.scenario = "mug_placement", .bias = 0.3, .inertia_error = -0.01}));

}  // namespace
}  // namespace stiction::execution::test
