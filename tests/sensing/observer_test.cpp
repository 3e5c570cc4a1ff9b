#include "stiction/sensing/observer.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "sensing/random_contact.hpp"
#include "sensing/robots.hpp"
#include "stiction/sensing/calibrate.hpp"
#include "stiction/sensing/known_contacts.hpp"
#include "support/message_of.hpp"

namespace stiction::sensing::test {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using stiction::test::message_of;

/// A rod of mass m whose centre of mass is at distance l from a horizontal axis, with inertia I about its centre.
constexpr double kMass = 2, kLever = 0.4, kInertia = 0.1;
std::shared_ptr<const world::Model> make_pendulum() {
  return make_robot(
      "<robot name='r'><link name='base'/><link name='rod'><inertial><origin xyz='0.4 0 0'/><mass value='2'/><inertia ixx='0.1' iyy='0.1' "
      "izz='0.1' ixy='0' ixz='0' "
      "iyz='0'/></inertial><collision><geometry><sphere radius='0.1'/></geometry></collision></link><joint name='j' "
      "type='revolute'><parent link='base'/><child "
      "link='rod'/><axis xyz='0 1 0'/><limit lower='-2' upper='2' effort='90' velocity='9'/></joint></robot>");
}

TEST(Observe, Pendulum_ShowsTheExternalTorqueBehindItsLag) {
  const auto model = make_pendulum();
  constexpr double kStep = 1e-3, kLag = 0.02, kExternal = 3;
  MotionRecord record;
  const Eigen::Index n = 1000;
  record.q.resize(1, n);
  record.v.resize(1, n);
  record.tau.resize(1, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const double t = kStep * static_cast<double>(i), q = 0.6 * std::sin(3 * t), v = 1.8 * std::cos(3 * t), a = -5.4 * std::sin(3 * t);
    record.times.push_back(t);
    record.q(0, i) = q;
    record.v(0, i) = v;
    record.tau(0, i) = (kInertia + kMass * kLever * kLever) * a - kMass * 9.81 * kLever * std::cos(q) - (t >= 0.5 ? kExternal : 0);
  }
  const MatrixXd r = observe(*model, record, {.time_constant = kLag});
  EXPECT_LT(r.leftCols(499).cwiseAbs().maxCoeff(), 1e-3);
  EXPECT_NEAR(r(0, 500 + 20), kExternal * (1 - std::exp(-1)), 0.05);
  EXPECT_NEAR(r(0, n - 1), kExternal, 1e-3);
}

/// A random motion of an arm with the torques of a contact and of friction: accelerations from differences of the momentum along the same path are no oracle, so that
/// energy is: what motors, gravity, friction and the contact do is what the kinetic energy gains.
TEST(Observe, ArmWithAContact_BalancesPower) {
  const auto model = make_arm(kIiwa);
  constexpr double kStep = 5e-4, kLag = 2e-3;
  const Eigen::Index n = 2000, joints = model->n_a();
  MotionRecord record;
  record.q.resize(joints, n);
  record.v.resize(joints, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const double t = kStep * static_cast<double>(i);
    record.times.push_back(t);
    for (Eigen::Index j = 0; j < joints; ++j) {
      const double rate = 2 + 0.3 * static_cast<double>(j);
      record.q(j, i) = 0.5 * std::sin(rate * t + static_cast<double>(j));
      record.v(j, i) = 0.5 * rate * std::cos(rate * t + static_cast<double>(j));
    }
  }
  record.tau = MatrixXd::Zero(joints, n);  // without motors all that moves the arm is external
  const MatrixXd r = observe(*model, record, {.time_constant = kLag});
  const auto energy = [&](Eigen::Index i) {  // kinetic and potential, by masses and speeds alone
    double out = 0;
    world::KinematicsWorkspace work(*model);
    world::Kinematics before, after;
    constexpr double kSmall = 1e-5;
    world::calc_kinematics(*model, place_robots(*model, record.q.col(i) - kSmall * record.v.col(i)), work, before);
    world::calc_kinematics(*model, place_robots(*model, record.q.col(i) + kSmall * record.v.col(i)), work, after);
    for (const world::Link& link : model->links()) {
      const auto body = static_cast<std::size_t>(link.body);
      const auto& inertia = model->inertias()[body];
      const Eigen::Vector3d centre = 0.5 * (before.X_WB[body] * inertia.p_BCom + after.X_WB[body] * inertia.p_BCom);
      const Eigen::Vector3d speed = (after.X_WB[body] * inertia.p_BCom - before.X_WB[body] * inertia.p_BCom) / (2 * kSmall);
      const Eigen::AngleAxisd turn(Eigen::Matrix3d(before.X_WB[body].R.transpose() * after.X_WB[body].R));
      const Eigen::Vector3d w = turn.axis() * turn.angle() / (2 * kSmall);
      out +=
          0.5 * inertia.mass * speed.squaredNorm() + 0.5 * w.dot(inertia.inertia * w) - inertia.mass * model->scene().gravity.dot(centre);
    }
    return out;
  };
  double work = 0, most = 0;
  const Eigen::Index from = 100, to = n - 1;
  const auto lag = static_cast<Eigen::Index>(kLag / kStep);
  for (Eigen::Index i = from; i + lag < to; ++i) {
    work += kStep * r.col(i + lag).dot(record.v.col(i));  // r is behind by its lag
    most = std::max(most, std::abs(work));
  }
  EXPECT_GT(most, 1) << "hardly any work is done";
  EXPECT_NEAR(work, energy(to - lag) - energy(from), 0.02 * most);
}

TEST(IdentifyFriction, OfAPendulum_IsFoundFromMotion) {
  const auto model = make_pendulum();
  MotionRecord record;
  const Eigen::Index n = 6000;
  record.q.resize(1, n);
  record.v.resize(1, n);
  record.tau.resize(1, n);
  core::Random random(1, 0);
  for (Eigen::Index i = 0; i < n; ++i) {
    const double t = 1e-3 * static_cast<double>(i), q = 0.6 * std::sin(2 * t), v = 1.2 * std::cos(2 * t), a = -2.4 * std::sin(2 * t);
    record.times.push_back(t);
    record.q(0, i) = q;
    record.v(0, i) = v;
    record.tau(0, i) = (kInertia + kMass * kLever * kLever) * a - kMass * 9.81 * kLever * std::cos(q) + 0.7 * std::tanh(v / 0.01) +
                       0.4 * v + 0.15 + 0.05 * random.normal();
  }
  const JointFriction friction = identify_friction(*model, record);
  EXPECT_NEAR(friction.coulomb[0], 0.7, 0.03);
  EXPECT_NEAR(friction.viscous[0], 0.4, 0.03);
  EXPECT_NEAR(friction.offset[0], 0.15, 0.01);
  const MatrixXd raw = observe(*model, record), without = observe(*model, record, {.friction = &friction});
  EXPECT_GT(raw.cwiseAbs().maxCoeff(), 0.9);
  EXPECT_LT(without.rightCols(n - 200).cwiseAbs().maxCoeff(), 0.12);
  record.v = record.v.cwiseAbs();
  EXPECT_NE(message_of([&] { (void)identify_friction(*model, record); }).find("joint 'robot/j', expected motion in both directions"),
            std::string::npos);
}

/// While a joint sticks, friction bears any torque within ± its size. Such rows say nothing about friction.
TEST(FitFriction, RowsOfAJointThatSticks_AreLeftOut) {
  const auto model = make_pendulum();
  constexpr double kDt = 0.005, kDry = 0.7, kOffset = 0.15, kLag = 0.02;
  std::vector<double> times;
  const Eigen::Index n = 2000;
  MatrixXd v(1, n), r(1, n);
  double filtered = 0;
  for (Eigen::Index i = 0; i < n; ++i) {
    const double t = kDt * static_cast<double>(i);
    times.push_back(t);
    const double wave = std::sin(2 * std::numbers::pi * t);
    v(0, i) = std::abs(wave) > 0.6 ? 0.1 * wave : 0;  // then it sticks until the spring turns it round
    const double friction = v(0, i) != 0 ? kDry * (wave > 0 ? 1 : -1) : kDry * std::cos(40 * t);
    filtered += -std::expm1(-kDt / kLag) * (friction + kOffset - filtered);
    r(0, i) = -filtered;
  }
  const JointFriction found = fit_friction(*model, times, v, r, kLag, 0.01);
  EXPECT_NEAR(found.coulomb[0] + 0.09 * found.viscous[0], kDry, 0.05 * kDry);
  EXPECT_NEAR(found.offset[0], kOffset, 0.05 * kDry);
  EXPECT_LT(found.left[0], 0.05 * kDry) << "torques of sticking joints are no noise";
}

TEST(Observe, RecordThatIsNone_IsRefusedByName) {
  const auto model = make_pendulum();
  MotionRecord record{{0, 1}, MatrixXd::Zero(1, 2), MatrixXd::Zero(1, 2), MatrixXd::Zero(1, 2)};
  const auto refusal = [&] { return message_of([&] { (void)observe(*model, record); }); };
  EXPECT_EQ(refusal(), "no exception");
  record.times = {1, 1};
  EXPECT_NE(refusal().find("t[1]: got 1 after 1, expected times that increase"), std::string::npos) << refusal();
  record.times = {0, 1};
  record.v(0, 1) = std::numeric_limits<double>::infinity();
  EXPECT_NE(refusal().find("qd"), std::string::npos);
}

}  // namespace
}  // namespace stiction::sensing::test
