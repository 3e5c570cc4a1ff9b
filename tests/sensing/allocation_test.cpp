#include <gtest/gtest.h>

#include <array>

#include "cone_allocations.hpp"
#include "sensing/robots.hpp"
#include "stiction/sensing/scenario.hpp"

namespace stiction::sensing::test {
namespace {

TEST(SenseAllocations, RepeatedCycle_UsesNoHeap) {
  const auto sensor = Sensor::make(make_arm(kUr5));
  if (!bench::counts_allocations()) GTEST_SKIP() << "mallocs are not counted under sanitizers";
  ASSERT_GT(bench::allocations(), 0) << "the counter does not count";
  core::Random random(5, 0);
  const KnownCase c = make_random_case(*sensor, std::array{4, 5}, FrictionCone(1, 4), 10, random);
  for (const Method& method : {Method(GaussNewton{}), Method(SteepestDescent{}), Method(RejectionSampling{})}) {
    SenseOptions options;
    options.method = method;
    SenseWorkspace work(sensor);
    SenseResult result;
    for (int i = 0; i < 2; ++i) sense(*sensor, {c.q, c.tau}, options, work, result);
    ASSERT_FALSE(result.candidates.empty());
    const long before = bench::allocations();
    sense(*sensor, {c.q, c.tau}, options, work, result);
    EXPECT_EQ(bench::allocations() - before, 0) << "method " << method.index();
  }
}

}  // namespace
}  // namespace stiction::sensing::test
