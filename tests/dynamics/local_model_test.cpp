#include "stiction/dynamics/local_model.hpp"

#include <limits>
#include <numbers>

#include "dynamics/systems.hpp"
#include "support/message_of.hpp"

namespace stiction::dynamics::test {
namespace {

using core::Status;
using Eigen::VectorXd;
using world::Model;

VectorXd one(double x) { return VectorXd::Constant(1, x); }

/// The pusher (K = 100 N/m) before a frictionless wall at z = 0: q_next = max(u, 0).
struct Wall {
  Wall() {
    world::Scene scene = empty_scene();
    scene.robots.push_back(pusher(0));
    scene.fixed.push_back(half_space(Eigen::Vector3d::UnitZ(), {0, 0, -0.1}, 0));
    model = Model::make(scene);
  }
  LocalModel operator()(double u, const LocalModelScheme& scheme, int threads = 1, bool with_A = false) const {
    LocalModelWorkspace work(model, threads);
    LocalModel out;
    EXPECT_EQ(calc_local_model(*model, {Eigen::Vector2d(0, 0.001), Eigen::Vector2d(0, u)}, scheme, {}, with_A, work, out), Status::Solved);
    return out;
  }
  std::shared_ptr<const Model> model;
};

Sampling disturbed(double std_u, int samples, std::uint64_t seed = 0) { return {.std_u = one(std_u), .samples = samples, .seed = seed}; }

/// E[max(u + w, 0)] = u Φ(u/s) + s φ(u/s) and its derivative Φ(u/s), w ~ N(0, s²).
TEST(LocalModel, SpringAgainstWall_RandomizedMatchesTheGaussianConvolution) {
  const Wall wall;
  const double s = 0.02;
  const int n = 20000;
  for (const double u : {-0.03, -0.01, 0.0, 0.01, 0.03}) {
    const double z = u / s, cdf = 0.5 * std::erfc(-z / std::numbers::sqrt2);
    const double pdf = std::exp(-0.5 * z * z) / std::sqrt(2 * std::numbers::pi);
    const double mean = u * cdf + s * pdf;
    const LocalModel first = wall(u, RandomizedFirstOrder{disturbed(s, n)});
    EXPECT_NEAR(first.c[1], mean, 4 * s / std::sqrt(n)) << u;                         // the variance of max(·, 0) is below s²
    EXPECT_NEAR(first.B(1, 1), cdf, 4 * std::sqrt(cdf * (1 - cdf) / n) + 1e-4) << u;  // a Bernoulli mean
    const LocalModel zeroth = wall(u, RandomizedZerothOrder{disturbed(s, n)});
    EXPECT_NEAR(zeroth.c[1], mean, 4 * s / std::sqrt(n)) << u;
    EXPECT_NEAR(zeroth.B(1, 1), cdf, 6 / std::sqrt(n)) << u;  // residuals and disturbances are of size s
  }
}

/// Analytic smoothing of the same system: q_next = (u + √(u² + 4/(κk)))/2 with the wall's half-line of μ = 0, σ = 2h/κ → 8/(κk).
TEST(LocalModel, AnalyticAndExact_AreTheStep) {
  const Wall wall;
  const double kappa = 1000, k = 100, u = -0.005;
  const LocalModel smooth = wall(u, Analytic{.kappa = kappa, .self_sharpness = 1});
  const double root = std::sqrt(u * u + 8 / (kappa * k));
  EXPECT_NEAR(smooth.c[1], 0.5 * (u + root), 1e-9);
  EXPECT_NEAR(smooth.B(1, 1), 0.5 * (1 + u / root), 1e-7);
  const LocalModel exact = wall(0.02, Exact{});
  EXPECT_NEAR(exact.c[1], 0.02, 1e-8);
  EXPECT_NEAR(exact.B(1, 1), 1, 1e-5);
}

TEST(LocalModel, AnyNumberOfThreads_SameBits) {
  const auto model = load_task("allegro_ball");
  VectorXd q = model->neutral(), u(16);
  q.head<3>() << -0.081, 0.001, 0.071;
  q.tail(16) << 0.035, 0.753, 0.741, 0.833, -0.144, 0.747, 0.619, 0.701, -0.069, 0.785, 0.829, 0.904, 0.633, 1.024, 0.641, 0.824;
  u = q.tail(16).array() + 0.02;
  for (const bool first_order : {true, false}) {
    Sampling sampling = disturbed(0.1, 60, 7);
    sampling.std_q = one(0.003);
    const LocalModelScheme scheme =
        first_order ? LocalModelScheme(RandomizedFirstOrder{sampling}) : LocalModelScheme(RandomizedZerothOrder{sampling});
    LocalModel one_thread, three_threads, again;
    LocalModelWorkspace work1(model, 1), work3(model, 3);
    ASSERT_EQ(calc_local_model(*model, {q, u}, scheme, {}, true, work1, one_thread), Status::Solved);
    ASSERT_EQ(calc_local_model(*model, {q, u}, scheme, {}, true, work3, three_threads), Status::Solved);
    ASSERT_EQ(calc_local_model(*model, {q, u}, scheme, {}, true, work3, again), Status::Solved);
    for (const LocalModel* other : {&three_threads, &again}) {
      EXPECT_EQ(one_thread.c, other->c);
      EXPECT_EQ(one_thread.A, other->A);
      EXPECT_EQ(one_thread.B, other->B);
    }
    EXPECT_GT(one_thread.B.topRows(6).cwiseAbs().maxCoeff(), 1e-3) << "the hand never moved the ball";
  }
}

/// A ball that nothing touches goes where it is put: A = 1 up to the square of the disturbance of its orientation.
TEST(LocalModel, FreeBallTurned_DerivativeIsCarriedThroughTheDisturbance) {
  world::Scene scene = empty_scene();
  scene.objects.push_back(ball(world::ObjectJoint::Free, 1, 0.1, 0.5));
  const auto model = Model::make(scene);
  VectorXd q = model->neutral();
  q.segment<4>(3) = Eigen::Quaterniond(Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, -1).normalized())).coeffs();
  LocalModelWorkspace work(model);
  const double s = 0.2;
  const int n = 4000;
  Sampling sampling{.std_q = one(s), .std_u = one(0), .samples = n, .seed = 1};
  LocalModel out;
  for (const bool first_order : {true, false}) {
    const LocalModelScheme scheme =
        first_order ? LocalModelScheme(RandomizedFirstOrder{sampling}) : LocalModelScheme(RandomizedZerothOrder{sampling});
    ASSERT_EQ(calc_local_model(*model, {q, VectorXd(0)}, scheme, {}, true, work, out), Status::Solved);
    // J_r(w)⁻¹ exp(w)ᵀ = 1 − ½[w]× + O(w²): the odd part has mean 0 and variance s²/4, the even part is below s²/2
    EXPECT_LT((out.A - Eigen::MatrixXd::Identity(6, 6)).cwiseAbs().maxCoeff(), 0.5 * s * s + 2 * s / std::sqrt(n));
    VectorXd e(6);
    world::local(*model, q, out.c, e);
    EXPECT_LT(e.norm(), 4 * std::sqrt(6.0) * s / std::sqrt(n));
  }
}

