#include "stiction/control/controller.hpp"

#include <gtest/gtest.h>

#include "control/pressed_arm.hpp"
#include "stiction/core/random.hpp"
#include "support/message_of.hpp"

namespace stiction::control::test {
namespace {

using core::Status;
using Eigen::Vector3d;
using Eigen::VectorXd;
using stiction::test::message_of;

TEST(Controller, NoContact_FollowsTheReferenceAtItsSpeed) {
  Bench bench;
  bench.contacts.clear();
  bench.q_ref[0] = 0.004, bench.q_ref[1] += 0.5;
  const ControllerCommand& command = bench.update();
  EXPECT_EQ(command.status, Status::Solved);
  EXPECT_NEAR(command.q_cmd[0], 0.004, 1e-15);
  EXPECT_NEAR(command.q_cmd[1], posture()[1] + 1.5 * kTick, 1e-15);
}

TEST(Controller, ReferenceInsideTheWall_PredictsNoMoreThanTheBound) {
  Bench bench;
  bench.q_ref[0] = 0.3;
  for (int k = 0; k < 100; ++k) (void)bench.update();
  const ControllerCommand& command = bench.update();
  ASSERT_EQ(command.taken.size(), 1u);
  EXPECT_NEAR(command.qp.lambda[0], 15, 1e-3);
  EXPECT_GT(command.q_cmd[0], 0);
  EXPECT_LT(command.q_cmd[0], 0.3);
}

/// The rate goes before the bound of a force: a contact that appears far above its bound pushes the command out of a slow motion no faster than that.
TEST(Controller, ShareOfTheSpeed_HoldsAgainstAContactThatJumps) {
  for (const double share : {1.0, 0.05}) {
    SCOPED_TRACE(share);
    Bench bench;
    bench.contacts.clear();
    bench.q_ref[0] = 0.3;
    VectorXd before;
    for (int k = 0; k < 100; ++k) before = bench.update().q_cmd;
    bench.contacts = Bench().contacts;
    bench.contacts[0].force_W *= 10;
    bench.speed_share = share;
    const double jump = (bench.update().q_cmd - before).cwiseAbs().maxCoeff();
    EXPECT_LE(jump, share * 1.5 * kTick + 1e-15);
    EXPECT_GT(jump, 0.9 * share * 1.5 * kTick) << "the bound asks for nothing: the test would say nothing";
  }
  Bench bench;
  bench.speed_share = 0;
  EXPECT_NE(message_of([&] { (void)bench.update(); }).find("speed_share: got 0"), std::string::npos);
}

TEST(Controller, WeakForces_AreLeftOut) {
  Bench bench;
  bench.contacts[0].force_W *= 4.9 / 12;
  EXPECT_TRUE(bench.update().taken.empty());
  bench.contacts[0].force_W *= 5.1 / 4.9;
  for (int k = 0; k < 200; ++k) (void)bench.update();
  EXPECT_EQ(bench.update().taken.size(), 1u);
}

/// An edge that rests on one corner in this tick and on the other in the next acts between them, by their shares of the force.
TEST(Controller, CornersThatBearInTurn_ActAsOnePointBetweenThem) {
  Bench bench;
  bench.q_ref[0] = 0.3;
  const Vector3d middle = bench.contacts[0].p_WC, half(0, 0, 0.1);
  VectorXd last;
  double moved = 0;
  for (int k = 0; k < 400; ++k) {
    const bool upper = k % 2 == 0;
    bench.contacts[0].p_WC = middle + (upper ? 1 : -1) * half;
    bench.contacts[0].force_W = Vector3d(0, upper ? -15 : -5, 0);  // the mean is half the way up
    const VectorXd command = bench.update().q_cmd;
    if (k > 300) moved = std::max(moved, (command - last).cwiseAbs().maxCoeff());
    last = command;
  }
  const ControllerCommand& command = bench.update();
  ASSERT_EQ(command.taken.size(), 1u);
  EXPECT_LT((command.taken[0].p_WC - (middle + 0.5 * half)).norm(), 0.2 * half.norm()) << "a tick has a tenth of the mean";
  VectorXd at_corner[2];  // a corner that bears alone
  for (const int corner : {0, 1}) {
    Bench alone;
    alone.q_ref[0] = 0.3;
    alone.contacts[0].p_WC = middle + (corner == 0 ? 1 : -1) * half;
    for (int k = 0; k < 400; ++k) at_corner[corner] = alone.update().q_cmd;
  }
  EXPECT_LT(moved, 0.2 * (at_corner[0] - at_corner[1]).cwiseAbs().maxCoeff()) << "the command jumps between corners";
}

/// A force that the springs do not explain, here of joints that move, is taken off the bound, up to half of it.
TEST(Controller, ForceBesideThatOfTheSprings_IsTakenOffTheBound) {
  Bench bench({.damping = {.largest = 0}});
  bench.q_ref[0] = 0.3;
  const Row row(bench);
  const auto settle = [&](double beside) {
    for (int k = 0; k < 400; ++k) {
      const VectorXd q_cmd = bench.update().q_cmd;
      bench.contacts[0].force_W = Vector3d(0, -(row.calc_force(q_cmd, bench.q) + beside), 0);
    }
    return bench.update().bound[0];
  };
  EXPECT_NEAR(settle(0), 15, 0.05);
  EXPECT_NEAR(settle(3), 12, 0.05);
  EXPECT_NEAR(-bench.contacts[0].force_W[1], 15, 0.1) << "what is measured is at the bound";
  EXPECT_NEAR(settle(10), 7.5, 1e-9) << "no more than half";
}

/// Beside a tool that does not move, a posture that is off comes back in its time constant instead of in a tick.
TEST(Controller, PostureBesideATool_ComesBackInItsTimeConstant) {
  Bench bench({.posture_time_constant = 0.2});
  bench.contacts.clear();
  world::KinematicsWorkspace work(*bench.model);
  world::Kinematics kinematics;
  calc_kinematics(*bench.model, bench.q, work, kinematics);
  const auto link = static_cast<std::size_t>(bench.link);
  ToolReference tool{.body = bench.link, .X_BT = {}, .X_WT = kinematics.X_WB[link]};
  VectorXd away = bench.q;
  away[0] += 0.1, away[2] -= 0.1;  // the preferred posture: mostly of the elbow
  double before = (away - bench.q).norm();
  const double start = before;
  double fastest = 0;
  for (int k = 0; k < 40; ++k) {  // of 5 ms: one time constant
    const VectorXd last = bench.q;
    bench.time += kTick;
    bench.q = bench.controller.update({.time = bench.time, .q = last, .q_ref = away, .contacts = {}, .tool = &tool}, kTick).q_cmd;
    fastest = std::max(fastest, (bench.q - last).norm() / kTick);
    EXPECT_LE((away - bench.q).norm(), before + 1e-9) << k;
    before = (away - bench.q).norm();
  }
  EXPECT_LE(fastest, start / 0.2) << "no faster than it would begin";
  EXPECT_LT(before, start - 0.2 * start) << "it comes back";
  calc_kinematics(*bench.model, bench.q, work, kinematics);
  EXPECT_LE((kinematics.X_WB[link].p - tool.X_WT.p).norm(), 2e-3) << "the tool stays";
}

TEST(Controller, BaselinesForgetAContactWhileItsForceDecays) {
  Bench bench({.law = Law::NullSpace, .force_time_constant = 0.05});
  bench.q_ref[0] = 0.3;
  (void)bench.update();
  bench.contacts.clear();
  int kept = 0;
  while (!bench.update().taken.empty()) ++kept;
  // 12 N (T / (T + h))^k ≥ 5 N with T = 10 h
  EXPECT_EQ(kept, static_cast<int>(std::log(12.0 / 5) / std::log(1.1)));
}

TEST(Controller, MeasurementThatIsNotYounger_IsHeldAndSaid) {
  Bench bench;
  const VectorXd before = bench.update().q_cmd;
  bench.q_ref[0] = 0.1;
  const ControllerCommand& same =
      bench.controller.update({.time = bench.time, .q = bench.q, .q_ref = bench.q_ref, .contacts = bench.contacts}, kTick);
  EXPECT_TRUE(same.held);
  EXPECT_EQ(same.q_cmd, before);
  EXPECT_TRUE(bench.controller.update({.time = bench.time - 1, .q = bench.q, .q_ref = bench.q_ref, .contacts = {}}, kTick).held);
  EXPECT_FALSE(bench.update().held);
}

TEST(Controller, ContactsThatComeAndGo_AreAllSolved) {
  core::Random random(5, 0);
  Bench bench({.max_contacts = 4});
  int left_out = 0;
  for (int k = 0; k < 2000; ++k) {
    bench.contacts.clear();
    const int n = random.index(9);
    for (int i = 0; i < n; ++i) {
      const Vector3d force(random.normal(), random.normal(), random.normal());
      const int link = find_body(*bench.model, "arm/link_" + std::to_string(1 + random.index(7)));
      bench.contacts.push_back({.id = random.index(12), .body = link, .p_WC = 0.5 * force, .force_W = 20 * force});
    }
    for (double& x : bench.q_ref) x += 0.01 * random.normal();
    const VectorXd before = bench.controller.update({.time = -1, .q = bench.q, .q_ref = bench.q_ref, .contacts = {}}, kTick).q_cmd;
    const ControllerCommand& command = bench.update();
    ASSERT_EQ(command.status, Status::Solved) << k;
    ASSERT_LE(command.taken.size(), 4u);
    ASSERT_LE((command.q_cmd - before).cwiseAbs().maxCoeff(), 1.5 * kTick * (1 + 1e-12));
    for (Eigen::Index i = 0; i < command.qp.lambda.size(); ++i) {
      const int id = command.taken[static_cast<std::size_t>(i)].id;
      const bool seen = std::any_of(bench.contacts.begin(), bench.contacts.end(), [&](const auto& c) { return c.id == id; });
      if (!seen) continue;
      ASSERT_LE(command.qp.lambda[i], 15 + command.qp.slack[i] + 1e-6) << k;
    }
    left_out += command.left_out;
  }
  EXPECT_GT(left_out, 100) << "room is never short";
}

/// The baseline by its formula; from the tick on at which the reference leaves it tracks.
TEST(Controller, NullSpaceBaseline_HasTheForceAsAnEquality) {
  Bench bench({.law = Law::NullSpace});
  bench.q_ref[0] = 0.05, bench.q_ref[3] += 0.02;
  const VectorXd command = bench.update().q_cmd;
  world::KinematicsWorkspace work(*bench.model);
  world::Kinematics kinematics;
  calc_kinematics(*bench.model, bench.q, work, kinematics);
  RowMatrix J(6, 7);
  world::calc_point_jacobian(*bench.model, kinematics, bench.link, bench.contacts[0].p_WC, J);
  const RowMatrix J_u = -J.row(1);
  const VectorXd K = bench.model->stiffness();
  Equilibrium equilibrium;
  Eigen::MatrixXd inverse;
  ASSERT_EQ(calc_equilibrium(K, J_u, bench.q, command, equilibrium), Status::Solved);
  EXPECT_NEAR(equilibrium.lambda[0], 15, 1e-9);
  ASSERT_EQ(calc_stiffness_consistent_inverse(K, J_u, inverse), Status::Solved);
  const VectorXd moved = bench.q_ref - bench.q - inverse * (J_u * (bench.q_ref - bench.q));
  EXPECT_LE((equilibrium.q - bench.q - moved).norm(), 1e-12);
  bench.q_ref[0] = -0.05;
  EXPECT_LE((bench.update().q_cmd - bench.q_ref).norm(), 1e-15);
}

/// (J_u⁺)ᵀ K (q_cmd − q) = −λ_max, and of what meets that the nearest to the reference, 0.1 of the command before: off it along H⁻¹ K J_u⁺ ∝ K J_uᵀ alone.
TEST(Controller, EarlyForm_HasTheForceOfOneContactAsAnEqualityFromTwoThirdsOfTheBoundOn) {
  Bench bench(make_early_form({}));
  EXPECT_NEAR(bench.controller.options().force_time_constant, 0.318, 1e-3) << "0.5 Hz";
  const VectorXd q_last = bench.q, K = bench.model->stiffness();
  bench.q_ref[0] = 0.05, bench.q_ref[3] += 0.02;
  bench.contacts.push_back({.id = 4, .body = bench.link, .p_WC = Vector3d(0.6, 0.03, 0.4), .force_W = Vector3d(8, 0, 0)});
  const ControllerCommand& command = bench.update();
  ASSERT_EQ(command.status, Status::Solved);
  ASSERT_EQ(command.taken.size(), 1u);
  EXPECT_EQ(command.taken[0].id, 3) << "the strongest";
  const Row row(bench);
  const VectorXd inverse = row.J_u / row.J_u.squaredNorm();
  EXPECT_NEAR(inverse.dot(K.cwiseProduct(command.q_cmd - bench.q)), -15, 1e-9);
  const VectorXd off = command.q_cmd - (bench.q_ref + 0.1 * q_last) / 1.1, along = K.cwiseProduct(row.J_u).normalized();
  EXPECT_LE((off - along * along.dot(off)).norm(), 1e-12);
  EXPECT_GT(off.norm(), 1e-3);
  bench.q_ref[0] = -0.05;
  EXPECT_NEAR(inverse.dot(K.cwiseProduct(bench.update().q_cmd - bench.q)), -15, 1e-9) << "it holds on although the reference leaves";

  Bench weak(make_early_form({}));
  weak.contacts[0].force_W *= 9.9 / 12;
  weak.q_ref[0] = 0.05;
  EXPECT_LE((weak.update().q_cmd - (weak.q_ref + 0.1 * q_last) / 1.1).norm(), 1e-12) << "9.9 N do not count";
}

TEST(Controller, ReferenceOutsideJointLimits_CommandStopsAtThem) {
  Bench bench;
  bench.contacts.clear();
  bench.q_ref = bench.model->upper() + VectorXd::Constant(7, 1);
  VectorXd last = bench.q;
  for (int k = 0; k < 2000; ++k) {
    const ControllerCommand& command = bench.update();
    ASSERT_EQ(command.status, Status::Solved);
    ASSERT_TRUE((command.q_cmd.array() <= bench.model->upper().array()).all()) << k;
    last = command.q_cmd;
  }
  EXPECT_EQ(last, bench.model->upper());
}

TEST(Controller, UnconstrainedBaseline_TracksTheTool) {
  Bench bench({.law = Law::Unconstrained});
  world::KinematicsWorkspace work(*bench.model);
  world::Kinematics kinematics;
  calc_kinematics(*bench.model, bench.q, work, kinematics);
  ToolReference tool{.body = bench.link, .X_BT = {}, .X_WT = kinematics.X_WB[static_cast<std::size_t>(bench.link)]};
  tool.X_WT.p += Vector3d(1e-3, -2e-3, 1e-3);
  const VectorXd command =
      bench.controller.update({.time = 1, .q = bench.q, .q_ref = bench.q_ref, .contacts = bench.contacts, .tool = &tool}, kTick).q_cmd;
  calc_kinematics(*bench.model, command, work, kinematics);
  EXPECT_LE((kinematics.X_WB[static_cast<std::size_t>(bench.link)].p - tool.X_WT.p).norm(), 1e-4)
      << "posture weight and curvature leave a part of 2.4 mm";
}

TEST(ControllerInput, BadNumbers_AreNamed) {
  const auto with = [](auto&& change) {
    ControllerOptions options;
    change(options);
    return message_of([&] { ContactController(make_arm(), options); });
  };
  EXPECT_NE(with([](auto& o) { o.lambda_max = 0; }).find("lambda_max: got 0"), std::string::npos);
  EXPECT_NE(with([](auto& o) { o.posture_time_constant = -1; }).find("posture_time_constant: got -1"), std::string::npos);
  EXPECT_NE(with([](auto& o) { o.release_time = 0; }).find("release_time: got 0"), std::string::npos);
  EXPECT_NE(with([](auto& o) { o.force_threshold = 15; }).find("force_threshold"), std::string::npos);
  EXPECT_NE(with([](auto& o) { o.torque = VectorXd::Constant(7, -1); }).find("torque: got -1"), std::string::npos);
  EXPECT_NE(with([](auto& o) { o.torque = VectorXd::Constant(3, 1); }).find("torque"), std::string::npos);
  EXPECT_NE(with([](auto& o) { o.damping.forget_rate = 0; }).find("damping.forget_rate"), std::string::npos);
  EXPECT_NE(with([](auto& o) { o.qp.force_priority = 1; }).find("force_priority"), std::string::npos);

  Bench bench;
  const auto update = [&](double dt) {
    return message_of(
        [&] { (void)bench.controller.update({.time = 1, .q = bench.q, .q_ref = bench.q_ref, .contacts = bench.contacts}, dt); });
  };
  EXPECT_NE(update(0).find("dt: got 0"), std::string::npos);
  EXPECT_NE(update(-1).find("dt: got -1"), std::string::npos);
  bench.contacts[0].lambda_max = 0;
  EXPECT_NE(update(kTick).find("contact.lambda_max: got 0"), std::string::npos);
  bench.contacts[0].lambda_max.reset(), bench.contacts[0].body = 1000;
  EXPECT_NE(update(kTick).find("contact.body: got 1000"), std::string::npos);
  bench.contacts[0].body = bench.link, bench.contacts[0].force_W[1] = std::nan("");
  EXPECT_NE(update(kTick).find("contact: got"), std::string::npos);
  bench.contacts.clear();
  ToolReference tool{.body = bench.link, .X_BT = {}, .X_WT = {}};
  tool.X_WT.p[1] = std::nan("");
  EXPECT_EQ(message_of([&] {
              (void)bench.controller.update({.time = 1, .q = bench.q, .q_ref = bench.q_ref, .contacts = {}, .tool = &tool}, kTick);
            }),
            "tool: got a number that is not finite, expected finite poses");
  EXPECT_TRUE(bench.controller.update({.time = 2, .q = bench.q, .q_ref = bench.q_ref, .contacts = {}}, kTick).q_cmd.allFinite())
      << "later ticks are as good as before";
  bench.q[2] = std::nan("");
  EXPECT_NE(update(kTick).find("q: got nan"), std::string::npos);
  bench.q = VectorXd::Zero(6);
  EXPECT_NE(update(kTick).find("q: got"), std::string::npos);
}

}  // namespace
}  // namespace stiction::control::test
