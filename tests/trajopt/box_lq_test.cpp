#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "stiction/core/invalid_input.hpp"
#include "trajopt/random_lq.hpp"

namespace stiction::trajopt::test {
namespace {

using core::Status;
using Eigen::VectorXd;

/// The optimality conditions of (T.3) from the condensed problem: projected gradient of a box.
double worst_condition(const Condensed& qp, const VectorXd& u) {
  const VectorXd gradient = qp.H * u + qp.h;
  return ((u - gradient).cwiseMax(qp.lower).cwiseMin(qp.upper) - u).cwiseAbs().maxCoeff();
}

TEST(BoxLq, OneInputOneStep_IsTheClampedQuotient) {
  // min ½ q (a x0 + b u)² + ½ r (d + u)²  →  u = −(q b a x0 + r d) / (q b² + r)
  for (const double x0 : {-2.0, 0.1, 3.0}) {
    BoxLqProblem p;
    p.x0 = VectorXd::Constant(1, x0);
    p.R = VectorXd::Constant(1, 0.5);
    p.stages.resize(1);
    LqStage& s = p.stages[0];
    s.A = Eigen::MatrixXd::Constant(1, 1, 0.9), s.B = Eigen::MatrixXd::Constant(1, 1, 0.3), s.Q = Eigen::MatrixXd::Constant(1, 1, 2.0);
    s.q = VectorXd::Zero(1), s.r = VectorXd::Constant(1, 0.2);
    s.lower = VectorXd::Constant(1, -0.4), s.upper = VectorXd::Constant(1, 0.4);
    s.Gx.resize(0, 1), s.Gu.resize(0, 1), s.g.resize(0);
    BoxLqWorkspace work;
    BoxLqResult out;
    ASSERT_EQ(solve_box_lq(p, {.tolerance = 1e-14}, work, out), Status::Solved);
    const double free = -(2.0 * 0.3 * 0.9 * x0 + 0.5 * 0.2) / (2.0 * 0.09 + 0.5);
    EXPECT_NEAR(out.u[0][0], std::clamp(free, -0.4, 0.4), 1e-6) << x0;
  }
}

TEST(BoxLq, RandomProblems_OptimalityConditionsHold) {
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    const BoxLqProblem p = random_problem(seed, 4, 3, 1 + static_cast<int>(seed % 12), 0);
    BoxLqWorkspace work;
    BoxLqResult out;
    ASSERT_EQ(solve_box_lq(p, {.tolerance = 1e-12}, work, out), Status::Solved) << "seed " << seed;
    EXPECT_LE(out.gap, 1e-12);
    // The distance of u falls with the square root of the cost that is left, where the Hessian is weakest.
    EXPECT_LE(worst_condition(Condensed(p), stacked(out.u)), 2e-5) << "seed " << seed;
  }
}

TEST(BoxLq, WideBoxes_GainsAreThoseOfTheLinearRegulator) {
  // Without bounds the gains must carry the solution from one start to that of another.
  BoxLqProblem p = random_problem(3, 4, 2, 6, 0);
  for (auto& s : p.stages) s.lower.setConstant(-100), s.upper.setConstant(100);
  BoxLqWorkspace work;
  BoxLqResult from, to;
  ASSERT_EQ(solve_box_lq(p, {.tolerance = 1e-9}, work, from), Status::Solved);
  const VectorXd shift = VectorXd::LinSpaced(4, -1, 1);
  p.x0 += shift;
  ASSERT_EQ(solve_box_lq(p, {.tolerance = 1e-9}, work, to), Status::Solved);
  VectorXd dx = shift, du = VectorXd::Zero(2);
  for (std::size_t t = 0; t < p.stages.size(); ++t) {
    du = from.gains[t].K_x * dx + from.gains[t].K_u * du;
    dx = p.stages[t].A * dx + p.stages[t].B * du;
    // The barrier of boxes ±100 is felt by 1e-9 / 100² of the cost.
    EXPECT_LE((from.u[t] + du - to.u[t]).norm(), 1e-4) << t;
    EXPECT_GT(du.norm(), 1e-2) << t;
  }
}

/// 1.4^120 = 3e17: simulated from the inputs alone, no digit of a state would be left, nor of a gradient by costates.
TEST(BoxLq, LongUnstableDynamics_KeepTheirDigits) {
  BoxLqProblem p = random_problem(5, 3, 2, 120, 0);
  p.x0.setZero();
  const Eigen::MatrixXd A = (Eigen::Matrix3d() << 1.4, 0.2, 0, 0, 0.9, 0.1, 0.05, 0, 0.5).finished();
  for (auto& s : p.stages) s.A = A, s.Q.setIdentity(), s.lower.setConstant(-0.5), s.upper.setConstant(0.5), s.r *= 0.1, s.q *= 0.1;
  BoxLqWorkspace work;
  BoxLqResult out, rough;
  ASSERT_EQ(solve_box_lq(p, {.tolerance = 1e-10}, work, out), Status::Solved);
  EXPECT_LE(out.iterations, 30);
  int at_bounds = 0;
  for (std::size_t t = 0; t < p.stages.size(); ++t) {
    const auto& s = p.stages[t];
    EXPECT_LE((out.x[t + 1] - s.A * out.x[t] - s.B * out.u[t]).norm(), 1e-12) << t;
    EXPECT_LE(out.x[t + 1].norm(), 10) << t;
    at_bounds += (out.u[t].cwiseAbs().array() > 0.4999).any();
  }
  EXPECT_GT(at_bounds, 0);
  ASSERT_EQ(solve_box_lq(p, {.tolerance = 1e-2}, work, rough), Status::Solved);
  EXPECT_LT(rough.iterations, out.iterations);
  EXPECT_GE(rough.cost, out.cost - 1e-9);
  EXPECT_LE(rough.cost, out.cost + 1e-2) << "what the gap promises";
}

/// Products of A that overflow: no step is better than one that is not a number.
TEST(BoxLq, HopelesslyUnstableDynamics_GiveFiniteInputs) {
  for (const double growth : {30.0, 1e5, 1e60}) {
    BoxLqProblem p = random_problem(5, 3, 2, 200, 0);
    p.x0.setZero();
    for (auto& s : p.stages) s.A = growth * Eigen::Matrix3d::Identity(), s.lower.setConstant(-0.5), s.upper.setConstant(0.5);
    BoxLqWorkspace work;
    BoxLqResult out;
    const Status status = solve_box_lq(p, {.tolerance = 1e-6}, work, out);
    for (const auto& u : out.u) EXPECT_TRUE(u.allFinite()) << growth;
    for (const auto& gain : out.gains) EXPECT_TRUE(gain.K_x.allFinite() && gain.K_u.allFinite()) << growth;
    EXPECT_EQ(status, Status::NumericalFailure) << growth;
  }
}

TEST(BoxLq, InputsAtBounds_HaveNoGain) {
  const BoxLqProblem p = random_problem(4, 4, 3, 8, 0);
  BoxLqWorkspace work;
  BoxLqResult out;
  ASSERT_EQ(solve_box_lq(p, {.tolerance = 1e-10}, work, out), Status::Solved);
  int looked_at = 0;
  for (std::size_t t = 0; t < out.u.size(); ++t) {
    for (Eigen::Index i = 0; i < 3; ++i) {
      const double room = std::min(out.u[t][i] - p.stages[t].lower[i], p.stages[t].upper[i] - out.u[t][i]);
      if (room > 1e-9) continue;
      ++looked_at;
      EXPECT_LE(out.gains[t].K_x.row(i).norm(), 1e-4);
    }
  }
  EXPECT_GT(looked_at, 3);
}

TEST(BoxLq, LowerEqualToUpper_InputStaysThere) {
  BoxLqProblem p = random_problem(7, 3, 2, 5, 0);
  for (auto& s : p.stages) s.lower[1] = s.upper[1] = 0.05;
  BoxLqWorkspace work;
  BoxLqResult out;
  ASSERT_EQ(solve_box_lq(p, {}, work, out), Status::Solved);
  for (const auto& u : out.u) EXPECT_NEAR(u[1], 0.05, 1e-9);
}

TEST(BoxLq, SameWorkspaceForOtherSizes_GivesTheSameBits) {
  BoxLqWorkspace fresh, used;
  BoxLqResult a, b;
  ASSERT_EQ(solve_box_lq(random_problem(1, 6, 4, 9, 2), {}, used, b), Status::Solved);
  const BoxLqProblem p = random_problem(2, 3, 2, 4, 0);
  ASSERT_EQ(solve_box_lq(p, {}, fresh, a), Status::Solved);
  ASSERT_EQ(solve_box_lq(p, {}, used, b), Status::Solved);
  for (std::size_t t = 0; t < a.u.size(); ++t) EXPECT_EQ(a.u[t], b.u[t]);
}

void expect_message(const BoxLqProblem& p, const std::string& text) {
  BoxLqWorkspace work;
  BoxLqResult out;
  try {
    (void)solve_box_lq(p, {}, work, out);
    FAIL() << "accepted, expected: " << text;
  } catch (const core::InvalidInput& e) {
    EXPECT_NE(std::string(e.what()).find(text), std::string::npos) << e.what();
  }
}

TEST(BoxLq, BadInput_IsNamed) {
  const BoxLqProblem good = random_problem(1, 3, 2, 3, 1);
  BoxLqProblem p = good;
  p.stages.clear();
  expect_message(p, "stages: got none");
  p = good;
  p.stages[1].lower[0] = p.stages[1].upper[0] + 0.1;
  expect_message(p, "stages[1].lower[0]");
  p = good;
  p.R[1] = -1;
  expect_message(p, "R: got -1");
  p = good;
  p.stages[2].A(0, 0) = std::numeric_limits<double>::quiet_NaN();
  expect_message(p, "stages[2].A");
  p = good;
  p.stages[0].B.resize(3, 5);
  expect_message(p, "stages[0].B columns");
  p = good;
  p.stages[0].upper.resize(3);
  expect_message(p, "stages[0].upper");
}

}  // namespace
}  // namespace stiction::trajopt::test