/// w_u of sample 0 where q is not disturbed: its numbers follow those of w_q.
VectorXd first_disturbance(const Model& model, const VectorXd& std_u, std::uint64_t seed) {
  core::Random random(seed, 0);
  for (int i = 0; i < model.n_v(); ++i) random.normal();
  return std_u.unaryExpr([&](double s) { return s * random.normal(); });
}

/// A sample looks first at the rows that the nominal step and its B expect it to come near. It ends where the step ends that looks at all
/// within reach, however wrong that was: disturbances of 0.4 rad are far from small. Both are centred at a complementarity of 1e-8 J·s,
/// which leaves 1e-6 m where impulses are 0.01 N·s.
TEST(LocalModel, OneSample_IsTheStepThere) {
  for (const char* task : {"allegro_ball", "planar_hand"}) {
    const auto model = load_task(task);
    core::Random states(5, 0);
    LocalModelWorkspace work(model);
    StepWorkspace step_work(model);
    StepResult expected;
    LocalModel out;
    int pushed = 0, narrow = 0;
    for (std::uint64_t seed = 0; seed < 60; ++seed) {
      const VectorXd q = sample_task(task, *model, states), u = q.tail(model->n_a());
      const double s = seed % 2 == 0 ? 0.1 : 0.4;
      const VectorXd w = first_disturbance(*model, VectorXd::Constant(model->n_a(), s), seed);
      ASSERT_EQ(step(*model, {q, u + w}, {.with_B = true, .warm_start = false}, step_work, expected), Status::Solved);
      ASSERT_EQ(calc_local_model(*model, {q, u}, RandomizedFirstOrder{disturbed(s, 1, seed)}, {}, false, work, out), Status::Solved);
      VectorXd off(model->n_v());
      world::local(*model, expected.q_next, out.c, off);
      // Both end with λ_n w ≤ 1e-8 J·s at every contact, with other rows in the program: as far apart as that leaves the weakest one.
      double weakest = 0.01, narrowest = 3e-4;
      for (const auto& c : expected.contacts) {
        if (c.active)
          weakest = std::min(weakest, c.lambda[0]);
        else
          narrowest = std::min(narrowest, c.gap);
      }
      EXPECT_LT(off.norm(), 1e-8 / weakest) << task << ' ' << seed;
      // A row that is open by w and only in one of the programs, centred at t, adds 2t/w² to its Hessian.
      EXPECT_LT((out.B - expected.B).norm(), 1e-4 * std::pow(3e-4 / narrowest, 2)) << task << ' ' << seed;
      pushed += expected.B.topRows(model->n_vu()).norm() > 1e-2;
      narrow += narrowest < 3e-4;
    }
    EXPECT_GT(pushed, 30);
    EXPECT_LT(narrow, 12);
  }
}

