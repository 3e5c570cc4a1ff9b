#include "stiction/sensing/calibrate.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include "sensing/random_contact.hpp"
#include "sensing/robots.hpp"
#include "stiction/sensing/few_rows.hpp"
#include "stiction/sensing/known_contacts.hpp"
#include "support/message_of.hpp"

namespace stiction::sensing::test {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using stiction::test::message_of;

constexpr int kJoints = 7;

/// Noise of very different joints that move together.
MatrixXd true_noise() {
  VectorXd deviation(kJoints);
  deviation << 0.06, 0.05, 0.04, 0.06, 0.007, 0.007, 0.002;
  MatrixXd correlation = MatrixXd::Identity(kJoints, kJoints);
  correlation(0, 2) = correlation(2, 0) = 0.8;
  return deviation.asDiagonal() * correlation * deviation.asDiagonal();
}

/// Rows of several records, each with an offset of its own.
RestRows make_rest_rows(core::Random& random, int records, int rows, double between) {
  RestRows out;
  const MatrixXd L = true_noise().llt().matrixL();
  out.q = MatrixXd::Constant(kJoints, records * rows, 0.3);
  out.tau.resize(kJoints, records * rows);
  for (int r = 0; r < records; ++r) {
    const VectorXd offset = VectorXd::Constant(kJoints, 0.2) + between * random_matrix(random, kJoints, 1);
    for (int i = 0; i < rows; ++i) {
      out.tau.col(r * rows + i) = offset + L * random_matrix(random, kJoints, 1);
      out.records.push_back(r);
      out.times.push_back(0.005 * i);
    }
  }
  return out;
}

TEST(Calibrate, LongRecord_FindsOffsetAndCovariance) {
  core::Random random(1, 0);
  const auto model = make_arm(kIiwa);
  const Calibration c = calibrate(*model, make_rest_rows(random, 1, 4000, 0));
  const VectorXd deviation = true_noise().diagonal().cwiseSqrt();
  for (int j = 0; j < kJoints; ++j) {
    EXPECT_NEAR(c.rest[j], 0.2, 5 * deviation[j] / std::sqrt(4000.0));
    EXPECT_NEAR(std::sqrt(c.noise(j, j)), deviation[j], 0.06 * deviation[j]);
  }
  EXPECT_NEAR(c.noise(0, 2) / std::sqrt(c.noise(0, 0) * c.noise(2, 2)), 0.8, 0.05);
  EXPECT_NEAR(c.noise(1, 3) / std::sqrt(c.noise(1, 1) * c.noise(3, 3)), 0, 0.06);
  EXPECT_TRUE(c.touched.empty());
  EXPECT_EQ(c.freedom, 3999);
  EXPECT_EQ(c.drift, VectorXd::Zero(kJoints)) << "white noise does not drift";
}

TEST(Calibrate, OffsetOfAnotherRecord_IsWorseByItsSpread) {
  core::Random random(2, 0);
  const auto model = make_arm(kIiwa);
  const Calibration c = calibrate(*model, make_rest_rows(random, 300, 20, 0.1));
  for (int j = 0; j < kJoints; ++j) {
    const double expected = true_noise()(j, j) + 2 * 0.01;
    EXPECT_NEAR(c.noise_between(j, j), expected, 0.25 * expected);
  }
  EXPECT_EQ(c.postures, 1);
}

TEST(Calibrate, RandomWalk_IsADrift) {
  core::Random random(3, 0);
  const auto model = make_arm(kIiwa);
  RestRows rows = make_rest_rows(random, 60, 40, 0);
  for (int r = 0; r < 60; ++r) {
    double walk = 0;
    for (int i = 0; i < 40; ++i) {
      walk += 0.05 * std::sqrt(0.25) * random.normal();
      rows.tau(0, 40 * r + i) += walk;
      rows.times[static_cast<std::size_t>(40 * r + i)] = 0.25 * i;
    }
  }
  const Calibration c = calibrate(*model, rows);
  EXPECT_NEAR(c.drift[0], 0.05, 0.02);
  EXPECT_LT(c.drift[1], 0.015);
}

TEST(Calibrate, FewRows_GiveAMatrixThatCanBeInverted) {
  core::Random random(4, 0);
  const auto model = make_arm(kIiwa);
  const Calibration c = calibrate(*model, make_rest_rows(random, 1, 3, 0));
  EXPECT_EQ(Eigen::LLT<MatrixXd>(c.noise).info(), Eigen::Success);
  ASSERT_FALSE(c.notes.empty());
  EXPECT_NE(c.notes[0].find("known from 2 differences only"), std::string::npos);
}

TEST(Calibrate, RowsInWhichSomethingTouches_AreLeftOutAndSaid) {
  core::Random random(5, 0);
  const auto model = make_arm(kIiwa);
  RestRows rows = make_rest_rows(random, 1, 60, 0);
  rows.tau.col(17)[1] += 3;
  rows.tau.col(18)[1] += 3;
  const Calibration c = calibrate(*model, rows);
  EXPECT_EQ(c.touched, (std::vector{17, 18}));
  EXPECT_NEAR(c.rest[1], 0.2, 0.04);
  ASSERT_FALSE(c.notes.empty());
  EXPECT_NE(c.notes[0].find("rows 17, 18 are left out"), std::string::npos) << c.notes[0];
  for (int i = 0; i < 25; ++i) rows.tau.col(i)[1] += 3;
  EXPECT_NE(message_of([&] { (void)calibrate(*model, rows); }).find("rows whose torques are far from the others"), std::string::npos);
}

/// Records of which each has rest, a touch of a few newton metres, three rows less than a second after it, and rest again.
RestRows make_touched_rows(core::Random& random, int records, double share) {
  RestRows out;
  const MatrixXd L = true_noise().llt().matrixL();
  const std::vector<double> times{0, 0.5, 1, 1.1, 1.3, 1.4, 1.5, 3, 3.5};
  const int rows = static_cast<int>(times.size());
  out.q = MatrixXd::Constant(kJoints, records * rows, 0.3);
  out.tau.resize(kJoints, records * rows);
  for (int r = 0; r < records; ++r) {
    const VectorXd touch = 2 * random_matrix(random, kJoints, 1),
                   left = share * touch.cwiseProduct(random_matrix(random, kJoints, 1).col(0));
    for (int i = 0; i < rows; ++i) {
      const bool touches = i == 2 || i == 3;
      VectorXd tau = VectorXd::Constant(kJoints, 0.2) + L * random_matrix(random, kJoints, 1);
      if (touches) tau += touch;
      if (i >= 4 && i <= 6) tau += left;
      out.tau.col(r * rows + i) = tau;
      out.records.push_back(r);
      out.times.push_back(times[static_cast<std::size_t>(i)]);
      out.touched.push_back(touches);
    }
  }
  return out;
}

TEST(Calibrate, RowsAfterTouches_SayWhatATouchLeaves) {
  core::Random random(11, 0);
  const auto model = make_arm(kIiwa);
  const Calibration c = calibrate(*model, make_touched_rows(random, 200, 0.05));
  EXPECT_NEAR(c.hysteresis.share, 0.05, 5 * 0.05 / std::sqrt(2 * c.hysteresis.freedom));
  EXPECT_EQ(c.freedom, 200 * 3) << "four rows at rest of each record";
  for (int j = 0; j < kJoints; ++j)
    EXPECT_NEAR(c.within(j, j), true_noise()(j, j), 0.2 * true_noise()(j, j)) << "rows after touches are no noise";

  VectorXd touch = VectorXd::Zero(kJoints);
  touch[4] = 2;
  const TorqueNoise after = c.calc_noise(touch, 0.3, 1), later = c.calc_noise(touch, 1.5, 1);
  EXPECT_EQ(later.covariance, MatrixXd(2 * c.within));
  EXPECT_NEAR(after.covariance(4, 4) - later.covariance(4, 4), std::pow(c.hysteresis.share * 2, 2), 1e-4);
  EXPECT_EQ(after.covariance(3, 3), later.covariance(3, 3));
  EXPECT_NEAR(after.freedom[4], c.hysteresis.freedom, 0.05 * c.hysteresis.freedom) << "nearly all of it is from touches";
  EXPECT_EQ(after.freedom[3], c.freedom);
}

TEST(Calibrate, TouchesThatLeaveNothing_HaveNoHysteresis) {
  core::Random random(12, 0);
  const auto model = make_arm(kIiwa);
  EXPECT_LT(calibrate(*model, make_touched_rows(random, 200, 0)).hysteresis.share, 0.006);
  EXPECT_EQ(calibrate(*model, make_rest_rows(random, 1, 9, 0)).hysteresis.freedom, 0);
}

/// Few records, of others alone: 4 deviations of a normal number are passed far too often, Student's bound is not.
TEST(Calibrate, NoiseOfFewRows_AlarmsNoMoreOftenThanStated) {
  core::Random random(13, 0);
  const auto model = make_arm(kIiwa);
  int normal = 0, student = 0, all = 0;
  for (int trial = 0; trial < 1500; ++trial) {
    const Calibration c = calibrate(*model, make_touched_rows(random, 3, 0.05));
    const RestRows next = make_touched_rows(random, 1, 0.05);
    const VectorXd rest = next.tau.col(8), touch = (next.tau.col(2) - rest).cwiseAbs().cwiseMax((next.tau.col(3) - rest).cwiseAbs());
    const TorqueNoise noise = c.calc_noise(touch, next.times[5] - next.times[3], 1);
    for (int j = 0; j < kJoints; ++j) {  // only one row of a touch: they share what is left
      const double z = std::abs(next.tau(j, 5) - rest[j]) / std::sqrt(noise.covariance(j, j));
      normal += z > 3;
      student += z > calc_student_bound(noise.freedom[j], 3);
      ++all;
    }
  }
  const double stated = std::erfc(3 / std::sqrt(2.0)) * all;
  EXPECT_GT(normal, 2 * stated) << "else the test says nothing";
  EXPECT_LT(student, stated + 4 * std::sqrt(stated));
}

TEST(Calibrate, RowsThatSayNothing_AreRefusedByWhatTheyLack) {
  core::Random random(6, 0);
  const auto model = make_arm(kIiwa);
  const auto refusal = [&](const RestRows& rows) { return message_of([&] { (void)calibrate(*model, rows); }); };
  EXPECT_NE(refusal(make_rest_rows(random, 1, 1, 0)).find("one row alone gives a rest, and says nothing of noise"), std::string::npos);
  EXPECT_NE(refusal(make_rest_rows(random, 5, 1, 0)).find("5 rows at rest, one of each record"), std::string::npos);
  RestRows frozen = make_rest_rows(random, 1, 9, 0);
  frozen.tau.row(3).setConstant(1);
  EXPECT_NE(refusal(frozen).find("the same torque of joint 'arm/"), std::string::npos) << refusal(frozen);
  frozen.measured = {0, 1, 2, 4, 5, 6};
  EXPECT_EQ(calibrate(*model, frozen).noise(3, 3), 1);
  RestRows missing = make_rest_rows(random, 1, 9, 0);
  missing.tau(2, 2) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(refusal(missing).find("tau"), std::string::npos);
  EXPECT_NE(refusal({}).find("no row at rest"), std::string::npos);
  RestRows touched = make_touched_rows(random, 2, 0);
  touched.touched.pop_back();
  EXPECT_NE(refusal(touched).find("touched: got 17 values"), std::string::npos) << refusal(touched);
  touched.touched.assign(18, true);
  EXPECT_NE(refusal(touched).find("no row that is 1 s or more after a touch"), std::string::npos) << refusal(touched);
  touched.times.clear();
  EXPECT_NE(refusal(touched).find("rows without times"), std::string::npos) << refusal(touched);
}

/// Rest in postures of an arm whose last link carries a body that its controller does not know of.
RestRows make_payload_rows(const world::Model& model, core::Random& random, double mass, const Vector3d& centre, int postures) {
  const int body = body_index(model, "arm/link_7");
  RestRows out;
  out.q.resize(kJoints, 4 * postures);
  out.tau.resize(kJoints, 4 * postures);
  for (int p = 0; p < postures; ++p) {
    const VectorXd q = 1.2 * random_matrix(random, kJoints, 1).cwiseMax(-1).cwiseMin(1);
    world::KinematicsWorkspace work(model);
    world::Kinematics kinematics;
    world::calc_kinematics(model, place_robots(model, q), work, kinematics);
    const Vector3d force_L = mass * (kinematics.X_WB[static_cast<std::size_t>(body)].R.transpose() * model.scene().gravity);
    const VectorXd weight = calc_contact_torque(model, place_robots(model, q), body, centre, force_L);
    for (int i = 0; i < 4; ++i) {
      out.q.col(4 * p + i) = q;
      out.tau.col(4 * p + i) = VectorXd::Constant(kJoints, 0.1) + weight + 0.01 * random_matrix(random, kJoints, 1);
      out.records.push_back(p);
    }
  }
  return out;
}

TEST(Calibrate, PayloadThatTheRobotDoesNotKnow_IsWeighed) {
  core::Random random(7, 0);
  const auto model = make_arm(kIiwa);
  const Vector3d centre(0.02, -0.01, 0.08);
  const CalibrationOptions options{.payload_body = body_index(*model, "arm/link_7")};
  const RestRows rows = make_payload_rows(*model, random, 0.8, centre, 12);
  const Calibration c = calibrate(*model, rows, options);
  ASSERT_TRUE(c.payload.has_value());
  EXPECT_NEAR(c.payload->mass, 0.8, 4 * c.payload->mass_deviation);
  EXPECT_LT(c.payload->mass_deviation, 0.05);
  EXPECT_NEAR((c.payload->centre_L - centre).norm(), 0, 0.02);
  const RestRows others = make_payload_rows(*model, random, 0.8, centre, 3);
  for (Eigen::Index i = 0; i < others.q.cols(); ++i)
    EXPECT_LT((c.calc_rest(*model, place_robots(*model, others.q.col(i))) - others.tau.col(i)).cwiseAbs().maxCoeff(), 0.1);
  EXPECT_NE(c.notes.back().find("'arm/link_7' carries "), std::string::npos) << c.notes.back();
  EXPECT_FALSE(calibrate(*model, make_payload_rows(*model, random, 0, centre, 12), options).payload.has_value());
  RestRows two = make_payload_rows(*model, random, 0.8, centre, 2);
  const Calibration few = calibrate(*model, two, options);
  EXPECT_FALSE(few.payload.has_value());
  EXPECT_NE(few.notes.back().find("3 postures or more, these rows have 2"), std::string::npos);
}

TEST(CheckSign, TotalTorquesAtRest_TellTheirSign) {
  core::Random random(8, 0);
  const auto model = make_arm(kIiwa);
  MatrixXd q(kJoints, 6), tau(kJoints, 6);
  for (int i = 0; i < 6; ++i) {
    q.col(i) = 0.8 * random_matrix(random, kJoints, 1).cwiseMax(-1).cwiseMin(1);
    tau.col(i) = calc_holding_torques(*model, place_robots(*model, q.col(i))) + 0.1 * random_matrix(random, kJoints, 1);
  }
  EXPECT_EQ(check_sign(*model, q, tau).sign, 1);
  EXPECT_NEAR(check_sign(*model, q, tau).factor, 1, 0.1);
  EXPECT_EQ(check_sign(*model, q, -tau).sign, -1);
  const SignCheck external = check_sign(*model, q, 0.1 * random_matrix(random, kJoints, 6));
  EXPECT_EQ(external.sign, 0);
  EXPECT_NE(external.message.find("push a joint by hand"), std::string::npos);
}

TEST(HoldingTorques, OfAStretchedPendulum_AreMassTimesLever) {
  const auto model = make_robot(
      "<robot name='r'><link name='base'/><link name='rod'><inertial><origin xyz='0.4 0 0'/><mass value='2'/><inertia ixx='1' iyy='1' "
      "izz='1' ixy='0' ixz='0' "
      "iyz='0'/></inertial><collision><geometry><sphere radius='0.1'/></geometry></collision></link><joint name='j' "
      "type='revolute'><parent link='base'/><child "
      "link='rod'/><axis xyz='0 1 0'/><limit lower='-2' upper='2' effort='9' velocity='1'/></joint></robot>");
  // About y a positive angle lowers the rod, which gravity does: the motor has to pull the other way.
  EXPECT_NEAR(calc_holding_torques(*model, VectorXd::Zero(1))[0], -2 * 9.81 * 0.4, 1e-9);
  EXPECT_NEAR(calc_holding_torques(*model, VectorXd::Constant(1, 1))[0], -2 * 9.81 * 0.4 * std::cos(1), 1e-9);
}

TEST(Whitening, TorquesOfOneNoise_AreLeftAsTheyAre) {
  double uniform = 0;
  EXPECT_EQ(make_covariance(VectorXd(VectorXd::Constant(4, 0.2)), 4, uniform).size(), 0);
  EXPECT_EQ(uniform, 0.2);
  EXPECT_EQ(make_covariance(MatrixXd(0.09 * MatrixXd::Identity(4, 4)), 4, uniform).size(), 0);
  EXPECT_DOUBLE_EQ(uniform, 0.3);
  EXPECT_EQ(make_covariance(MatrixXd(MatrixXd::Constant(1, 1, 0.09)), 1, uniform).size(), 0);
  EXPECT_DOUBLE_EQ(uniform, 0.3) << "of one joint as well";
  EXPECT_EQ(make_covariance(VectorXd(VectorXd::Constant(1, 0.09)), 1, uniform).size(), 0);
  EXPECT_EQ(uniform, 0.09);
  WhitenedTorques plain;
  const VectorXd tau = Eigen::Vector4d(1, 2, 3, 4);
  plain.assign({}, tau, 0.2, 0.01);
  EXPECT_TRUE(plain.is_identity());
  EXPECT_EQ(plain.tau(), tau);
  EXPECT_EQ(plain.noise(), 0.2);
}

TEST(Whitening, NoiseOfTheWhitenedTorques_IsOfOneSizeAndIndependent) {
  core::Random random(9, 0);
  TorqueModel model{.covariance = true_noise(), .rest = VectorXd::Constant(kJoints, 0.5), .sign = -1, .unmeasured = {3}};
  model.validate(kJoints);
  const MatrixXd L = true_noise().llt().matrixL();
  MatrixXd square = MatrixXd::Zero(6, 6);
  constexpr int kDraws = 4000;
  WhitenedTorques whitened;
  for (int i = 0; i < kDraws; ++i) {
    const VectorXd measured = VectorXd::Constant(kJoints, 0.5) - L * random_matrix(random, kJoints, 1);
    whitened.assign(model, measured, 1, 0);
    square += whitened.tau() * whitened.tau().transpose() / kDraws;
  }
  const double s = whitened.noise();
  EXPECT_LT((square / (s * s) - MatrixXd::Identity(6, 6)).cwiseAbs().maxCoeff(), 0.1);
  EXPECT_EQ(whitened.external()[3], 0);
  // A row of J goes with its torque: W J f = W τ.
  const VectorXd f = random_matrix(random, 3, 1);
  Eigen::Matrix3Xd J = random_matrix(random, 3, kJoints);
  whitened.assign(model, VectorXd(VectorXd::Constant(kJoints, 0.5) - J.transpose() * f), 1, 0.05);
  whitened.apply(J);
  EXPECT_LT((J.transpose() * f - whitened.tau()).norm(), 1e-10 * whitened.tau().norm());
}

TEST(Whitening, NoiseThatIsNone_IsRefusedByTheJoint) {
  double uniform = 0;
  const auto refusal = [&](const auto& noise) { return message_of([&] { (void)make_covariance(noise, 3, uniform); }); };
  const VectorXd zero = Vector3d(1, 0, 1), two = VectorXd::Ones(2);
  EXPECT_NE(refusal(zero).find("noise[1]: got 0"), std::string::npos) << refusal(zero);
  EXPECT_NE(refusal(two).find("shape (2, 1)"), std::string::npos);
  const MatrixXd singular = MatrixXd::Ones(3, 3);
  EXPECT_NE(refusal(singular).find("positive definite"), std::string::npos);
  MatrixXd skew = MatrixXd::Identity(3, 3);
  skew(0, 1) = 0.5;
  EXPECT_NE(refusal(skew).find("not symmetric"), std::string::npos);
  TorqueModel model{.sign = 2};
  EXPECT_NE(message_of([&] { model.validate(3); }).find("sign: got 2, expected 1 or -1"), std::string::npos);
}

}  // namespace
}  // namespace stiction::sensing::test
