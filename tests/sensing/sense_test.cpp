#include "stiction/sensing/sense.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "sensing/robots.hpp"
#include "stiction/core/random.hpp"
#include "stiction/sensing/known_contacts.hpp"
#include "stiction/sensing/residual_map.hpp"
#include "stiction/sensing/scenario.hpp"
#include "support/message_of.hpp"

namespace stiction::sensing::test {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

VectorXd vector(std::initializer_list<double> values) {
  VectorXd out(static_cast<Eigen::Index>(values.size()));
  std::copy(values.begin(), values.end(), out.data());
  return out;
}

/// The link's frame of an arm at q.
LinkTorque torque_of(const world::Model& model, const std::string& link, const VectorXd& q, const VectorXd& tau) {
  world::KinematicsWorkspace work(model);
  world::Kinematics kinematics;
  world::calc_kinematics(model, q, work, kinematics);
  Eigen::Matrix3Xd J_w, J_v;
  calc_link_jacobian(model, kinematics, body_index(model, link), J_w, J_v);
  return LinkTorque(J_w, J_v, tau);
}

// The case of Figs 4-6, 4-7 and 4-10: q and τ of the thesis's research code, contact as found on the manufacturer's mesh to four digits.
const VectorXd kQ1 = vector({-1.75956086, 0.74755266, 2.72834054, 2.05278647, 2.3270361, -1.27883698, 0.61326711});
const VectorXd kTau1 = vector({0.966613398, -2.82202806, -0.00160744425, 0.662280818, 0.0319086728, 0.0817417009, 0});

TEST(PublishedCase, ContactOnLinkSix_MakesTheTorques) {
  const auto model = make_arm(kIiwa);
  const LinkTorque link = torque_of(*model, "arm/link_6", kQ1, kTau1);
  const Vector3d n = Vector3d(-0.907, 0.260, -0.331).normalized();
  const auto R = make_contact_frame(n);
  const Residual r = calc_residual(link, {-0.0606, 0.0155, -0.0304}, R, FrictionCone(1, 4));
  EXPECT_LT(r.value, 1e-5);  // 10 N, points to 0.1 mm: (10 · 1e-4)² = 1e-6 a coordinate
  EXPECT_NEAR(r.force_C.norm(), 10, 0.02);
  EXPECT_NEAR((R * r.force_C - Vector3d(9.13, -3.69, 1.71)).norm(), 0, 0.03);
}

TEST(PublishedCase, LinkFive_ExplainsAllButJointSix) {
  const auto model = make_arm(kIiwa);
  const LinkTorque link = torque_of(*model, "arm/link_5", kQ1, kTau1);
  // The force and point without a surface: what is left at best is τ₆² (and τ₇² = 0).
  double least = 1e9;
  for (const Vector3d& p : {Vector3d(-0.019, -0.001, 0.097), Vector3d(-0.009, 0.011, 0.104), Vector3d(-0.030, -0.013, 0.090)}) {
    const auto M = link.torque_map(p);
    const Vector3d f = M.colPivHouseholderQr().solve(link.R_tau);
    least = std::min(least, (M * f - link.R_tau).squaredNorm());
  }
  EXPECT_NEAR(0.5 * least, 0.003341, 2e-5);
  EXPECT_NEAR(0.5 * kTau1[5] * kTau1[5], 0.003341, 1e-6);
}

TEST(PublishedCase, StartOnLinkSix_HasTheResidualAndGradientOfTheReference) {
  const auto model = make_arm(kIiwa);
  const VectorXd q = vector({-0.47839296, -0.07140746, -1.62651793, 1.37309486, 0.22398543, 0.67425391, 2.79916161});
  const VectorXd tau = vector({2.19172843, -2.52495118, 2.1875039, -2.28800535, 0.19415752, 0.14975149, 0});
  const LinkTorque link = torque_of(*model, "arm/link_6", q, tau);
  const Vector3d p(0.0054828, -0.00315267, 0.0649383);
  const auto R = make_contact_frame(Vector3d(0.0329616, 0.114744, 0.992848).normalized());
  const Residual r = calc_residual(link, p, R, FrictionCone(1, 4));
  const Vector3d gradient = calc_gradient(link, p, R * r.force_C);
  EXPECT_NEAR(r.value, 0.35190, 1e-4);
  EXPECT_NEAR((gradient - Vector3d(-10.2311, 1.9531, 5.5823)).norm(), 0, 2e-3);
}

double distance_to_truth(const SenseResult& result, const ContactPoint& contact) {
  double out = std::numeric_limits<double>::infinity();
  for (const Candidate& candidate : result.candidates)
    if (candidate.explains) out = std::min(out, calc_distance(result, candidate, contact));
  return out;
}

/// Share of random contacts on links behind at least `joints` joints that are within 1 cm of a candidate.
double calc_recall(const std::string& arm, int joints, const SenseOptions& options, int cases) {
  const auto sensor = Sensor::make(make_arm(arm));
  std::vector<int> links;
  for (int i = 0; i < static_cast<int>(sensor->links().size()); ++i)
    if (sensor->links()[static_cast<std::size_t>(i)].joints >= joints) links.push_back(i);
  core::Random random(1, 0);
  SenseWorkspace work(sensor);
  SenseResult result;
  int found = 0, tried = 0;
  while (tried < cases) {
    const KnownCase c = make_random_case(*sensor, links, options.cone, 10, random);
    if (c.tau.cwiseAbs().maxCoeff() < 0.1) continue;  // hardly any lever
    ++tried;
    sense(*sensor, {c.q, c.tau}, options, work, result);
    found += distance_to_truth(result, c.contact) <= 0.01;
  }
  return static_cast<double>(found) / cases;
}

SenseOptions noiseless() {
  SenseOptions out;
  out.noise = 1e-4;
  return out;
}

TEST(Sense, RandomContactsOnUr5_AreAmongTheCandidates) { EXPECT_GE(calc_recall(kUr5, 5, noiseless(), 60), 0.95); }

TEST(Sense, RandomContactsOnPanda_AreAmongTheCandidates) { EXPECT_GE(calc_recall(kPanda, 5, noiseless(), 60), 0.95); }

TEST(Sense, PublishedSettings_FindContactsToo) {
  SenseOptions options = noiseless();
  options.method = SteepestDescent{};
  EXPECT_GE(calc_recall(kUr5, 5, options, 60), 0.9);
}

/// The arm of capsules; its inner faces, which take seconds to find, do not matter here.
std::shared_ptr<const Sensor> make_iiwa() {
  SensorOptions options;
  options.surface.rays = 0;
  return Sensor::make(make_arm(kIiwa), options);
}

TEST(ResidualMap, EverySample_HasTheResidualOfOnePoint) {
  const auto sensor = make_iiwa();
  const FrictionCone cone(0.5, 4);
  const auto maps = calc_residual_map(*sensor, kQ1, kTau1, cone);
  ASSERT_EQ(maps.size(), sensor->links().size());
  for (std::size_t i = 0; i < maps.size(); ++i) {
    const SensedLink& link = sensor->links()[i];
    ASSERT_EQ(maps[i].size(), link.batch.size);
    const LinkTorque torque = torque_of(sensor->model(), sensor->link_name(static_cast<int>(i)), kQ1, kTau1);
    for (Eigen::Index k = 0; k < maps[i].size(); ++k)
      ASSERT_NEAR(maps[i][k], calc_residual(torque, link.batch.p_L(k), link.batch.R_LC(k), cone).value, 1e-10 * kTau1.squaredNorm());
  }
  EXPECT_NE(stiction::test::message_of([&] {
              (void)calc_residual_map(*sensor, kQ1, kTau1.head(6), cone);
            }).find("tau: got 6 numbers, expected 7"),
            std::string::npos);
}

TEST(PublishedCase, PlanarTorques_AreMadeByEveryCandidate) {
  // Of the thesis's research code: an arm in a vertical plane, torques about the two joints that bend it there.
  const VectorXd q = vector({0, 0, 0, -1.75, 0, 1, 0}), tau = vector({0, -4.88641225, 0, 3.36167658, 0, 0, 0});
  const auto sensor = make_iiwa();
  SenseWorkspace work(sensor);
  SenseResult result;
  sense(*sensor, {q, tau}, noiseless(), work, result);
  ASSERT_EQ(result.verdict, Verdict::Explained);
  bool on_link_five_or_six = false;
  for (const Candidate& candidate : result.candidates) {
    if (!candidate.explains) continue;
    const int body = sensor->links()[static_cast<std::size_t>(candidate.best.link)].surface.body;
    const VectorXd made = calc_contact_torque(sensor->model(), q, body, candidate.best.p_L, candidate.best.f_L);
    EXPECT_LE((made - tau).norm(), std::sqrt(result.explained) + 1e-9);
    // Joints 2 and 4 have parallel axes, 0.4 m apart and opposite axes: the sum of their torques is the force across the upper arm times that.
    EXPECT_GE(candidate.f_W.norm(), std::abs(tau[1] + tau[3]) / 0.4 * 0.9);
    const std::string& name = sensor->link_name(candidate.best.link);
    on_link_five_or_six |= name == "arm/link_5" || name == "arm/link_6";
  }
  EXPECT_TRUE(on_link_five_or_six);
}

TEST(Sense, SmallTorques_AreBelowTheThreshold) {
  const auto sensor = make_iiwa();
  SenseWorkspace work(sensor);
  SenseResult result;
  VectorXd tau = VectorXd::Zero(7);
  tau[1] = 0.39;  // below 4 · 0.1
  sense(*sensor, {kQ1, tau}, {}, work, result);
  EXPECT_EQ(result.verdict, Verdict::BelowThreshold);
  EXPECT_TRUE(result.candidates.empty());
  tau[1] = 0.41;
  sense(*sensor, {kQ1, tau}, {}, work, result);
  EXPECT_NE(result.verdict, Verdict::BelowThreshold);
}

TEST(Sense, TorquesOfTwoForces_AreUnexplainedOrSaidToBe) {
  // A couple about joint 7, which moves only the last link, and a torque on joint 1 that no force through it makes.
  const auto sensor = make_iiwa();
  SenseWorkspace work(sensor);
  SenseResult result;
  VectorXd tau = VectorXd::Zero(7);
  tau << 30, -30, 30, -30, 30, -30, 30;
  sense(*sensor, {kQ1, tau}, noiseless(), work, result);
  EXPECT_EQ(result.verdict, Verdict::Unexplained);
  for (const Candidate& candidate : result.candidates) EXPECT_FALSE(candidate.explains);
}

TEST(Sense, FrictionThatIsTooSmall_IsOpenedOnlyWhereNothingExplains) {
  const auto sensor = Sensor::make(make_arm(kPanda));
  std::vector<int> links;
  for (int i = 0; i < static_cast<int>(sensor->links().size()); ++i)
    if (sensor->links()[static_cast<std::size_t>(i)].joints >= 5) links.push_back(i);
  SenseOptions stated = noiseless();
  stated.noise = 0.02;
  stated.cone = FrictionCone(0.6, 4);
  SenseOptions opened = stated;
  opened.friction_error = 0.4;
  SenseWorkspace work(sensor);
  SenseResult strict, wide;
  core::Random random(11, 0);
  int unexplained = 0, right = 0;
  for (int i = 0; i < 60; ++i) {
    const KnownCase c = make_random_case(*sensor, links, FrictionCone(1, 4), 10, random);
    sense(*sensor, {c.q, c.tau}, stated, work, strict);
    sense(*sensor, {c.q, c.tau}, opened, work, wide);
    if (strict.verdict == Verdict::Explained) {
      EXPECT_EQ(wide.friction, 0.6);
      ASSERT_EQ(wide.candidates.size(), strict.candidates.size());
      EXPECT_EQ(wide.candidates[0].best.p_L, strict.candidates[0].best.p_L);
    } else if (strict.verdict == Verdict::Unexplained) {
      ++unexplained;
      EXPECT_NEAR(wide.friction, 1, 1e-12);
      right += std::any_of(wide.candidates.begin(), wide.candidates.end(),
                           [&](const Candidate& k) { return k.explains && k.best.link == c.contact.link; });
    }
  }
  EXPECT_GE(unexplained, 5);
  EXPECT_GE(right, unexplained - 1);
}

TEST(Sense, CandidatesThatExplain_AreOrderedByResidualAndPriorOfForces) {
  const auto sensor = Sensor::make(make_arm(kUr5));
  SenseWorkspace work(sensor);
  SenseResult result;
  SenseOptions options;
  options.plausible_force = 3;  // far less than the forces, so that the prior orders
  core::Random random(5, 0);
  int several = 0;
  for (int i = 0; i < 20; ++i) {
    const KnownCase c = make_random_case(*sensor, std::array{4, 5}, FrictionCone(1, 4), 10, random);
    sense(*sensor, {c.q, c.tau}, options, work, result);
    const double rho = std::pow(options.noise / *options.plausible_force, 2);
    double before = 0;
    int explaining = 0;
    for (const Candidate& candidate : result.candidates) {
      EXPECT_GE(candidate.objective, candidate.best.residual - 1e-12) << "the prior only adds";
      EXPECT_LE(candidate.objective, candidate.best.residual + rho * candidate.best.f_L.squaredNorm() + 1e-12)
          << "the best force of (4.5) is one of many";
      if (!candidate.explains) continue;
      EXPECT_GE(candidate.objective, before);
      before = candidate.objective;
      ++explaining;
    }
    several += explaining > 1;
  }
  EXPECT_GE(several, 5);
}

/// Three torques leave a contact on the forearm open by two numbers. The wrench at the base shows its line of action.
TEST(Sense, WrenchAtTheBase_FindsContactsBehindFewJoints) {
  SensorOptions on_forearm;
  on_forearm.links = {"arm/forearm_link"};
  const auto sensor = Sensor::make(make_arm(kUr5), on_forearm);
  SenseWorkspace work(sensor);
  SenseResult alone, with_base;
  core::Random random(11, 0);
  constexpr int kCases = 30;
  int found = 0, spread = 0;
  for (int i = 0; i < kCases; ++i) {
    const std::array<int, 1> links{0};
    KnownCases c = make_random_cases(*sensor, links, FrictionCone(1, 4), 10, 1, random);
    c.base.force_noise = c.base.moment_noise = 1e-3;
    SenseOptions options = noiseless();
    sense(*sensor, {.q = c.q, .tau = c.tau}, options, work, alone);
    sense(*sensor, {.q = c.q, .tau = c.tau, .base = &c.base}, options, work, with_base);
    if (with_base.candidates.empty() || alone.candidates.empty()) continue;
    const ContactPoint& best = with_base.candidates.front().best;
    found += (best.p_L - c.contacts[0].p_L).norm() < 0.01 && (best.f_L - c.contacts[0].f_L).norm() < 0.1;
    spread += (alone.candidates.front().best.p_L - c.contacts[0].p_L).norm() > 0.01;
  }
  EXPECT_GE(found, 27) << "of " << kCases;
  EXPECT_GE(spread, 20) << "torques alone would do: the test says nothing";
}

TEST(Sense, SameInput_GivesTheSameBits) {
  const auto sensor = Sensor::make(make_arm(kUr5));
  core::Random random(3, 0);
  const KnownCase c = make_random_case(*sensor, std::array{4, 5}, FrictionCone(1, 4), 10, random);
  SenseWorkspace work(sensor), other(sensor);
  SenseResult first, second;
  sense(*sensor, {c.q, c.tau}, {}, work, first);
  for (int i = 0; i < 2; ++i) {
    sense(*sensor, {c.q, c.tau}, {}, other, second);  // and a workspace that was used
    ASSERT_EQ(first.points.size(), second.points.size());
    for (std::size_t k = 0; k < first.points.size(); ++k) {
      EXPECT_EQ(first.points[k].p_L, second.points[k].p_L);
      EXPECT_EQ(first.points[k].residual, second.points[k].residual);
    }
  }
}

TEST(Sense, LastCycle_IsFoundAgainWithFewSamples) {
  const auto sensor = Sensor::make(make_arm(kUr5));
  SensorOptions few;
  few.samples = 1;
  const auto sparse = Sensor::make(sensor->model_ptr(), few);
  core::Random random(4, 0);
  SenseWorkspace work(sensor), sparse_work(sparse);
  SenseResult result, warm;
  int found = 0, before = 0;
  for (int i = 0; i < 20; ++i) {
    const KnownCase c = make_random_case(*sensor, std::array{4, 5}, FrictionCone(1, 4), 10, random);
    sense(*sensor, {c.q, c.tau}, noiseless(), work, result);
    if (!(distance_to_truth(result, c.contact) <= 0.01)) continue;
    ++before;
    const std::vector<ContactPoint> last = result.best_points();
    sense(*sparse, {c.q, c.tau, &last}, noiseless(), sparse_work, warm);
    found += distance_to_truth(warm, c.contact) <= 0.01;
  }
  EXPECT_GE(before, 15);
  EXPECT_EQ(found, before);
}

TEST(Sensor, LinksBehindFewJoints_AreSaidToLeaveContactsAmbiguous) {
  const auto sensor = Sensor::make(make_arm(kUr5));
  const auto has = [&](const std::string& note) {
    return std::find(sensor->notes().begin(), sensor->notes().end(), note) != sensor->notes().end();
  };
  EXPECT_TRUE(has("arm/shoulder_link: 1 joint before it, so that neither point nor force of a contact are unique"));
  EXPECT_TRUE(has("arm/upper_arm_link: 2 joints before it, so that neither point nor force of a contact are unique"));
  EXPECT_TRUE(has("arm/forearm_link: 3 joints before it, so that points of contact lie on curves or patches"));
  EXPECT_TRUE(std::none_of(sensor->notes().begin(), sensor->notes().end(),
                           [](const std::string& note) { return note.find("wrist_2_link: 5 joints") != std::string::npos; }));
}

/// Two turning tubes; the second carries a box that lies wholly inside it.
std::shared_ptr<const world::Model> make_arm_with_hidden_link() {
  const auto tube = [](const std::string& name) {
    return "<link name='" + name +
           "'><collision><origin xyz='0 0 0.15'/><geometry><cylinder radius='0.05' length='0.26'/></geometry></collision></link>";
  };
  const auto joint = [](const std::string& name, const std::string& parent, const std::string& child, const std::string& axis) {
    return "<joint name='" + name + "' type='revolute'><parent link='" + parent + "'/><child link='" + child +
           "'/><origin xyz='0 0 0.3'/><axis xyz='" + axis + "'/><limit lower='-2' upper='2' effort='50' velocity='1'/></joint>";
  };
  const std::string urdf =
      "<robot name='arm'>" + tube("base") + tube("upper") + tube("lower") + joint("a", "base", "upper", "0 0 1") +
      joint("b", "upper", "lower", "0 1 0") +
      "<link name='core'><collision><geometry><box size='0.01 0.01 0.01'/></geometry></collision></link>"
      "<joint name='f' type='fixed'><parent link='lower'/><child link='core'/><origin xyz='0 0 0.15'/></joint></robot>";
  return make_robot(urdf);
}

TEST(Sensor, LinkInsideAnother_IsLeftOutWithANote) {
  const auto model = make_arm_with_hidden_link();
  const auto sensor = Sensor::make(model);
  ASSERT_EQ(sensor->links().size(), 2u);
  EXPECT_EQ(sensor->link_name(0), "robot/upper");
  EXPECT_EQ(sensor->link_name(1), "robot/lower");
  EXPECT_NE(
      std::find(sensor->notes().begin(), sensor->notes().end(),
                "robot/core: 12 of its 12 triangles are hidden in the robot and none can be touched, so that no contact is looked for "
                "on it"),
      sensor->notes().end());
  SensorOptions asked_for;
  asked_for.links = {"robot/core"};
  EXPECT_EQ(stiction::test::message_of([&] { (void)Sensor::make(model, asked_for); }),
            "links: got 'robot/core', of whose 12 triangles 12 are hidden, expected links with a surface that can be touched");
}

TEST(Sense, BadInput_IsNamed) {
  using stiction::test::message_of;
  const auto sensor = make_iiwa();
  SenseWorkspace work(sensor);
  SenseResult result;
  const auto with = [&](const VectorXd& q, const VectorXd& tau, const SenseOptions& options) {
    return message_of([&] { sense(*sensor, {q, tau}, options, work, result); });
  };
  EXPECT_EQ(with(kQ1, kTau1.head(6), {}), "tau: got 6 numbers, expected 7");
  VectorXd broken = kTau1;
  broken[2] = std::nan("");
  EXPECT_EQ(with(kQ1, broken, {}), "tau[2]: got nan, expected a finite number");
  EXPECT_NE(with(kQ1.head(5), kTau1, {}), "no exception");
  const BaseWrench base;
  SenseOptions likely;
  likely.posterior = true;
  EXPECT_NE(
      message_of([&] { sense(*sensor, {.q = kQ1, .tau = kTau1, .base = &base}, likely, work, result); }).find("posterior: got true with"),
      std::string::npos);
  SenseOptions zero;
  zero.threshold = 0;
  EXPECT_EQ(with(kQ1, kTau1, zero), "threshold: got 0, expected a finite number > 0");
  SenseOptions wrong;
  wrong.friction_error = 1;
  EXPECT_EQ(with(kQ1, kTau1, wrong), "friction_error: got 1, expected a number in [0, 1)");
  wrong.friction_error = 0;
  wrong.plausible_force = 0;
  EXPECT_EQ(with(kQ1, kTau1, wrong), "plausible_force: got 0, expected a finite number > 0");
  const auto after = [&](ContactPoint point) {
    const std::vector<ContactPoint> last{point};
    return message_of([&] { sense(*sensor, {kQ1, kTau1, &last}, {}, work, result); });
  };
  EXPECT_EQ(after({}), fmt::format("last: got a contact on link -1 of {}, expected contacts of the same sensor", sensor->links().size()));
  EXPECT_NE(after({.link = 2}).find("last: got a contact on triangle -1 of "), std::string::npos);
  EXPECT_NE(after({.link = 2, .triangle = 1 << 30}).find("expected contacts of the same sensor"), std::string::npos);
  EXPECT_EQ(after({.link = 2, .triangle = 0, .p_L = {0, std::nan(""), 0}}),
            "last: got a contact at a point that is not finite, expected finite points");
  SensorOptions unknown;
  unknown.links = {"arm/link_9"};
  EXPECT_NE(message_of([&] { Sensor::make(sensor->model_ptr(), unknown); }).find("links: got 'arm/link_9', expected one of"),
            std::string::npos);
}

}  // namespace
}  // namespace stiction::sensing::test
