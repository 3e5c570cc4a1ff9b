// Status, warm start, determinism, sensitivities, heap use.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>

#include "cone/random_problem.hpp"
#include "cone_allocations.hpp"
#include "cone_problems.hpp"
#include "stiction/core/invalid_input.hpp"
#include "stiction/core/random.hpp"
#include "support/message_of.hpp"

namespace stiction::cone::test {
namespace {

using stiction::test::message_of;

using core::Status;

RawProblem one_bound(double offset) {
  RawProblem raw;
  raw.n = 1;
  raw.groups = {{0}};
  raw.Q = Eigen::MatrixXd::Identity(1, 1);
  raw.b = Eigen::VectorXd::Constant(1, 1.0);
  raw.bounds.push_back({1, 0, 1, offset, 1e-3});
  return raw;
}

TEST(ConeStatus, ContradictingRows_InfeasibleWithCertificate) {
  RawProblem raw = one_bound(-0.1);              // x ≥ 0.1
  raw.bounds.push_back({2, 0, -1, 0.05, 1e-3});  // x ≤ 0.05
  for (const Mode mode : {Mode::Exact, Mode::Smoothed}) {
    const Problem problem = raw.make();
    Workspace work(problem.layout_ptr());
    Options options;
    options.mode = mode;
    Result r;
    ASSERT_EQ(solve(problem, options, work, r), Status::Infeasible);
    const Certificate c = check_certificate(raw, r, mode);
    EXPECT_GT(c.margin, 0);
    EXPECT_EQ(c.cone, 0);
  }
}

TEST(ConeStatus, OneIteration_MaxIterationsAndHonestResiduals) {
  RandomOptions random;
  random.deep = 0;
  const RawProblem raw = make_random(3, random);
  const Problem problem = raw.make();
  Workspace work(problem.layout_ptr());
  Options options;
  options.max_iterations = 1;
  Result r;
  ASSERT_EQ(solve(problem, options, work, r), Status::MaxIterations);
  EXPECT_NEAR(recompute(raw, r, Mode::Exact).stationarity, r.residuals.stationarity, 1e-9);
  EXPECT_GT(r.residuals.complementarity, options.tol_complementarity);
}

TEST(ConeStatus, CancelledBeforeTheFirstStep_Cancelled) {
  const Problem problem = make_random(3).make();
  Workspace work(problem.layout_ptr());
  const std::atomic<bool> cancel{true};
  Options options;
  options.cancel = &cancel;
  Result r;
  EXPECT_EQ(solve(problem, options, work, r), Status::Cancelled);
  EXPECT_EQ(r.iterations, 0);
}

TEST(ConeStatus, IndefiniteQ_NumericalFailure) {
  RawProblem raw = one_bound(1);
  raw.Q(0, 0) = -1;
  const Problem problem = raw.make();
  Workspace work(problem.layout_ptr());
  Result r;
  EXPECT_EQ(solve(problem, Options{}, work, r), Status::NumericalFailure);
}

TEST(ConeInput, NotFinite_NamesTheField) {
  auto layout = std::make_shared<Layout>(2, std::vector<std::vector<int>>{{0}, {1}});
  const std::array<int, 2> both{0, 1};
  const int support = layout->add_support(both);
  Problem p(layout, 1, 1);
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  const double g3[3] = {0, 0, 0}, G3[6] = {1, 0, 0, nan, 0, 0}, ok[6] = {1, 0, 0, 1, 0, 0}, bad3[3] = {0, inf, 0};
  EXPECT_NE(message_of([&] { p.add_cone(1, support, G3, g3, 1); }).find("G"), std::string::npos);
  EXPECT_NE(message_of([&] { p.add_cone(1, support, ok, bad3, 1); }).find("g: "), std::string::npos);
  EXPECT_NE(message_of([&] { p.add_cone(1, support, ok, g3, -1); }).find("sigma"), std::string::npos);
  EXPECT_NE(message_of([&] { p.add_half_line(1, 7, ok, 0, 1); }).find("support"), std::string::npos);
  EXPECT_NE(message_of([&] { p.add_bound(1, 0, 2.0, 0, 1); }).find("sign"), std::string::npos);
  EXPECT_NE(message_of([&] { p.add_bound(1, 5, 1.0, 0, 1); }).find("variable"), std::string::npos);
  EXPECT_NE(message_of([&] { p.set_Q(0, 0, nan); }).find("Q"), std::string::npos);
  EXPECT_NE(message_of([&] { p.set_Q(0, 1, 1.0); }).find("one group"), std::string::npos);
  EXPECT_NE(message_of([&] { p.set_b(0, inf); }).find("b"), std::string::npos);
  EXPECT_EQ(p.n_cones() + p.n_half_lines() + p.n_bounds(), 0) << "a refused row must not stay";
}

TEST(ConeInput, OptionsAndLayouts_NameTheField) {
  Options o;
  o.tol_kkt = 0;
  EXPECT_NE(message_of([&] { o.validate(); }).find("tol_kkt: got 0, expected a number in [1e-12, 0.01]"), std::string::npos);
  o = {};
  o.max_iterations = 0;
  EXPECT_NE(message_of([&] { o.validate(); }).find("max_iterations"), std::string::npos);
  const Problem problem = one_bound(1).make();
  const auto other = std::make_shared<Layout>(1, std::vector<std::vector<int>>{{0}});
  Workspace work(other);
  Result r;
  EXPECT_NE(message_of([&] { (void)solve(problem, Options{}, work, r); }).find("work"), std::string::npos);
  Workspace fresh(problem.layout_ptr());
  Eigen::MatrixXd X(1, 1);
  EXPECT_NE(message_of([&] { apply_inverse(fresh, X); }).find("no factor"), std::string::npos);
  EXPECT_NE(message_of([] { Layout(2, {{0}}); }).find("groups"), std::string::npos);
  EXPECT_NE(message_of([] { Layout(2, {{0, 1, 1}}); }).find("twice"), std::string::npos);
  RawProblem sharp = one_bound(1);
  sharp.bounds[0].sigma = 0;
  const Problem p = sharp.make();
  Workspace w(p.layout_ptr());
  Options smoothed;
  smoothed.mode = Mode::Smoothed;
  EXPECT_NE(message_of([&] { (void)solve(p, smoothed, w, r); }).find("sigma"), std::string::npos);
}

TEST(ConeWarmStart, RolloutSteps_EqualColdSolutions) {
  for (const auto family : {bench::ConeFamily::Hand22, bench::ConeFamily::Boxes69}) {
    for (const Mode mode : {Mode::Exact, Mode::Smoothed}) {
      int warm = 0;
      for (std::uint64_t seed = 1; seed <= 8; ++seed) {
        bench::ConeInstance instance(family, seed);
        Workspace work(instance.problem().layout_ptr());
        Options options;
        options.mode = mode;
        Options cold_options = options;
        cold_options.warm_start = false;
        for (int step = 0; step < 8; ++step) {
          Result r, cold;
          Workspace fresh(instance.problem().layout_ptr());
          ASSERT_EQ(solve(instance.problem(), options, work, r), Status::Solved);
          ASSERT_EQ(solve(instance.problem(), cold_options, fresh, cold), Status::Solved);
          EXPECT_FALSE(cold.warm_started);
          // Both are the same point of the central path.
          EXPECT_LE((r.x - cold.x).lpNorm<Eigen::Infinity>(), 1e-7) << "seed " << seed << " step " << step;
          warm += r.warm_started;
          instance.follow(cold);
        }
      }
      EXPECT_GT(warm, 5) << "the test would say nothing";
    }
  }
}

TEST(ConeWarmStart, AtTheSolution_NothingIsLeftToDo) {
  for (const auto family : {bench::ConeFamily::Hand22, bench::ConeFamily::Boxes69}) {
    for (std::uint64_t seed = 1; seed <= 8; ++seed) {
      const bench::ConeInstance instance(family, seed);
      Options options;
      options.mode = Mode::Smoothed;
      options.warm_start = false;
      Workspace cold_work(instance.problem().layout_ptr()), work(instance.problem().layout_ptr());
      Result cold, r;
      ASSERT_EQ(solve(instance.problem(), options, cold_work, cold), Status::Solved);
      options.x_near = &cold.x;
      ASSERT_EQ(solve(instance.problem(), options, work, r), Status::Solved);
      EXPECT_TRUE(r.warm_started);
      EXPECT_LE(r.iterations, 1) << "cold: " << cold.iterations;
      EXPECT_LE((r.x - cold.x).lpNorm<Eigen::Infinity>(), 1e-9);
      Eigen::MatrixXd inverse = Eigen::MatrixXd::Identity(r.x.size(), r.x.size()), cold_inverse = inverse;
      apply_inverse(work, inverse);
      apply_inverse(cold_work, cold_inverse);
      EXPECT_LE((inverse - cold_inverse).norm(), 1e-6 * cold_inverse.norm());
      const Eigen::VectorXd outside = Eigen::VectorXd::Constant(r.x.size(), 100);  // in violation of rows: no start
      options.x_near = &outside;
      ASSERT_EQ(solve(instance.problem(), options, work, r), Status::Solved);
      EXPECT_LE((r.x - cold.x).lpNorm<Eigen::Infinity>(), 1e-7);
    }
  }
}

TEST(ConeWarmStart, Forget_StartsCold) {
  bench::ConeInstance instance(bench::ConeFamily::Hand22, 1);
  Workspace work(instance.problem().layout_ptr());
  Result r;
  ASSERT_EQ(solve(instance.problem(), Options{}, work, r), Status::Solved);
  work.forget();
  ASSERT_EQ(solve(instance.problem(), Options{}, work, r), Status::Solved);
  EXPECT_FALSE(r.warm_started);
}

TEST(ConeDeterminism, SameInput_SameBits) {
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    const Problem problem = make_random(seed).make();
    Workspace a(problem.layout_ptr()), b(problem.layout_ptr());
    Options options;
    options.warm_start = false;
    Result ra, rb;
    const Status sa = solve(problem, options, a, ra);
    (void)solve(problem, options, b, rb);
    const Status sb = solve(problem, options, b, rb);  // b has solved before: no hidden state
    EXPECT_EQ(sa, sb);
    EXPECT_TRUE((ra.x.array() == rb.x.array()).all());
    EXPECT_EQ(ra.iterations, rb.iterations);
  }
}

TEST(ConeMemory, AfterTheFirstCall_NoHeapUse) {
  if (!bench::counts_allocations()) GTEST_SKIP() << "mallocs are not counted under sanitizers";
  ASSERT_GT(bench::allocations(), 0) << "the counter does not count";
  for (const auto family : {bench::ConeFamily::Hand22, bench::ConeFamily::Boxes69}) {
    for (const Mode mode : {Mode::Exact, Mode::Smoothed}) {
      const bench::ConeInstance instance(family, 7);
      Workspace work(instance.problem().layout_ptr());
      Options options;
      options.mode = mode;
      Result r;
      ASSERT_EQ(solve(instance.problem(), options, work, r), Status::Solved);
      Eigen::MatrixXd X = Eigen::MatrixXd::Identity(r.x.size(), 19);
      const long before = bench::allocations();
      (void)solve(instance.problem(), options, work, r);
      options.warm_start = false;
      (void)solve(instance.problem(), options, work, r);
      apply_inverse(work, X);
      EXPECT_EQ(bench::allocations() - before, 0);
    }
  }
}

TEST(ConeMemory, FewerRowsThanBefore_NoHeapUse) {
  if (!bench::counts_allocations()) GTEST_SKIP() << "mallocs are not counted under sanitizers";
  ASSERT_GT(bench::allocations(), 0) << "the counter does not count";
  RawProblem raw = make_random(11);
  ASSERT_GE(raw.cones.size() + raw.lines.size(), 3u);
  Problem problem = raw.make();
  Workspace work(problem.layout_ptr());
  Result r;
  (void)solve(problem, Options{}, work, r);
  if (!raw.cones.empty())
    raw.cones.pop_back();
  else
    raw.lines.pop_back();
  raw.fill(problem);
  const long before = bench::allocations();
  (void)solve(problem, Options{}, work, r);
  EXPECT_EQ(bench::allocations() - before, 0);
  EXPECT_EQ(problem.growths(), 0);
}

/// H from the raw matrices and the returned D.
Eigen::MatrixXd raw_hessian(const RawProblem& raw, const Workspace& work) {
  const Eigen::MatrixXd G = raw.stacked_G();
  Eigen::MatrixXd H = raw.Q;
  Eigen::Index at = 0;
  for (std::size_t i = 0; i < raw.cones.size(); ++i, at += 3) {
    H += G.middleRows(at, 3).transpose() * D_cone(work, static_cast<int>(i)).matrix() * G.middleRows(at, 3);
  }
  for (std::size_t i = 0; i < raw.lines.size(); ++i, ++at) H += D_half_line(work, static_cast<int>(i)) * G.row(at).transpose() * G.row(at);
  for (std::size_t i = 0; i < raw.bounds.size(); ++i, ++at) H += D_bound(work, static_cast<int>(i)) * G.row(at).transpose() * G.row(at);
  return H;
}

TEST(ConeSensitivity, ApplyInverse_InvertsHOfTheRawMatrices) {
  RandomOptions random;
  random.deep = 0;
  random.mass_decades = 1;
  random.duplicate = 0;
  int checked = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    const RawProblem raw = make_random(seed, random);
    const Problem problem = raw.make();
    Workspace work(problem.layout_ptr());
    Options options;
    options.mode = Mode::Smoothed;
    Result r;
    if (solve(problem, options, work, r) != Status::Solved) continue;
    const Eigen::MatrixXd H = raw_hessian(raw, work);
    Eigen::MatrixXd X = Eigen::MatrixXd::Random(raw.n, 7);
    const Eigen::MatrixXd rhs = X;
    apply_inverse(work, X);
    EXPECT_LE((H * X - rhs).norm(), 1e-10 * H.norm() * X.norm());
    std::vector<int> variables;
    std::vector<double> scale;
    for (int i = raw.n - 1; i >= 0; i -= 2) variables.push_back(i), scale.push_back(-0.5 - i);
    Eigen::MatrixXd columns(raw.n, variables.size()), expected = Eigen::MatrixXd::Zero(raw.n, columns.cols());
    calc_inverse_columns(work, variables, scale, columns);
    for (std::size_t k = 0; k < variables.size(); ++k) expected(variables[k], static_cast<Eigen::Index>(k)) = scale[k];
    apply_inverse(work, expected);
    EXPECT_LE((columns - expected).norm(), 1e-13 * expected.norm());
    ++checked;
  }
  EXPECT_GT(checked, 20);
}

