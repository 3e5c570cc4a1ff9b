// The 100 000 problems of the release criterion; label slow.
#include <gtest/gtest.h>

#include "cone/random_problem.hpp"

namespace stiction::cone::test {
namespace {

TEST(ConePropertySlow, HundredThousandRandomProblems_SolvedOrProvedInfeasible) {
  int solved = 0, infeasible = 0;
  Result result;
  for (std::uint64_t seed = 1000001; seed <= 1100000; ++seed) {
    const Mode mode = seed % 4 == 0 ? Mode::Smoothed : Mode::Exact;
    const RawProblem raw = make_random(seed);
    const Problem problem = raw.make();
    Workspace work(problem.layout_ptr());
    Options options;
    options.mode = mode;
    options.sensitivities = seed % 2 == 0;
    const core::Status status = solve(problem, options, work, result);
    if (status == core::Status::Infeasible) {
      const Certificate c = check_certificate(raw, result, mode);
      ASSERT_GT(c.margin, 0.0) << "seed " << seed;
      ASSERT_EQ(c.cone, 0.0) << "seed " << seed;
      ++infeasible;
      continue;
    }
    ASSERT_EQ(status, core::Status::Solved) << "seed " << seed << ": " << core::to_string(status);
    const Kkt k = recompute(raw, result, mode);
    ASSERT_LE(k.stationarity, 1e-8) << "seed " << seed;
    ASSERT_LE(k.consistency, 1e-8) << "seed " << seed;
    ASSERT_LE(k.cone, 1e-8) << "seed " << seed;
    ASSERT_LE(k.complementarity, mode == Mode::Exact ? 1e-9 : 1e-8) << "seed " << seed;
    ++solved;
  }
  EXPECT_EQ(solved + infeasible, 100000);
  RecordProperty("infeasible", infeasible);
}

}  // namespace
}  // namespace stiction::cone::test
