#include "stiction/planning/thesis/packing.hpp"

#include <cmath>
#include <numbers>

#include "planning/systems.hpp"
#include "stiction/core/invalid_input.hpp"
#include "support/message_of.hpp"

namespace stiction::planning::test {
namespace {

/// A node of the planar hand whose object reaches the ellipsoid (c, B_uB_uᵀ).
NodeRecord node(const Eigen::Vector3d& c, const Eigen::Matrix3d& B) {
  NodeRecord out;
  out.q.setZero(7);
  out.q.head<3>() = c;
  out.c_u = c;
  out.B_u.setZero(3, 4);
  out.B_u.leftCols<3>() = B;
  return out;
}

std::vector<world::SampleBox> unit_cube() { return {{0, Eigen::Vector3d::Constant(-0.5), Eigen::Vector3d::Constant(0.5)}}; }

/// Four standard errors of a ratio.
double spread(double ratio, int samples) { return 4 * std::sqrt(ratio * (1 - ratio) / samples); }

TEST(Packing, Ellipsoids_HaveTheirVolume) {
  const auto model = load_model("planar_hand");
  Eigen::Matrix3d B;
  B << 0.2, 0.05, 0, 0, 0.1, 0.03, 0.02, 0, 0.15;
  const PackingOptions options{.threshold = 1.5, .gamma = 1e-12, .samples = 20000};
  // V = 4/3 π η^{3/2} det B; the second is elsewhere, the third outside the cube, the fourth where the first is.
  const double volume = 4.0 / 3 * std::numbers::pi * std::pow(1.5, 1.5) * B.determinant();
  const std::vector<NodeRecord> tree = {node({-0.2, 0, 0.1}, B), node({0.25, 0.1, -0.2}, 0.5 * B), node({3, 0, 0}, 0.5 * B),
                                        node({-0.2, 0, 0.1}, B)};
  const Eigen::VectorXd ratio = calc_packing_ratio(*model, unit_cube(), tree, options);
  ASSERT_EQ(ratio.size(), 4);
  EXPECT_NEAR(ratio[0], volume, spread(volume, options.samples));
  EXPECT_NEAR(ratio[1], 1.125 * volume, spread(1.125 * volume, options.samples));
  EXPECT_EQ(ratio[2], ratio[1]);
  EXPECT_EQ(ratio[3], ratio[1]);
}

TEST(Packing, AngleIsWrapped) {
  const auto model = load_model("planar_hand");
  const std::vector<world::SampleBox> boxes = {
      {0, Eigen::Vector3d(0, 0, -std::numbers::pi), Eigen::Vector3d(0, 0, std::numbers::pi)}};  // all angles at one place
  const PackingOptions options{.threshold = 1, .gamma = 1e-12, .samples = 20000};
  const double half = 0.25 * std::numbers::pi;  // of the angles on either side of the seam
  const Eigen::VectorXd ratio = calc_packing_ratio(*model, boxes, {node({0, 0, 3}, half * Eigen::Matrix3d::Identity())}, options);
  EXPECT_NEAR(ratio[0], 0.25, spread(0.25, options.samples));
}

TEST(Packing, OfAGrownTree_RisesAndFollowsTheSeed) {
  const PlanningProblem problem = hand_problem();
  PlannerOptions options = hand_options();
  options.thesis.emplace().stop_at_goal = false;
  options.max_iterations = 200;
  PlanResult result;
  ASSERT_EQ(plan(problem, options, {}, result), core::Status::MaxIterations);
  ASSERT_EQ(static_cast<long>(result.records.size()), result.nodes);
  for (std::size_t i = 1; i < result.records.size(); ++i) {
    EXPECT_LT(result.records[i].parent, static_cast<int>(i));
    EXPECT_GE(result.records[i].iteration, result.records[i - 1].iteration);
  }
  const Eigen::VectorXd ratio = calc_packing_ratio(*problem.model, options.sample_boxes, result.records);
  for (Eigen::Index i = 1; i < ratio.size(); ++i) EXPECT_GE(ratio[i], ratio[i - 1]);
  EXPECT_GT(ratio.tail(1)[0], ratio[0]);
  EXPECT_EQ(ratio, calc_packing_ratio(*problem.model, options.sample_boxes, result.records));
  EXPECT_NE(ratio, calc_packing_ratio(*problem.model, options.sample_boxes, result.records, {.seed = 1}));
}

TEST(Packing, BadOptions_NameTheField) {
  const auto model = load_model("planar_hand");
  const auto message = [&](const PackingOptions& o) {
    return stiction::test::message_of([&] { (void)calc_packing_ratio(*model, unit_cube(), {}, o); });
  };
  EXPECT_EQ(message({.threshold = 0}), "packing.threshold: got 0, expected a finite number > 0");
  EXPECT_EQ(message({.samples = 0}), "packing.samples: got 0, expected at least 1");
}

}  // namespace
}  // namespace stiction::planning::test