/// Largest relative error of dx/db·v = −H⁻¹v against central differences over problems away from kinks.
int check_sensitivity(Mode mode, double tolerance, double step, double saturating = 0) {
  int checked = 0;
  for (std::uint64_t seed = 1; seed <= 120; ++seed) {
    const RawProblem raw = [&] {
      RandomOptions random;
      random.deep = 0;
      random.mass_decades = 1;
      random.duplicate = 0;
      random.max_contacts = 12;
      random.saturating = saturating;
      return make_random(seed, random);
    }();
    const Problem problem = raw.make();
    Workspace work(problem.layout_ptr());
    Options options;
    options.mode = mode;
    options.warm_start = false;
    Result r;
    if (solve(problem, options, work, r) != Status::Solved) continue;
    if (mode == Mode::Exact) {
      // Strict complementarity: away from a kink every row is clearly on one side, and cones that slide do so clearly.
      bool kink = false;
      for (Eigen::Index i = 0; i < r.w_cone.cols(); ++i) {
        const double w0 = r.w_cone(0, i), z0 = r.z_cone(0, i);
        const double ws = w0 - r.w_cone.col(i).tail<2>().norm(), zs = z0 - r.z_cone.col(i).tail<2>().norm();
        kink = kink || !((ws > 1e-3 && z0 < 1e-6) || (zs > 1e-3 && w0 < 1e-6) || (w0 > 1e-3 && z0 > 1e-3));
      }
      const auto line = [&](double w, double z) { kink = kink || !((w > 1e-3 && z < 1e-6) || (z > 1e-3 && w < 1e-6)); };
      for (Eigen::Index i = 0; i < r.w_half_line.size(); ++i) line(r.w_half_line[i], r.z_half_line[i]);
      for (Eigen::Index i = 0; i < r.w_bound.size(); ++i) line(r.w_bound[i], r.z_bound[i]);
      if (kink) continue;
    }
    core::Random random(seed, 5);
    Eigen::MatrixXd v(raw.n, 1);
    for (int i = 0; i < raw.n; ++i) v(i) = raw.Q(i, i) * random.normal() * 0.01;  // moves every variable by about 1 %
    Eigen::MatrixXd D = -v;
    apply_inverse(work, D);
    RawProblem plus = raw, minus = raw;
    plus.b += step * v.col(0);
    minus.b -= step * v.col(0);
    Result rp, rm;
    const Problem pp = plus.make(), pm = minus.make();
    Workspace wp(pp.layout_ptr()), wm(pm.layout_ptr());
    EXPECT_EQ(solve(pp, options, wp, rp), Status::Solved);
    EXPECT_EQ(solve(pm, options, wm, rm), Status::Solved);
    const Eigen::VectorXd difference = (rp.x - rm.x) / (2 * step);
    EXPECT_GT(difference.norm(), 1e-6);
    EXPECT_LE((D.col(0) - difference).norm(), tolerance * difference.norm()) << "seed " << seed;
    ++checked;
  }
  return checked;
}

