// Models of the three tasks against hand-computed and independently computed numbers.
#include "stiction/world/model.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "support/paths.hpp"

namespace stiction::world {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

std::shared_ptr<const Model> load(const std::string& task) {
  return Model::make(load_scene(stiction::test::source_dir() / "tasks" / (task + ".yaml")));
}

VectorXd allegro_anchor(const Model& model) {
  VectorXd q = model.neutral();
  q.head<3>() = Vector3d(-0.081, 0.001, 0.071);
  q.tail<16>() << 0.03501504, 0.75276565, 0.74146232, 0.83261002, -0.1438725, 0.74696812, 0.61908827, 0.70064279, -0.06922541, 0.78533142,
      0.82942863, 0.90415436, 0.63256269, 1.02378254, 0.64089555, 0.82444782;
  return q;
}

/// World position of the centre of a geometry.
Vector3d center(const Model& model, const VectorXd& q, std::string_view name) {
  KinematicsWorkspace work(model);
  Kinematics kinematics;
  calc_kinematics(model, q, work, kinematics);
  for (const Geometry& g : model.geometries()) {
    if (g.name == name) return kinematics.X_WB[static_cast<std::size_t>(g.body)] * g.p_BCenter;
  }
  ADD_FAILURE() << "no geometry " << name;
  return Vector3d::Constant(std::nan(""));
}

double radius(const Model& model, std::string_view name) {
  for (const Geometry& g : model.geometries()) {
    if (g.name == name) return g.bounding_radius;
  }
  return std::nan("");
}

TEST(AllegroBall, Sizes_AreThoseOfTheThesis) {
  const auto model = load("allegro_ball");
  EXPECT_EQ(model->n_vu(), 6);
  EXPECT_EQ(model->n_qu(), 7);
  EXPECT_EQ(model->n_a(), 16);
  EXPECT_EQ(model->n_v(), 22);
  EXPECT_EQ(model->n_q(), 23);
  EXPECT_EQ(model->geometries().size(), 20u);
  EXPECT_EQ(model->pairs().size(), 160u);  // three more never meet
  int with_ball = 0;
  for (const Pair& pair : model->pairs()) with_ball += pair.geometry_a == 0;
  EXPECT_EQ(with_ball, 19);
  EXPECT_FALSE(model->planar_axis().has_value());
  EXPECT_EQ(model->joint_index("joint_12"), 12);
  EXPECT_EQ(model->joint_index("hand/joint_3"), 3);
  EXPECT_EQ(model->lower()[12], 0.263);
  EXPECT_EQ(model->neutral()[7 + 12], 0.263) << "the thumb cannot stand at 0";
  ASSERT_EQ(model->robots()[0].chains.size(), 4u);
  for (int finger = 0; finger < 4; ++finger) {
    const std::vector<int> expected{6 + 4 * finger, 7 + 4 * finger, 8 + 4 * finger, 9 + 4 * finger};
    EXPECT_EQ(model->robots()[0].chains[static_cast<std::size_t>(finger)], expected);
  }
}

TEST(AllegroBall, AnchorConfiguration_HasPublishedSphereCentresAndGaps) {
  const auto model = load("allegro_ball");
  const VectorXd q = allegro_anchor(*model);
  struct Anchor {
    const char* name;
    Vector3d p;
    double gap;  // [m] to the ball
  };
  const Anchor anchors[] = {
      {"hand/link_3/ball_1", {-0.1334, 0.0503, 0.0946}, 3.76e-3},    {"hand/link_7/ball_1", {-0.1468, -0.0140, 0.0968}, 0.26e-3},
      {"hand/link_11/ball_1", {-0.1240, -0.0526, 0.0919}, -0.20e-3}, {"hand/link_15/ball_2", {-0.0559, 0.0638, 0.0968}, 0.38e-3},
      {"hand/link_5/ball_2", {-0.1370, -0.0033, 0.0229}, 1.01e-3},   {"hand/link_5/ball_1", {-0.1180, -0.0008, 0.0054}, 2.34e-3},
  };
  const Vector3d ball = center(*model, q, "ball/ball");
  for (const Anchor& anchor : anchors) {
    const Vector3d p = center(*model, q, anchor.name);
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(p[k], anchor.p[k], 0.6e-4) << anchor.name << " axis " << k;  // printed to 0.1 mm
    EXPECT_NEAR((p - ball).norm() - radius(*model, anchor.name) - 0.06, anchor.gap, 0.6e-5) << anchor.name;
  }
  EXPECT_LT((center(*model, q, "hand/hand_root/palm") - Vector3d(-0.0475, 0, -0.0093)).norm(), 1e-9);
  EXPECT_LT((center(*model, q, "hand/link_14/ball_1") - Vector3d(-0.0255, 0.0698, 0.0427)).norm(), 1e-4);
  EXPECT_LT((center(*model, q, "hand/link_15/ball_1") - Vector3d(-0.0415, 0.0734, 0.0774)).norm(), 1e-4);
}

TEST(AllegroBall, ZeroAngles_HavePublishedFingertips) {
  const auto model = load("allegro_ball");
  VectorXd q = model->neutral();
  q.tail<16>().setZero();
  const std::pair<const char*, Vector3d> tips[] = {{"hand/link_3/ball_1", {-0.2284, 0.0553, 0}},
                                                   {"hand/link_7/ball_1", {-0.2312, 0, 0}},
                                                   {"hand/link_11/ball_1", {-0.2284, -0.0553, 0}},
                                                   {"hand/link_15/ball_2", {-0.0090, 0.1674, -0.0132}}};
  for (const auto& [name, p] : tips) EXPECT_LT((center(*model, q, name) - p).norm(), 1e-4) << name;
}

TEST(PlanarHand, SizesPairsAndGaps_AreThoseOfTheThesis) {
  const auto model = load("planar_hand");
  EXPECT_EQ(model->n_q(), 7);
  EXPECT_EQ(model->n_v(), 7);
  EXPECT_EQ(model->n_vu(), 3);
  EXPECT_EQ(model->geometries().size(), 13u);
  EXPECT_EQ(model->pairs().size(), 51u);
  EXPECT_EQ(model->planar_axis(), 0);
  EXPECT_EQ(model->stiffness(), (VectorXd(4) << 50, 25, 50, 25).finished());
  EXPECT_NEAR(model->pairs()[0].friction, 0.8, 1e-15);
  EXPECT_EQ(model->robots()[0].chains, (std::vector<std::vector<int>>{{3, 4}}));
  EXPECT_EQ(model->robots()[1].chains, (std::vector<std::vector<int>>{{5, 6}}));
  VectorXd q(7);
  constexpr double a = std::numbers::pi / 4;
  q << 0, 0.35, 0, -a, -a, a, a;
  const Vector3d ball = center(*model, q, "ball/ball");
  const auto gap = [&](const char* name) { return (center(*model, q, name) - ball).norm() - 0.3; };
  EXPECT_NEAR(gap("left/link_2/ball_0"), 14.4e-3, 6e-5);
  EXPECT_NEAR(gap("left/link_2/ball_1"), 18.3e-3, 6e-5);
  EXPECT_NEAR(gap("left/link_1/ball_1"), 19.0e-3, 6e-5);
  EXPECT_NEAR(gap("right/link_2/ball_0"), gap("left/link_2/ball_0"), 1e-15);
}

TEST(PlanarPushing, ModelHasPublishedNumbers) {
  const auto model = load("planar_pushing");
  EXPECT_EQ(model->n_v(), 5);
  ASSERT_EQ(model->pairs().size(), 1u);
  EXPECT_NEAR(model->pairs()[0].friction, 2.0 / 3.0, 1e-15);
  EXPECT_EQ(model->planar_axis(), 0);
  EXPECT_EQ(model->lower()[0], -std::numeric_limits<double>::infinity());
  EXPECT_EQ(model->dofs()[2].name, "box/theta");
  EXPECT_EQ(model->dofs()[3].name, "hand/y");
  EXPECT_EQ(model->supports(), (std::vector<std::vector<int>>{{0, 1, 2, 3, 4}}));
}

}  // namespace
}  // namespace stiction::world