/// Twenty balls in a row, 2 mm apart. The nominal step leaves all of them alone, so that a sample that pushes finds them one after the other.
/// Rows with B end centred at t = 5e-10 S with S ≤ 16 N·s: a row in the program that is 2 mm open pushes with 2t/φ < 1e-5 N·s, which moves a ball of
/// εm/h = 1 N·s/m by 1e-5 m; one left out does not push.
TEST(LocalModel, OneSampleAlongARow_MeetsEveryBall) {
  world::Scene scene = empty_scene();
  scene.contact_distance = 0.05;
  scene.robots.push_back(pusher(0));
  const int n = 20;
  for (int i = 0; i < n; ++i) {
    world::ObjectSpec& object = scene.objects.emplace_back(ball(world::ObjectJoint::Slider, 1, 0.1, 0));
    object.name += std::to_string(i);
    object.axis = Eigen::Vector3d::UnitY();
    object.X_WP.p.y() = 0.202 * (i + 1);
  }
  const auto model = Model::make(scene);
  const VectorXd q = model->neutral(), u = q.tail(2);
  LocalModelWorkspace work(model);
  StepWorkspace step_work(model);
  StepResult expected;
  LocalModel out;
  double farthest = 0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Sampling sampling{.std_u = Eigen::Vector2d(1, 1e-3), .samples = 1, .seed = seed};
    const VectorXd w = first_disturbance(*model, sampling.std_u, seed);
    ASSERT_EQ(step(*model, {q, u + w}, {.with_B = true, .warm_start = false}, step_work, expected), Status::Solved);
    ASSERT_EQ(calc_local_model(*model, {q, u}, RandomizedFirstOrder{sampling}, {}, false, work, out), Status::Solved);
    EXPECT_LT((out.c - expected.q_next).cwiseAbs().maxCoeff(), 2e-5) << seed;
    farthest = std::max(farthest, expected.q_next[n - 1]);
  }
  EXPECT_GT(farthest, 0.01);
}

