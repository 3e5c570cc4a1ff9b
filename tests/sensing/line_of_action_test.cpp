#include "sensing_baselines/line_of_action.hpp"

#include <gtest/gtest.h>

#include "robots.hpp"
#include "stiction/core/invalid_input.hpp"
#include "stiction/sensing/scenario.hpp"

namespace stiction::sensing::test {
namespace {

using namespace bench;

constexpr double kThreshold = 1e-9;  // [N m]: torques here are exact

std::shared_ptr<const Sensor> make_sensor() {
  static const auto sensor = Sensor::make(make_arm(kUr5));
  return sensor;
}

TEST(LineOfAction, ForceOnTheLastLink_LineGoesThroughItsPoint) {
  const auto sensor = make_sensor();
  const int last[] = {sensor->link_index("arm/wrist_3_link")};
  core::Random random(1, 0);
  int found = 0;
  for (int trial = 0; trial < 200; ++trial) {
    const KnownCase c = make_random_case(*sensor, last, FrictionCone(0.5, 0), 10, random);
    const LineOfAction out = find_line_of_action(*sensor, c.q, c.tau, kThreshold);
    if (out.verdict == LineVerdict::RankDeficient) continue;  // near a singular posture
    ASSERT_EQ(out.verdict, LineVerdict::Found) << to_string(out.verdict);
    double nearest = std::numeric_limits<double>::infinity();
    for (const ContactPoint& point : out.points) {
      ASSERT_EQ(point.link, last[0]);
      ASSERT_LT(point.f_L.dot(point.n_L), 0);
      nearest = std::min(nearest, (point.p_L - c.contact.p_L).norm());
      EXPECT_LE((point.f_L - c.contact.f_L).norm(), 1e-6 * c.contact.f_L.norm());  // 1e-15 over the tolerance of the rank, with a margin
    }
    EXPECT_LE(nearest, 1e-6 * sensor->links()[static_cast<std::size_t>(last[0])].surface.size);
    ++found;
  }
  EXPECT_GT(found, 190);
}

TEST(LineOfAction, LinkBehindFiveJoints_WrenchIsNotUnique) {
  const auto sensor = make_sensor();
  const int link[] = {sensor->link_index("arm/wrist_2_link")};
  core::Random random(2, 0);
  const KnownCase c = make_random_case(*sensor, link, FrictionCone(0.5, 0), 10, random);
  EXPECT_EQ(find_line_of_action(*sensor, c.q, c.tau, kThreshold).verdict, LineVerdict::RankDeficient);
}

TEST(LineOfAction, NoTorque_IsBelowTheThreshold) {
  const auto sensor = make_sensor();
  const world::Model& model = sensor->model();
  Eigen::VectorXd q(model.n_q());
  q << 0.3, -1.2, 1.6, -1.9, -1.5, 0.2;
  EXPECT_EQ(find_line_of_action(*sensor, q, Eigen::VectorXd::Zero(6), kThreshold).verdict, LineVerdict::BelowThreshold);
  EXPECT_TRUE(find_line_of_action(*sensor, q, Eigen::VectorXd::Zero(6), kThreshold).points.empty());
}

TEST(LineOfAction, BadInput_NamesTheArgument) {
  const auto sensor = make_sensor();
  const Eigen::VectorXd q = Eigen::VectorXd::Zero(6);
  const auto message = [&](const Eigen::VectorXd& tau, double epsilon) -> std::string {
    try {
      (void)find_line_of_action(*sensor, q, tau, epsilon);
    } catch (const core::InvalidInput& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_NE(message(Eigen::VectorXd::Zero(5), 0.1).find("tau"), std::string::npos);
  EXPECT_NE(message(Eigen::VectorXd::Zero(6), 0).find("epsilon"), std::string::npos);
}

}  // namespace
}  // namespace stiction::sensing::test
