// Lengths and forces of a scene: closed forms, invariance, homogeneity, and what built-in tasks get.
#include "stiction/world/scales.hpp"

#include <gtest/gtest.h>

#include "stiction/core/overloaded.hpp"
#include "test_scenes.hpp"

namespace stiction::world::test {
namespace {

Scene one_object(const Shape& shape, ObjectJoint joint = ObjectJoint::Free) {
  Scene scene;
  ObjectSpec object = make_object("thing", joint);
  object.geometries[0].shape = shape;
  scene.objects.push_back(object);
  scene.fixed.push_back({.name = "floor", .X_WB = {}, .geometries = {{.name = "ground", .shape = HalfSpace{}, .X_BG = {}, .friction = 1}}});
  return scene;
}

Scale scale_of(const Scene& scene) { return Model::make(scene)->scales().object(0); }

/// The same scene in other units: lengths times s, masses times m.
Scene scaled(Scene scene, double s, double m) {
  for (ObjectSpec& object : scene.objects) {
    object.X_WP.p *= s;
    object.mass *= m;
    object.p_BCom *= s;
    object.inertia *= m * s * s;
    for (GeometrySpec& g : object.geometries) {
      g.X_BG.p *= s;
      std::visit(core::Overloaded{[s](Sphere& x) { x.radius *= s; }, [s](Box& x) { x.half_extents *= s; },
                                  [s](Capsule& x) { x.radius *= s, x.half_length *= s; },
                                  [s](Cylinder& x) { x.radius *= s, x.half_length *= s; }, [](HalfSpace&) {}, [](Mesh&) { FAIL(); }},
                 g.shape);
    }
  }
  return scene;
}

TEST(Scales, Box_LengthIsGeometricMeanOfEdges) {
  EXPECT_NEAR(scale_of(one_object(Box{{0.1, 0.05, 0.2}})).length, std::cbrt(0.2 * 0.1 * 0.4), 1e-15);
  EXPECT_NEAR(scale_of(one_object(Sphere{0.1})).length, 0.1 * std::sqrt(12.0 / 5.0), 1e-15);
}

TEST(Scales, PlanarBox_LengthIsThatOfEdgesInThePlane) {
  EXPECT_NEAR(scale_of(one_object(Box{{0.1, 5.0, 0.2}}, ObjectJoint::PlanarXZ)).length, std::sqrt(0.2 * 0.4),
              1e-12);  // moments in the plane are differences
  EXPECT_NEAR(scale_of(one_object(Box{{5.0, 0.1, 0.2}}, ObjectJoint::PlanarYZ)).length, std::sqrt(0.2 * 0.4), 1e-12);
}

TEST(Scales, ShapeTurnedAndMoved_LengthIsTheSame) {
  core::Random random(1, 2);
  Scene scene = one_object(Box{{0.1, 0.05, 0.2}});
  const double length = scale_of(scene).length;
  for (int k = 0; k < 20; ++k) {
    scene.objects[0].geometries[0].X_BG = random_pose(random);
    EXPECT_NEAR(scale_of(scene).length, length, 1e-12 * length);
  }
}

TEST(Scales, ObjectWithoutShapes_LengthIsThatOfItsInertia) {
  Scene scene = one_object(Box{{0.1, 0.05, 0.2}});
  const double m = scene.objects[0].mass;
  scene.objects[0].inertia = Eigen::Vector3d(0.05 * 0.05 + 0.04, 0.01 + 0.04, 0.01 + 0.05 * 0.05).asDiagonal();
  scene.objects[0].inertia *= m / 3;
  scene.objects[0].geometries.clear();
  EXPECT_NEAR(scale_of(scene).length, std::cbrt(0.2 * 0.1 * 0.4), 1e-14);
}

TEST(Scales, Weight_OnlyAlongTheMotion) {
  const double weight = 2 * 9.81;
  EXPECT_DOUBLE_EQ(scale_of(one_object(Sphere{0.1})).force, weight);
  EXPECT_DOUBLE_EQ(scale_of(one_object(Sphere{0.1}, ObjectJoint::PlanarXZ)).force, weight);
  Scene scene = make_zoo();  // soft robot, objects on joints at random places
  scene.objects = {make_object("flat", ObjectJoint::PlanarXY), make_object("slider", ObjectJoint::Slider),
                   make_object("hinge", ObjectJoint::Hinge)};
  scene.objects[1].axis = Eigen::Vector3d(0, 0.6, 0.8);
  scene.objects[2].axis = Eigen::Vector3d(0, 0.6, 0.8);
  scene.gravity = {0, 0, -9.81};
  const auto model = Model::make(scene);
  const Scales& scales = model->scales();
  EXPECT_GT(scales.softest_stiffness(), 0);
  EXPECT_DOUBLE_EQ(scales.object(0).force, 0.01 * scales.softest_stiffness() * scales.object(0).length);
  EXPECT_NEAR(scales.object(1).force, 0.8 * weight, 1e-14 * weight);
  EXPECT_NEAR(scales.object(2).force, 0.6 * weight, 1e-14 * weight);
}

TEST(Scales, DryFriction_IsAForceThatAnObjectNeeds) {
  Scene scene = one_object(Sphere{0.1}, ObjectJoint::Slider);
  scene.objects[0].axis = Eigen::Vector3d::UnitX();
  scene.objects[0].joint_friction = 3;
  EXPECT_DOUBLE_EQ(scale_of(scene).force, 3) << "level: friction alone";
  scene.objects[0].axis = Eigen::Vector3d::UnitZ();
  EXPECT_DOUBLE_EQ(scale_of(scene).force, 2 * 9.81) << "upright: the weight is more";
  scene.objects[0].joint = ObjectJoint::Hinge;
  const Scale hinge = scale_of(scene);
  EXPECT_DOUBLE_EQ(hinge.force, 3 / hinge.length) << "an upright hinge: at the lever L";
}

TEST(Scales, NearlyLevelAxis_HasNoWeight) {
  Scene scene = make_zoo();
  scene.gravity = {0, 0, -9.81};
  scene.objects = {make_object("slider", ObjectJoint::Slider)};
  const auto force_at = [&](double slope) {
    scene.objects[0].axis = Eigen::Vector3d(std::cos(slope), 0, std::sin(slope));
    return scale_of(scene).force;
  };
  EXPECT_EQ(force_at(3e-4), force_at(0)) << "an axis that a file rounds";
  EXPECT_NEAR(force_at(0.02), 2 * 9.81 * std::sin(0.02), 1e-12);
}

TEST(Scales, WhatHangsOnAnObject_CountsForItsForce) {
  Scene scene = make_linked();
  scene.gravity = {0, 0, -9.81};
  const auto model = Model::make(scene);
  const int drawer = model->object_index("drawer"), hinge = model->object_index("hinge");
  const auto& objects = model->objects();
  EXPECT_DOUBLE_EQ(objects[static_cast<std::size_t>(hinge)].carried_mass, 6);
  EXPECT_DOUBLE_EQ(objects[static_cast<std::size_t>(drawer)].carried_mass, 4);
  EXPECT_GT(model->scales().object(hinge).force, 0);
}

TEST(Scales, HeavyBystander_ChangesNothingElse) {
  Scene scene = one_object(Box{{0.1, 0.05, 0.2}});
  const Scale alone = scale_of(scene);
  ObjectSpec stone = make_object("stone", ObjectJoint::Free);
  stone.mass = 1e4;
  stone.inertia *= 5e3;
  stone.geometries[0].shape = Sphere{3};
  scene.objects.push_back(stone);
  const auto model = Model::make(scene);
  const Scales& scales = model->scales();
  EXPECT_EQ(scales.object(0).force, alone.force);
  EXPECT_EQ(scales.object(0).length, alone.length);
  EXPECT_EQ(scales.robots().force, alone.force);
  for (std::size_t i = 0; i < model->pairs().size(); ++i) {
    const auto& pair = model->pairs()[i];
    const auto body = [&](int g) { return model->geometries()[static_cast<std::size_t>(g)].body; };
    const bool of_stone = body(pair.geometry_a) != 0 && body(pair.geometry_b) != 0;
    EXPECT_EQ(scales.pair(static_cast<int>(i)).force, of_stone ? scales.object(1).force : alone.force);
  }
}

TEST(Scales, OtherUnits_LengthsAndForcesFollowExactly) {
  for (Scene scene : {one_object(Box{{0.1, 0.05, 0.2}}), one_object(Sphere{0.03}, ObjectJoint::PlanarYZ),
                      one_object(Capsule{0.02, 0.3}, ObjectJoint::PlanarXZ)}) {
    scene.objects[0].geometries[0].X_BG.p = Eigen::Vector3d(0.01, -0.02, 0.03);
    const auto model = Model::make(scene);
    for (const double s : {0.015625, 0.5, 2.0, 64.0}) {
      for (const double m : {0x1p-20, 0x1p-3, 8.0, 0x1p+13}) {
        const auto other = Model::make(scaled(scene, s, m));
        EXPECT_EQ(other->scales().object(0).length, s * model->scales().object(0).length);
        EXPECT_EQ(other->scales().object(0).force, m * model->scales().object(0).force);
        EXPECT_EQ(other->scales().kappa(0), model->scales().kappa(0) / (s * m));
        EXPECT_EQ(other->scales().gamma(0), s * s * model->scales().gamma(0));
      }
    }
  }
}

/// What tasks were given by hand before thresholds followed from sizes and weights: gap [m], κ [1/J] (of the ball for 10 N, 20 times its weight), γ [m²].
TEST(Scales, BuiltInTasks_ThresholdsAreNearThoseChosenByHand) {
  struct Row {
    const char* task;
    double gap, kappa, gamma;
  };
  for (const Row& row : {Row{"allegro_ball", 1e-3, 20 * 50, 1e-4}, Row{"allegro_cube", 1e-3, 500, 1e-4},
                         Row{"allegro_plate", 1e-3, 500, 1e-4}, Row{"allegro_pen", 1e-3, 500, 1e-4}, Row{"iiwa_bimanual", 1e-3, 100, 1e-3},
                         Row{"iiwa_bimanual_box", 2e-3, 50, 3e-3}, Row{"planar_pushing", 2e-3, 100, 1e-2}}) {
    const auto model = load_task(row.task);
    const Scales& scales = model->scales();
    constexpr double kFactor = 6;  // sizes from 0.06 m to 1 m had one gap
    const auto near = [&](double got, double by_hand, const char* what) {
      EXPECT_LT(got, kFactor * by_hand) << row.task << ' ' << what;
      EXPECT_GT(got, by_hand / kFactor) << row.task << ' ' << what;
    };
    near(share::kContact * scales.object(0).length, row.gap, "gap");
    near(scales.kappa(0), row.kappa, "kappa");
    near(scales.gamma(0), row.gamma, "gamma");
  }
}

}  // namespace
}  // namespace stiction::world::test
