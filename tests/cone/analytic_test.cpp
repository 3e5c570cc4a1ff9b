// Closed forms, before anything random.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>

#include "cone/random_problem.hpp"
#include "support/message_of.hpp"

namespace stiction::cone::test {
namespace {

using core::Status;

Result solved(const RawProblem& raw, const Options& options) {
  const Problem problem = raw.make();
  Workspace work(problem.layout_ptr());
  Result result;
  EXPECT_EQ(solve(problem, options, work, result), Status::Solved);
  return result;
}

Result solved(const RawProblem& raw, Mode mode) {
  Options options;
  options.mode = mode;
  return solved(raw, options);
}

RawProblem empty_problem(int n) {
  RawProblem raw;
  raw.n = n;
  raw.groups = {{}};
  for (int i = 0; i < n; ++i) raw.groups[0].push_back(i);
  raw.Q = Eigen::MatrixXd::Identity(n, n);
  raw.b = Eigen::VectorXd::Zero(n);
  return raw;
}

TEST(Cone, NoRows_GivesUnconstrainedMinimiserInOneIteration) {
  RawProblem raw = empty_problem(7);
  Eigen::MatrixXd A = Eigen::MatrixXd::Random(7, 7);
  raw.Q = A * A.transpose() + Eigen::MatrixXd::Identity(7, 7);
  raw.b = Eigen::VectorXd::LinSpaced(7, -1, 2);
  for (const Mode mode : {Mode::Exact, Mode::Smoothed}) {
    const Result r = solved(raw, mode);
    EXPECT_LE((r.x + raw.Q.llt().solve(raw.b)).norm(), 1e-13 * r.x.norm());
    EXPECT_EQ(r.iterations, 1);
  }
}

/// A block of weight 1 that is pushed by F over ground with μ = 1/2, in units of its mass: the shift of eq. (18) lets it slide without rising.
TEST(Cone, ShiftByTangent_PushedBlockSlidesClosed) {
  constexpr double mu = 0.5;
  for (const double force : {0.2, 0.6, 3.0}) {
    RawProblem raw = empty_problem(3);
    raw.b << 1, -0.6 * force, -0.8 * force;
    RawProblem::Row row{.id = 1, .variables = {0, 1, 2}, .G = Eigen::Vector3d(1, mu, mu).asDiagonal(), .g = Eigen::Vector3d::Zero()};
    raw.cones.push_back(row);
    Options options;
    options.shift_by_tangent = true;
    options.sensitivities = false;
    const Result r = solved(raw, options);
    const double slip = std::max(0.0, force - mu);
    EXPECT_NEAR(r.x[0], 0, 1e-6 + 1e-2 * slip) << force;
    EXPECT_NEAR(r.x[1], 0.6 * slip, 1e-6 + 1e-2 * slip) << force;
    EXPECT_NEAR(r.shift_cone[0], mu * slip, 1e-6 + 1e-2 * slip) << force;
    EXPECT_NEAR(r.z_cone(0, 0), 1, 1e-2) << force;
    raw.cones[0].g[0] = r.shift_cone[0];  // what was solved is the convex program with that shift
    const Kkt kkt = recompute(raw, r, Mode::Exact);
    EXPECT_LE(kkt.stationarity, options.tol_kkt);
    EXPECT_LE(kkt.consistency, options.tol_kkt);
    EXPECT_LE(kkt.complementarity, options.tol_complementarity);
  }
}

TEST(Cone, ShiftByTangent_SmoothedIsRefused) {
  Options options;
  options.mode = Mode::Smoothed;
  options.shift_by_tangent = true;
  EXPECT_NE(stiction::test::message_of([&] { options.validate(); }).find("shift_by_tangent"), std::string::npos);
}

/// A tower of n bodies of weight 1 on the ground, one on the other: the row under body i carries all that is above it, in every order of
/// elimination.
TEST(Cone, TowerOf600_EveryRowCarriesWhatIsAboveIt) {
  constexpr int n = 600;  // 150 tiles: more than one word of a mask has bits
  for (const bool top_first : {false, true}) {
    RawProblem raw = empty_problem(n);
    raw.groups.clear();
    for (int i = 0; i < n; ++i) raw.groups.push_back({top_first ? n - 1 - i : i});
    raw.b = Eigen::VectorXd::Ones(n);
    for (int i = 0; i < n; ++i) {
      RawProblem::Row row;
      row.id = static_cast<std::uint64_t>(i);
      row.variables = i == 0 ? std::vector<int>{0} : std::vector<int>{i - 1, i};
      row.G.setOnes(1, static_cast<Eigen::Index>(row.variables.size()));
      if (i > 0) row.G(0, 0) = -1;
      row.g.setZero(1);
      raw.lines.push_back(row);
    }
    const Result r = solved(raw, Mode::Exact);
    for (int i = 0; i < n; ++i) EXPECT_NEAR(r.z_half_line[i], n - i, 1e-4 * (n - i)) << i;
  }
}

TEST(Cone, LayoutOfMoreThan256Tiles_IsRefused) {
  std::vector<std::vector<int>> groups;
  for (int i = 0; i < 1025; ++i) groups.push_back({i});
  EXPECT_NE(stiction::test::message_of([&] { Layout(1025, groups); }).find("256 tiles"), std::string::npos);
}

/// A spring k pulled to u, wall at x ≤ gap: row gap − x ≥ 0.
RawProblem spring(double k, double u, double gap, double sigma) {
  RawProblem raw = empty_problem(1);
  raw.Q(0, 0) = k;
  raw.b[0] = -k * u;
  raw.bounds.push_back({1, 0, -1, gap, sigma});
  return raw;
}

TEST(Cone, SpringAgainstWall_ExactIsTheProjection) {
  EXPECT_NEAR(solved(spring(10, 0.05, 0.02, 1), Mode::Exact).x[0], 0.02, 1e-8);
  EXPECT_NEAR(solved(spring(10, 0.01, 0.02, 1), Mode::Exact).x[0], 0.01, 1e-8);
  EXPECT_NEAR(solved(spring(10, 0.05, -0.03, 1), Mode::Exact).x[0], -0.03, 1e-8);
}

TEST(Cone, SpringAgainstWall_SmoothedMatchesClosedForm) {
  // k(x − u) + z = 0, (gap − x) z = σ: with e = gap − u, w = (e + √(e² + 4σ/k))/2. Checks (2.34) as corrected.
  for (const double sigma : {1e-2, 1e-3, 1e-6}) {
    for (const double u : {-0.05, 0.0199, 0.05, 0.4}) {
      const double k = 10, gap = 0.02, e = gap - u, root = std::sqrt(e * e + 4 * sigma / k);
      const double w = e > 0 ? (e + root) / 2 : 2 * sigma / k / (root - e);
      const Result r = solved(spring(k, u, gap, sigma), Mode::Smoothed);
      EXPECT_NEAR(r.w_bound[0], w, 1e-8 * w) << "sigma " << sigma << " u " << u;
      EXPECT_NEAR(r.x[0], gap - w, 1e-9);
      EXPECT_NEAR(r.z_bound[0], sigma / w, 1e-8 * sigma / w);
    }
  }
}

/// Two springs K (to U, bounded pull τ) and k (to 0): K pulls with τ where K(U − x) > τ. w = U − x − τ/K + z/K, z = τ − pull.
TEST(Cone, BoundThatGives_IsASpringThatSaturates) {
  const double k = 10, K = 40, limit = 2;
  const auto pulled = [&](double to, Mode mode) {
    RawProblem raw = empty_problem(1);
    raw.Q(0, 0) = k;
    raw.b[0] = -limit;
    raw.bounds.push_back({.id = 1, .variable = 0, .sign = -1, .offset = to - limit / K, .sigma = 1e-3, .give = 1 / K});
    return solved(raw, mode);
  };
  for (const double to : {-0.3, 0.1, 0.24, 0.26, 1.0, 50.0}) {  // it saturates at U = τ/k + τ/K = 0.25
    const double expected = to < 0.25 ? K * to / (K + k) : limit / k;
    const Result r = pulled(to, Mode::Exact);
    EXPECT_NEAR(r.x[0], expected, 1e-7) << to;
    EXPECT_NEAR(limit - r.z_bound[0], k * expected, 1e-6) << to;
  }
  for (const double to : {-0.3, 0.25, 1.0}) {  // (τ − pull)·(excess over the pull's stretch) = σ
    const Result r = pulled(to, Mode::Smoothed);
    const double pull = k * r.x[0], excess = to - r.x[0] - pull / K;
    EXPECT_NEAR((limit - pull) * excess, 1e-3, 1e-9) << to;
  }
}

TEST(Cone, BoundThatGives_NegativeGiveIsRefused) {
  Problem problem(std::make_shared<Layout>(1, std::vector<std::vector<int>>{{0}}), 0, 0);
  const auto message = stiction::test::message_of([&] { problem.add_bound(1, 0, 1, 0, 0, {}, -1); });
  EXPECT_NE(message.find("give"), std::string::npos) << message;
  EXPECT_NE(message.find("-1"), std::string::npos) << message;
}

TEST(Cone, SmoothedForce_ConvergesToExactAtRateOneOverKappa) {
  double last = 0;
  for (int i = 0; i < 4; ++i) {
    const double sigma = 1e-3 * std::pow(0.1, i);
    const double error = solved(spring(10, 0.05, 0.02, sigma), Mode::Smoothed).w_bound[0];  // exact: 0
    if (i > 1) {
      EXPECT_NEAR(last / error, 10.0, 0.6);
    }
    last = error;
  }
}

/// A block (x along the slope, y across, z normal) pushed by `tangential` and `normal` impulse, friction μ, regularised by q.
RawProblem block(double mu, double tangential, double normal, double q, double gap = 0) {
  RawProblem raw = empty_problem(3);
  raw.Q *= q;
  raw.b << -tangential, 0, normal;
  RawProblem::Row row;
  row.id = 5;
  row.variables = {0, 1, 2};
  row.G = Eigen::Matrix3d::Zero();
  row.G(0, 2) = 1;
  row.G(1, 0) = mu;
  row.G(2, 1) = mu;
  row.g = Eigen::Vector3d(gap, 0, 0);
  row.sigma = 1e-4;
  raw.cones.push_back(row);
  return raw;
}

TEST(Cone, BlockOnIncline_SticksBelowAndSlidesAboveTheFrictionAngle) {
  const double mu = 0.5, weight = 1.0;
  for (const double angle : {0.1, 0.3, 0.46, 0.47, 0.6, 1.0}) {
    const double t = weight * std::sin(angle), n = weight * std::cos(angle);
    const Result r = solved(block(mu, t, n, 2.0), Mode::Exact);
    if (std::tan(angle) < mu) {
      EXPECT_NEAR(r.x[0], 0, 1e-7) << "sticks at " << angle;
      EXPECT_NEAR(r.z_cone(0, 0), n, 1e-7) << "contact force = weight";
      EXPECT_NEAR(-mu * r.z_cone(1, 0), t, 1e-7) << "friction holds the block";
    } else {
      // Slides at the edge of the cone: with x₂ = μx₀ (Anitescu lifts by μ × slide) minimise over x₀ by hand.
      const double slide = (t - mu * n) / (2.0 * (1 + mu * mu));
      EXPECT_NEAR(r.x[0], slide, 1e-7);
      EXPECT_NEAR(r.x[2], mu * slide, 1e-7);
      EXPECT_NEAR(r.z_cone(0, 0) - std::hypot(r.z_cone(1, 0), r.z_cone(2, 0)), 0, 1e-6) << "force on the boundary of the cone";
    }
  }
}

TEST(Cone, FrictionlessContact_HasNoTangentialForce) {
  const Result r = solved(block(0.0, 0.4, 1.0, 2.0), Mode::Exact);
  EXPECT_NEAR(r.x[0], 0.2, 1e-9);
  EXPECT_NEAR(r.x[2], 0.0, 1e-8);
  EXPECT_NEAR(r.z_cone(0, 0), 1.0, 1e-7);
}

TEST(Cone, SmoothedLift_BarrierDegreeTwo) {
  // A resting block, no tangential motion: q x + n − z = 0, (x) z = σ = 2/κ: it floats at the root of q x² + n x − σ.
  const double n = 1.0, q = 2.0, sigma = 1e-4;
  const Result r = solved(block(0.5, 0, n, q), Mode::Smoothed);
  EXPECT_NEAR(r.x[2], (-n + std::sqrt(n * n + 4 * q * sigma)) / (2 * q), 1e-12);
  EXPECT_NEAR(r.w_cone.col(0).dot(r.z_cone.col(0)), sigma, 1e-9 * sigma) << "the erratum: 2/κ, not 1/κ";
}

TEST(Cone, Penetration_IsProjectedOut) {
  const Result r = solved(block(0.5, 0, 0.1, 2.0, -0.03), Mode::Exact);
  EXPECT_NEAR(r.x[2], 0.03, 1e-8);
}

TEST(Cone, PairOfHalfLines_EqualsPlanarCone) {
  const double mu = 0.5, t = 0.9, n = 1.0;
  RawProblem planar = block(mu, t, n, 2.0);
  RawProblem pair = planar;
  pair.cones.clear();
  for (const double side : {1.0, -1.0}) {
    RawProblem::Row row = planar.cones[0];
    row.id = side > 0 ? 1 : 2;
    row.G = planar.cones[0].G.row(0) + side * planar.cones[0].G.row(1);
    row.g = Eigen::VectorXd::Constant(1, 0.0);
    pair.lines.push_back(row);
  }
  EXPECT_LE((solved(planar, Mode::Exact).x - solved(pair, Mode::Exact).x).norm(), 1e-7);
}

}  // namespace
}  // namespace stiction::cone::test
