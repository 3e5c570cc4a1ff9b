// No heap use after the first tick. Every malloc of this program is counted (glibc; not under sanitizers, which bring their own).
#include <gtest/gtest.h>

#include "cone_allocations.hpp"
#include "control/arm_scene.hpp"
#include "stiction/control/controller.hpp"
#include "stiction/core/random.hpp"

namespace stiction::control::test {
namespace {

void run(const ControllerOptions& options, bool with_tool) {
  const auto model = make_arm();
  ContactController controller(model, options);
  const Eigen::VectorXd q = posture();
  Eigen::VectorXd q_ref = q;
  controller.configure(q);
  const int link = find_body(*model, "arm/link_7");
  const ToolReference tool{.body = link, .X_BT = {}, .X_WT = {Eigen::Matrix3d::Identity(), {0.6, 0.1, 0.4}}};
  core::Random random(1, 0);
  std::vector<ContactForce> contacts(3);
  double time = 0;
  long before = 0;
  for (int k = 0; k < 300; ++k) {
    for (int i = 0; i < 3; ++i)
      contacts[static_cast<std::size_t>(i)] = {
          .id = random.index(5), .body = link - i, .p_WC = {0.5, 0.1 * i, 0.4}, .force_W = {10, 20 * random.normal(), 5}};
    q_ref[0] = 0.3 * random.normal();
    const std::size_t n = k < 10 ? 3 : static_cast<std::size_t>(random.index(4));
    (void)controller.update(
        {.time = time += 0.005, .q = q, .q_ref = q_ref, .contacts = {contacts.data(), n}, .tool = with_tool ? &tool : nullptr}, 0.005);
    if (k == 9) before = bench::allocations();
  }
  EXPECT_EQ(bench::allocations(), before);
}

TEST(ControllerAllocation, AfterTheFirstTicks_NothingIsAllocated) {
  ControllerOptions options;
  run(options, false);
  run(options, true);
  options.qp.cost = TrackingCost::Equilibrium;
  run(options, false);
  options.law = Law::NullSpace;
  run(options, true);
  if (!bench::counts_allocations()) GTEST_SKIP() << "mallocs are not counted under sanitizers";
  const long before = bench::allocations();
  const auto counted = std::make_unique<std::vector<int>>(100);
  EXPECT_GT(bench::allocations(), before) << "the counter does not count";
}

}  // namespace
}  // namespace stiction::control::test
