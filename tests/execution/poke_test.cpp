#include "stiction/execution/contact_control/poke.hpp"

#include <gtest/gtest.h>

#include <filesystem>

#include "stiction/tasks/sensing_scenario_file.hpp"
#include "support/message_of.hpp"
#include "support/paths.hpp"

namespace stiction::execution::test {
namespace {

constexpr const char* kScene = R"(
scene: {robots: [{name: arm, urdf: package://example-robot-data/robots/ur_description/urdf/ur5_robot.urdf}]}
sensing: {friction: 0.5, noise: 0.02, links: ["arm/wrist_*"], samples: 200}
joints: {shoulder_lift_joint: -1.2, elbow_joint: 1.6, wrist_1_joint: -1.97, wrist_2_joint: -1.57}
)";

sensing::Scenario parse(const std::string& poke) {
  const std::vector<std::filesystem::path> packages{stiction::test::package_dir()};
  return tasks::parse_sensing_scenario(kScene + poke, stiction::test::source_dir(), packages);
}

constexpr const char* kQuiet = R"(
poke:
  duration: 1
  pushes: [{link: arm/wrist_2_link, point: [0.014, -0.057, 0.072], force: 20, begin: 0.3, duration: 0.4}]
  observer: {noise: 0}
)";

TEST(Poke, TorquesOfAnArmAtRest_AreThoseOfThePush) {
  sensing::Scenario scenario = parse(kQuiet);
  std::string message;
  ASSERT_EQ(simulate_poke(scenario, message), core::Status::Solved) << message;
  const sensing::Series& series = scenario.series;
  ASSERT_EQ(series.times.size(), 50u);
  EXPECT_NEAR(series.times.back(), 1, 1e-9);
  ASSERT_EQ(series.pushed.size(), 50u);
  EXPECT_TRUE(series.pushed[14].empty());
  EXPECT_EQ(series.pushed[15], std::vector{0});
  EXPECT_EQ(series.pushed[34], std::vector{0});
  EXPECT_TRUE(series.pushed[35].empty());
  EXPECT_LT(series.tau.col(10).cwiseAbs().maxCoeff(), 0.01);
  const auto& model = scenario.sensor->model();
  const auto& contact = scenario.contacts[0];
  const int body = scenario.sensor->links()[static_cast<std::size_t>(contact.link)].surface.body;
  const Eigen::VectorXd expected =
      sensing::calc_contact_torque(model, sensing::place_robots(model, series.q.col(34)), body, contact.p_L, contact.f_L);
  EXPECT_GT(expected.cwiseAbs().maxCoeff(), 1);
  EXPECT_LT((series.tau.col(34) - expected).cwiseAbs().maxCoeff(), 0.03 * expected.cwiseAbs().maxCoeff())
      << "0.4 s are forty times the lag";
  EXPECT_TRUE(scenario.contacts_at(10).empty());
  EXPECT_EQ(scenario.contacts_at(20).size(), 1u);
}

TEST(Poke, PushOfAnArmThatMoves_IsFound) {
  sensing::Scenario scenario = parse(R"(
poke:
  end: {shoulder_pan_joint: 0.4, elbow_joint: 1.4}
  duration: 1
  pushes: [{link: arm/wrist_2_link, point: [0.014, -0.057, 0.072], force: 25, begin: 0.3, duration: 0.4}]
  observer: {noise: 0.01, seed: 3}
)");
  std::string message;
  ASSERT_EQ(simulate_poke(scenario, message), core::Status::Solved) << message;
  sensing::SenseWorkspace work(scenario.sensor);
  sensing::SenseResult result;
  int found = 0, quiet = 0;
  for (std::size_t i = 0; i < scenario.series.times.size(); ++i) {
    const auto column = static_cast<Eigen::Index>(i);
    const Eigen::VectorXd q = sensing::place_robots(scenario.sensor->model(), scenario.series.q.col(column)),
                          tau = scenario.series.tau.col(column);
    sensing::sense(*scenario.sensor, {q, tau}, scenario.options, work, result);
    quiet += i > 5 && i < 15 && result.verdict == sensing::Verdict::BelowThreshold;
    if (i < 20 || i >= 35) continue;
    for (const sensing::Candidate& candidate : result.candidates) {
      if (!candidate.explains || sensing::calc_distance(result, candidate, scenario.contacts[0]) > 0.02) continue;
      ++found;
      break;
    }
  }
  EXPECT_GE(quiet, 8);
  EXPECT_GE(found, 12) << "of 15 moments";
}

TEST(Poke, PushesAtTheSameTime_AddUpInTorquesAndUnderTheBase) {
  const std::vector<std::filesystem::path> packages{stiction::test::package_dir()};
  sensing::Scenario scenario = tasks::parse_sensing_scenario(R"(
scene: {robots: [{name: arm, urdf: package://example-robot-data/robots/ur_description/urdf/ur5_robot.urdf}]}
sensing: {friction: 0.5, noise: 0.02, samples: 200, max_contacts: 2}
joints: {shoulder_lift_joint: -1.2, elbow_joint: 1.6, wrist_1_joint: -1.97, wrist_2_joint: -1.57}
base_wrench: {force_noise: 1.0e-9, moment_noise: 1.0e-9}
poke:
  duration: 1
  pushes:
    - {link: arm/upper_arm_link, point: [0.06, 0, 0.2], force: 20, begin: 0.2, duration: 0.6}
    - {link: arm/wrist_3_link, point: [0.05, 0.06, 0], force: 15, begin: 0.4, duration: 0.5}
  observer: {noise: 0}
)",
                                                             stiction::test::source_dir(), packages);
  std::string message;
  ASSERT_EQ(simulate_poke(scenario, message), core::Status::Solved) << message;
  const sensing::Series& series = scenario.series;
  EXPECT_EQ(series.pushed[15], std::vector{0});
  EXPECT_EQ(series.pushed[39], (std::vector{0, 1}));
  EXPECT_EQ(series.pushed[42], std::vector{1});
  ASSERT_EQ(series.base.size(), series.times.size());
  EXPECT_LT(series.base[5].force_W.norm(), 1e-7);
  const auto contacts = scenario.contacts_at(39);
  ASSERT_EQ(contacts.size(), 2u);
  Eigen::VectorXd tau;
  sensing::BaseWrench base;
  sensing::calc_known_rows(*scenario.sensor, sensing::place_robots(scenario.sensor->model(), series.q.col(39)), contacts, tau, base);
  EXPECT_LT((series.tau.col(39) - tau).cwiseAbs().maxCoeff(), 0.03 * tau.cwiseAbs().maxCoeff()) << "0.4 s after the last push began";
  // Forces stay in the world, and the links give way a little under them.
  EXPECT_LT((series.base[39].force_W - base.force_W).norm(), 0.03 * base.force_W.norm());
  EXPECT_LT((series.base[39].moment_W - base.moment_W).norm(), 0.03 * base.moment_W.norm());
  EXPECT_GT(base.force_W.norm(), 5);
}

TEST(Poke, Mistakes_AreNamed) {
  using stiction::test::message_of;
  const auto message = [](const std::string& poke) { return message_of([&] { (void)parse(poke); }); };
  EXPECT_NE(message("torques: [0, 0, 0, 0, 0, 0]\npoke: {duration: 1, pushes: []}")
                .find("torques: got 'torques' beside 'poke', expected one of the two"),
            std::string::npos);
  EXPECT_NE(message("poke: {duration: 0, pushes: []}").find("poke.duration"), std::string::npos);
  const std::string push = "{link: arm/wrist_2_link, point: [0, -0.06, 0.07], force: 20, begin: 0.3, duration: 0.4}";
  EXPECT_NE(message("poke: {duration: 1, pushes: [" + push + ", " + push + "]}")
                .find("pushes[1].begin: got 0.3 s, when 2 pushes act, expected at most sensing.max_contacts at the same time, 1"),
            std::string::npos)
      << message("poke: {duration: 1, pushes: [" + push + ", " + push + "]}");
  EXPECT_NE(message("poke: {duration: 1, pushes: [], observer: {lag: 1}}").find("lag"), std::string::npos);
}

}  // namespace
}  // namespace stiction::execution::test