TEST(ConeSensitivity, Smoothed_MatchesCentralDifferencesTo1em6) { EXPECT_GT(check_sensitivity(Mode::Smoothed, 1e-6, 1e-4), 60); }
TEST(ConeSensitivity, SpringsThatSaturate_MatchCentralDifferences) {
  EXPECT_GT(check_sensitivity(Mode::Smoothed, 1e-6, 1e-4, 0.5), 60);
  EXPECT_GT(check_sensitivity(Mode::Exact, 1e-5, 2e-4, 0.5), 10);
}
TEST(ConeSensitivity, Exact_MatchesCentralDifferencesTo1em5) { EXPECT_GT(check_sensitivity(Mode::Exact, 1e-5, 2e-4), 20); }

TEST(ConeProblem, GrowsBeyondItsCapacity_AndCounts) {
  auto layout = std::make_shared<Layout>(6, std::vector<std::vector<int>>{{0, 1, 2}, {3, 4, 5}});
  const std::array<int, 6> all{0, 1, 2, 3, 4, 5};
  const int support = layout->add_support(all);
  Problem p(layout, 1, 0);
  const std::vector<double> G(18, 0.5);
  const double g[3] = {1, 0, 0};
  for (int i = 0; i < 20; ++i) EXPECT_EQ(p.add_cone(static_cast<std::uint64_t>(i), support, G.data(), g, 1), i);
  for (int i = 0; i < 5; ++i) EXPECT_EQ(p.add_half_line(static_cast<std::uint64_t>(i), support, G.data(), 1, 1), i);
  for (int i = 0; i < 30; ++i) EXPECT_EQ(p.add_bound(static_cast<std::uint64_t>(i), i % 6, 1, 1, 1), i);
  EXPECT_EQ(p.n_cones(), 20);
  EXPECT_EQ(p.n_half_lines(), 5);
  EXPECT_EQ(p.n_bounds(), 30);
  EXPECT_GT(p.growths(), 0);
  p.clear();
  EXPECT_EQ(p.n_cones() + p.n_half_lines() + p.n_bounds(), 0);
}

}  // namespace
}  // namespace stiction::cone::test
