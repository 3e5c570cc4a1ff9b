#include <fmt/format.h>

#include "simulation/scenes.hpp"

namespace stiction::simulation::test {
namespace {

using core::Status;
using Eigen::Vector3d;
using world::ObjectJoint;

/// A flat block on a slope of friction μ whose angle has the tangent `ratio` μ. The axes of W lie along the slope: z normal, x downhill.
struct Slope {
  static constexpr double kMass = 0.5;

  Slope(double mu, double ratio) : theta(std::atan(ratio * mu)), rig(make_scene(mu, theta)) {
    q0.setZero();
    q0[2] = 0.015;
    q0[6] = 1;
  }

  static world::Scene make_scene(double mu, double theta) {
    world::Scene scene = empty_scene(kG * Vector3d(std::sin(theta), 0, -std::cos(theta)));
    scene.objects.push_back(solid(ObjectJoint::Free, world::Box{Vector3d(0.05, 0.05, 0.015)}, kMass, mu));
    scene.fixed.push_back(ground(mu));
    return scene;
  }

  double theta;
  Rig rig;
  Eigen::VectorXd q0{7};
};

TEST(Contact, SlopeTwoPercentBelowFriction_Sticks) {
  for (const double mu : {0.2, 0.5, 1.0}) {
    Slope s(mu, 0.98);
    ASSERT_EQ(s.rig.hold(s.q0, {}, 1.0), Status::Solved) << s.rig.result.message;
    const Eigen::Index half = s.rig.result.q.cols() / 2;
    const double creep =
        (s.rig.q_end() - s.rig.result.q.col(half)).head<3>().norm() / (1.0 - s.rig.result.times[static_cast<std::size_t>(half)]);
    EXPECT_LT(creep, 1e-4) << "μ = " << mu;
    const PairForce force = s.rig.force();
    EXPECT_NEAR(force.normal, s.kMass * kG * std::cos(s.theta), 1e-3 * s.kMass * kG);
    EXPECT_NEAR(force.tangential, s.kMass * kG * std::sin(s.theta), 1e-3 * s.kMass * kG);
    EXPECT_NEAR(force.force_W.x(), -s.kMass * kG * std::sin(s.theta), 1e-3 * s.kMass * kG) << "acts on the block, uphill";
  }
}

TEST(Contact, SlopeTwoPercentAboveFriction_SlidesWithTheAccelerationOfCoulomb) {
  for (const double mu : {0.2, 0.5, 1.0}) {
    for (const double ratio : {1.02, 1.1, 1.5}) {
      Slope s(mu, ratio);
      ASSERT_EQ(s.rig.hold(s.q0, {}, 1.0), Status::Solved) << s.rig.result.message;
      // From 0.2 s on: the onset is smooth and loses a few mm/s of friction (theory: "Contacts").
      const SimulationResult& r = s.rig.result;
      const Eigen::Index from = 20;
      ASSERT_NEAR(r.times[from], 0.2, 1e-9);
      const double got = (s.rig.v_end()[0] - r.v(0, from)) / (1.0 - 0.2);
      const double coulomb = kG * (std::sin(s.theta) - mu * std::cos(s.theta));
      EXPECT_NEAR(got, coulomb, 0.02 * coulomb) << "μ = " << mu << ", ratio " << ratio;
      EXPECT_NEAR(r.v(0, from), coulomb * 0.2, 0.005);
      EXPECT_LT(r.q.row(2).maxCoeff() - 0.015, ratio < 1.3 ? 5e-5 : 2e-3) << "hops";
    }
  }
}

/// On ground and at rest: force is weight and penetration what (1 − d) a T² says, for every shape.
TEST(Contact, ObjectAtRest_IsCarriedByItsWeightAndDoesNotSinkIn) {
  Eigen::Matrix3Xd corners(3, 8);
  for (int i = 0; i < 8; ++i) corners.col(i) = 0.05 * Vector3d(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1);
  const world::Mesh cube{std::make_shared<const world::ConvexMesh>(world::make_convex_hull(corners))};
  const std::pair<world::Shape, double> shapes[] = {{world::Sphere{0.06}, 0.06},
                                                    {world::Box{Vector3d(0.1, 0.05, 0.02)}, 0.02},
                                                    {world::Cylinder{0.05, 0.1}, 0.1},
                                                    {world::Capsule{0.05, 0.1}, 0.15},
                                                    {cube, 0.05}};
  for (const auto& [shape, height] : shapes) {
    for (const double mass : {0.1, 5.0}) {
      world::Scene scene = empty_scene({0, 0, -10});
      scene.objects.push_back(solid(ObjectJoint::Free, shape, mass, 0.8));
      scene.fixed.push_back(ground(0.8));
      Rig rig(scene);
      Eigen::VectorXd q0(7);
      q0 << 0, 0, height, 0, 0, 0, 1;
      ASSERT_EQ(rig.hold(q0, {}, 0.5), Status::Solved) << rig.result.message;
      EXPECT_NEAR(rig.force().normal, 10 * mass, 1e-3 * 10 * mass) << world::shape_name(shape);
      EXPECT_LT(rig.result.max_depth, 1e-4) << world::shape_name(shape);
      EXPECT_GT(rig.force().depth, 0);
    }
  }
}

/// A world in which objects are heavier than they are known to be is that of a scene with this mass and inertia, to the last bit.
TEST(Contact, MassScale_IsTheSceneWithHeavierObjects) {
  world::Scene scene = empty_scene({0, 0, -10});
  scene.objects.push_back(solid(ObjectJoint::Free, world::Box{Vector3d(0.1, 0.05, 0.02)}, 0.4, 0.8));
  scene.objects[0].inertia = Vector3d(1e-3, 2e-3, 2.5e-3).asDiagonal();
  scene.fixed.push_back(ground(0.8));
  PlantOptions options;
  options.mass_scale = 1.25;
  Rig scaled(scene, options);
  scene.objects[0].mass *= 1.25;
  scene.objects[0].inertia *= 1.25;
  Rig heavy(scene);
  Eigen::VectorXd q0(7), v0(6);
  q0 << 0, 0, 0.05, 0, 0, 0, 1;
  v0 << 0.3, 0, 0, 1, 2, 3;
  for (Rig* rig : {&scaled, &heavy}) ASSERT_EQ(rig->hold(q0, {}, 0.5, &v0), Status::Solved) << rig->result.message;
  EXPECT_EQ(scaled.result.q, heavy.result.q);
  EXPECT_NEAR(scaled.force().normal, 5, 0.05);
}

/// A can that is left on its face with some spin and wobble stands still within two seconds. With the contact of fingers it rolls round its rim,
/// fed by what a sliding contact opens.
TEST(Contact, StandingCan_StopsTurning) {
  world::Scene scene = empty_scene({0, 0, -9.8});
  scene.objects.push_back(solid(ObjectJoint::Free, world::Cylinder{0.14, 0.25}, 0.5, 0.5));
  scene.objects[0].inertia = 0.042 * Eigen::Matrix3d::Identity();
  scene.fixed.push_back(ground(0.06));
  PlantOptions hard;
  hard.contact.ground_softness = 1;
  Rig standard(scene), as_fingers(scene, hard);
  Eigen::VectorXd q0(7), v0(6);
  q0 << 0, 0, 0.25, 0, 0, 0, 1;
  for (const auto& [spin, wobble] : {std::pair(0.3, 0.0), std::pair(0.05, 0.3)}) {
    v0 << 0, 0, 0, wobble, 0, spin;
    for (Rig* rig : {&standard, &as_fingers}) ASSERT_EQ(rig->hold(q0, {}, 2.0, &v0), Status::Solved) << rig->result.message;
    EXPECT_LT(standard.v_end().norm(), 1e-3) << spin << ", " << wobble;
    EXPECT_GT(as_fingers.v_end().norm(), 0.05) << spin << ", " << wobble;
  }
}

/// MuJoCo loses sight of a plane that a cylinder's axis is perpendicular to but for rounding.
TEST(Contact, CanThatIsUprightButForRounding_Stands) {
  world::Scene scene = empty_scene({0, 0, -9.8});
  scene.objects.push_back(solid(ObjectJoint::Free, world::Cylinder{0.14, 0.25}, 0.5, 0.5));
  scene.fixed.push_back(ground(0.06));
  Rig rig(scene);
  for (const double tilt : {0.0, 1e-16, 1.4e-15, -2e-14, 1e-12}) {
    Eigen::VectorXd q0(7);
    q0 << 0, 0, 0.25, tilt, -0.9 * tilt, -std::sin(0.3), std::cos(0.3);
    ASSERT_EQ(rig.hold(q0, {}, 0.2), Status::Solved) << rig.result.message;
    EXPECT_NEAR(rig.q_end()[2], 0.25, 1e-4) << tilt;
  }
}

TEST(Contact, BallOfTheAllegroTask_RestsInThePalmWithoutSinkingIn) {
  auto model = load_task("allegro_ball");
  Rig rig(model);
  Eigen::VectorXd q0 = model->neutral();
  q0.head<7>() << -0.081, 0.001, 0.0721, 0, 0, 0, 1;
  q0.tail(16) << 0.03501504, 0.75276565, 0.74146232, 0.83261002, -0.1438725, 0.74696812, 0.61908827, 0.70064279, -0.06922541, 0.78533142,
      0.82942863, 0.90415436, 0.63256269, 1.02378254, 0.64089555, 0.82444782;
  rig.run.record_interval = rig.plant->options().timestep;
  ASSERT_EQ(rig.hold(q0, q0.tail(16), 1.0), Status::Solved) << rig.result.message;
  // It rolls a little in its seat, so that its momentum is counted too, over the second half.
  const SimulationResult& r = rig.result;
  const std::size_t from = r.times.size() / 2;
  Vector3d impulse = Vector3d::Zero();
  double depth = 0;
  for (std::size_t k = from; k + 1 < r.times.size(); ++k) {
    for (const auto& f : r.forces[k]) {
      const auto& pair = model->pairs()[static_cast<std::size_t>(f.pair)];
      if (model->geometries()[static_cast<std::size_t>(pair.geometry_a)].body != model->objects()[0].body) continue;
      impulse += f.force_W * rig.run.record_interval;
      depth = std::max(depth, f.depth);
    }
  }
  const Vector3d gained = rig.v_end().head<3>() - r.v.col(static_cast<Eigen::Index>(from)).head<3>();
  const double duration = r.times.back() - r.times[from];
  const double mass = model->objects()[0].mass;
  EXPECT_NEAR((impulse / duration / mass - gained / duration - Vector3d(0, 0, 10)).norm(), 0, 0.01) << "0.1 % of the weight";
  EXPECT_LT(depth, 1e-4);
  EXPECT_GT(depth, 1e-7);
}

/// A link that turns about its centre of mass presses on a wall: no force on that centre moves it, but contacts with it are as soft as (M.2) has them.
TEST(Contact, LinkThatTurnsAboutItsCentre_IsAsSoftAsOthers) {
  constexpr double kArm = 0.1, kRadius = 0.02, kInertia = 1e-4, kStiffness = 2, kTurn = 0.5;
  world::Scene scene = empty_scene(Vector3d::Zero());
  world::RobotSpec robot = pusher(0);
  robot.text = fmt::format(
      R"(<robot name="p"><link name="a"/><link name="b"><inertial><mass value="1"/><inertia ixx="{0}" iyy="{0}" izz="{0}" ixy="0" ixz="0" iyz="0"/></inertial>
      <collision><origin xyz="{1} 0 0"/><geometry><sphere radius="{2}"/></geometry></collision></link>
      <joint name="turn" type="revolute"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="9" velocity="1"/></joint></robot>)",
      kInertia, kArm, kRadius);
  robot.urdf = source_dir() / "";
  robot.stiffness = {{"turn", kStiffness}};
  scene.robots.push_back(robot);
  const world::Pose X_WB{Eigen::AngleAxisd(M_PI / 2, Vector3d::UnitX()).toRotationMatrix(), Vector3d(0, kRadius, 0)};
  scene.fixed.push_back(ground(1, X_WB));
  Rig rig(scene);
  ASSERT_EQ(rig.hold(Eigen::VectorXd::Zero(1), Eigen::VectorXd::Constant(1, kTurn), 1.0), Status::Solved) << rig.result.message;
  const double force = kStiffness * kTurn / kArm;
  EXPECT_NEAR(rig.force().normal, force, 0.01 * force);
  const ContactOptions& c = rig.plant->options().contact;
  const double moved =
      2.0 / 3 * (kArm + kRadius) * (kArm + kRadius) / (3 * kInertia);  // by a force on the surface: means over directions and axes [1/kg]
  const double depth = (1 - c.impedance) * moved * force * c.time_constant * c.time_constant;
  EXPECT_NEAR(rig.q_end()[0] * kArm, depth, 0.1 * depth);
}

TEST(Contact, FrictionlessSlope_SlidesFreely) {
  Slope s(0.0, 1.0);
  world::Scene scene = Slope::make_scene(0.0, 0.3);
  Rig rig(scene);
  ASSERT_EQ(rig.hold(s.q0, {}, 0.5), Status::Solved);
  EXPECT_NEAR(rig.v_end()[0], 0.5 * kG * std::sin(0.3), 1e-6);
  EXPECT_EQ(rig.force().tangential, 0);
}

TEST(Contact, ExcludedPair_PassesThrough) {
  world::Scene scene = empty_scene({0, 0, -10});
  scene.objects.push_back(solid(ObjectJoint::Free, world::Sphere{0.06}, 1, 1));
  scene.fixed.push_back(ground(1));
  scene.filters.push_back({"solid", "ground", std::nullopt});
  Rig rig(scene);
  Eigen::VectorXd q0(7);
  q0 << 0, 0, 0.06, 0, 0, 0, 1;
  ASSERT_EQ(rig.hold(q0, {}, 1.0), Status::Solved);
  EXPECT_NEAR(rig.q_end()[2], 0.06 - 5, 2e-3);
  EXPECT_TRUE(rig.result.forces.back().empty());
}

}  // namespace
}  // namespace stiction::simulation::test