TEST(LocalModel, FirstAndZerothOrder_AgreeOnTheHand) {
  const auto model = load_task("planar_hand");
  VectorXd q(7), u(4);
  q << 0, 0.35, 0.4, -0.85, -0.85, 0.85, 0.85;
  u << -0.8, -0.8, 0.8, 0.8;
  LocalModelWorkspace work(model, 2);
  LocalModel first, zeroth;
  const Sampling sampling = disturbed(0.1, 4000, 3);
  ASSERT_EQ(calc_local_model(*model, {q, u}, RandomizedFirstOrder{sampling}, {}, false, work, first), Status::Solved);
  ASSERT_EQ(calc_local_model(*model, {q, u}, RandomizedZerothOrder{sampling}, {}, false, work, zeroth), Status::Solved);
  EXPECT_LT((first.c - zeroth.c).norm(), 1e-4);  // steps with B are centred at a complementarity of 1e-8
  EXPECT_GT(first.B.topRows(3).cwiseAbs().maxCoeff(), 0.02);
  EXPECT_LT((first.B - zeroth.B).norm(), 0.15 * first.B.norm());
}

TEST(LocalModel, BadSampling_IsNamed) {
  const Wall wall;
  LocalModelWorkspace work(wall.model);
  LocalModel out;
  const auto message = [&](const LocalModelScheme& scheme, bool with_A = false) {
    return stiction::test::message_of([&] {
      (void)calc_local_model(*wall.model, {Eigen::Vector2d(0, 0), Eigen::Vector2d(0, 0)}, scheme, {}, with_A, work, out);
    });
  };
  EXPECT_NE(message(RandomizedFirstOrder{disturbed(0.1, 0)}).find("samples: got 0"), std::string::npos);
  EXPECT_NE(message(RandomizedFirstOrder{disturbed(-0.1, 10)}).find("std_u"), std::string::npos);
  EXPECT_NE(message(RandomizedFirstOrder{disturbed(0, 10)}).find("std_u"), std::string::npos);
  EXPECT_NE(message(RandomizedZerothOrder{disturbed(0.1, 1)}).find("samples"), std::string::npos);
  EXPECT_NE(message(RandomizedZerothOrder{disturbed(0.1, 10)}, true).find("std_q"), std::string::npos);
  Sampling wrong = disturbed(0.1, 10);
  wrong.std_u = VectorXd::Constant(3, 0.1);
  EXPECT_NE(message(RandomizedFirstOrder{wrong}).find("std_u"), std::string::npos);
  EXPECT_NE(message(Analytic{.kappa = -1}).find("smoothing.kappa"), std::string::npos);
}

/// A state that no step accepts shows that sampling is judged before any step is computed.
TEST(LocalModel, TooFewSamplesForLeastSquares_AreRefusedBeforeAnyStep) {
  const Wall wall;
  LocalModelWorkspace work(wall.model);
  LocalModel out;
  const Eigen::Vector2d nowhere = Eigen::Vector2d::Constant(std::numeric_limits<double>::quiet_NaN());
  const auto message = [&](const Sampling& sampling, bool with_A) {
    return stiction::test::message_of([&] {
      (void)calc_local_model(*wall.model, {nowhere, nowhere}, RandomizedZerothOrder{sampling}, {}, with_A, work, out);
    });
  };
  EXPECT_EQ(message(disturbed(0.1, 1), false), "samples: got 1, expected at least 2, one per unknown");
  EXPECT_EQ(message({.std_q = one(0.1), .std_u = one(0.1), .samples = 3}, true), "samples: got 3, expected at least 4, one per unknown");
  EXPECT_EQ(message(disturbed(0.1, 2), false).find("samples"), std::string::npos) << "enough: the step is reached, and refuses q";
}

}  // namespace
}  // namespace stiction::dynamics::test
