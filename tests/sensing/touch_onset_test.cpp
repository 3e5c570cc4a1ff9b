#include "stiction/sensing/touch_onset.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "sensing/random_contact.hpp"
#include "support/message_of.hpp"

namespace stiction::sensing::test {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using stiction::test::message_of;

constexpr int kArmJoints = 7;
constexpr double kStep = 0.005;

MatrixXd noise_of_an_arm() {
  VectorXd deviation(kArmJoints);
  deviation << 0.06, 0.05, 0.04, 0.06, 0.007, 0.007, 0.002;
  return deviation.array().square().matrix().asDiagonal();
}

TEST(OnsetBound, OneNumber_IsThatOfADirectCount) {
  // n = 1: |s| ← (|s + z| − κ)₊, counted.
  core::Random random(1, 0);
  const double rate = 0.01, h = calc_onset_bound(1, 0.5, rate);
  double rows = 0;
  constexpr int kRuns = 4000;
  for (int i = 0; i < kRuns; ++i)
    for (double s = 0; std::abs(s) <= h; ++rows) {
      const double next = s + random.normal(), left = std::abs(next) - 0.5;
      s = left > 0 ? std::copysign(left, next) : 0;
    }
  EXPECT_NEAR(rows / kRuns, 1 / rate, 0.06 / rate);
}

TEST(TouchOnset, FalseAlarms_AreAsManyAsStated) {
  core::Random random(2, 0);
  const double rate = 1e-3;
  const VectorXd drift = VectorXd::Constant(kArmJoints, 0.02);
  TouchOnset onset(VectorXd::Zero(kArmJoints), {.noise = noise_of_an_arm(), .drift = drift, .false_alarms = rate, .quiet = 1});
  const VectorXd deviation = noise_of_an_arm().diagonal().cwiseSqrt();
  VectorXd offset = VectorXd::Zero(kArmJoints);
  int alarms = 0;
  bool before = false;
  constexpr int kRows = 150000;
  for (int i = 0; i < kRows; ++i) {
    offset += std::sqrt(kStep) * drift.cwiseProduct(random_matrix(random, kArmJoints, 1).col(0));
    const bool now = onset.update(offset + deviation.cwiseProduct(random_matrix(random, kArmJoints, 1).col(0)), kStep);
    alarms += now && !before;
    before = now;
  }
  EXPECT_NEAR(alarms, rate * kRows, 5 * std::sqrt(rate * kRows));
  EXPECT_LT((onset.rest() - offset).cwiseAbs().maxCoeff(), 0.2) << "the offset is followed";
}

TEST(TouchOnset, Touch_IsFoundAtOnceAndItsMeanGrowsSharper) {
  core::Random random(3, 0);
  const VectorXd deviation = noise_of_an_arm().diagonal().cwiseSqrt(), rest = VectorXd::Constant(kArmJoints, 0.3);
  VectorXd touch = VectorXd::Zero(kArmJoints);
  touch[1] = 0.3;
  TouchOnset onset(rest, {.noise = noise_of_an_arm(), .drift = VectorXd::Constant(kArmJoints, 0.001)});
  const auto row = [&](bool touched) {
    return VectorXd(rest + (touched ? touch : VectorXd::Zero(kArmJoints)) +
                    deviation.cwiseProduct(random_matrix(random, kArmJoints, 1).col(0)));
  };
  for (int i = 0; i < 400; ++i) ASSERT_FALSE(onset.update(row(false), kStep)) << i;
  int found = 0;
  while (!onset.update(row(true), kStep)) ++found;
  EXPECT_LT(found, 5);
  for (int i = 0; i < 100; ++i) EXPECT_TRUE(onset.update(row(true), kStep));
  EXPECT_NEAR(onset.rows(), 101 + found, 3) << "the rows before it was found count";
  const VectorXd error = onset.mean() - onset.rest() - touch;
  EXPECT_LT(error.dot(onset.noise().ldlt().solve(error)), 7 + 4 * std::sqrt(14.0));
  EXPECT_LT(std::sqrt(onset.noise()(1, 1)), 0.3 * 0.05);
  int rows = 0;
  while (onset.update(row(false), kStep)) ++rows;
  EXPECT_LT(rows, 20);
  EXPECT_LT((onset.rest() - rest).cwiseAbs().maxCoeff(), 0.05) << "the touch is no part of the offset";
}

/// Share of rows after a touch in which something is said to touch, where the touch leaves 3 % of its torques, which fade within a second.
double count_after_touches(double hysteresis, std::uint64_t seed) {
  core::Random random(seed, 0);
  const VectorXd deviation = noise_of_an_arm().diagonal().cwiseSqrt();
  constexpr double kShare = 0.03;
  int touched = 0, all = 0;
  TouchOnset onset(VectorXd::Zero(kArmJoints), {.noise = noise_of_an_arm(), .hysteresis = hysteresis, .rest_rows = 20});
  for (int touch = 0; touch < 20; ++touch) {
    const VectorXd size = 2 * random_matrix(random, kArmJoints, 1),
                   left = kShare * size.cwiseProduct(random_matrix(random, kArmJoints, 1).col(0));
    const auto row = [&](double load, double remains) {
      return onset.update(load * size + remains * left + deviation.cwiseProduct(random_matrix(random, kArmJoints, 1).col(0)), kStep);
    };
    for (int i = 0; i < 60; ++i) row(1, 0);
    EXPECT_TRUE(onset.touches());
    for (int i = 0; i < 400; ++i) {
      const bool touches = row(0, std::exp(-i * kStep / 0.5));
      if (i < 10) continue;  // a touch ends after a few quiet rows
      touched += touches;
      ++all;
    }
  }
  return static_cast<double>(touched) / all;
}

TEST(TouchOnset, WhatATouchLeaves_IsNoTouch) {
  EXPECT_GT(count_after_touches(0, 5), 0.05) << "else the test says nothing";
  EXPECT_LT(count_after_touches(0.03, 5), 0.005);
}

TEST(TouchOnset, OptionsThatCannotBeMeant_AreRefused) {
  const auto refusal = [](OnsetOptions options) { return message_of([&] { TouchOnset onset(VectorXd::Zero(2), std::move(options)); }); };
  EXPECT_NE(refusal({.noise = MatrixXd::Zero(2, 2)}).find("noise"), std::string::npos);
  EXPECT_NE(refusal({.noise = MatrixXd::Identity(2, 2), .false_alarms = 0}).find("false_alarms: got 0"), std::string::npos);
  EXPECT_NE(refusal({.noise = MatrixXd::Identity(2, 2), .drift = VectorXd::Ones(3)}).find("drift"), std::string::npos);
  EXPECT_NE(refusal({.noise = MatrixXd::Identity(2, 2), .hysteresis = -1}).find("hysteresis"), std::string::npos);
  EXPECT_NE(refusal({.noise = MatrixXd::Identity(2, 2), .settle = 0}).find("settle"), std::string::npos);
  EXPECT_EQ(refusal({.noise = MatrixXd::Identity(2, 2), .false_alarms = 0.01}), "no exception");
}

}  // namespace
}  // namespace stiction::sensing::test
