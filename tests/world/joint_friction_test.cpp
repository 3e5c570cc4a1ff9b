// Dry friction and damping of joints, and the largest force of a geometry: from scenes, URDF and MJCF.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <fstream>

#include "stiction/world/joint_motor.hpp"
#include "support/message_of.hpp"
#include "support/temporary_folder.hpp"
#include "world/test_scenes.hpp"

namespace stiction::world::test {
namespace {

using stiction::test::message_of;

class JointFriction : public testing::Test {
 protected:
  std::filesystem::path write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
    return folder_ / name;
  }

  std::shared_ptr<const Model> load(const std::string& scene) const { return Model::make(load_scene(write("scene.yaml", scene))); }

  /// A valve that turns about z with more keys, in line 3.
  static std::string valve(const std::string& keys, const std::string& joint = "joint: hinge, axis: [0, 0, 1]") {
    return "objects:\n  - {name: valve, " + joint + ", mass: 1, shapes: [{sphere: {radius: 0.1}}],\n     " + keys + "}\n";
  }

  /// Two joints, of which b follows a at −2, with the elements of their dynamics.
  void write_arm(const std::string& a, const std::string& b) const {
    const auto joint = [](const std::string& name, int parent, const std::string& elements) {
      return "<link name='l" + std::to_string(parent + 1) + "'/><joint name='" + name + "' type='revolute'><parent link='l" +
             std::to_string(parent) + "'/><child link='l" + std::to_string(parent + 1) + "'/><axis xyz='1 0 0'/>" +
             "<limit lower='-1' upper='1' effort='1' velocity='1'/>\n" + elements + "</joint>\n";
    };
    (void)write("arm.urdf", "<robot name='arm'><link name='l0'/>\n" + joint("a", 0, a) + joint("b", 1, b) + "</robot>");
  }

  const stiction::test::TemporaryFolder temporary_;
  const std::filesystem::path& folder_ = temporary_.path();
  std::string arm_ = "robots: [{name: arm, urdf: arm.urdf, stiffness: 1}]\n";
};

TEST_F(JointFriction, OfScene_IsThatOfTheModel) {
  const auto valve_model = load(valve("joint_friction: 0.3, joint_damping: 0.02"));
  EXPECT_EQ(valve_model->dofs()[0].friction, 0.3);
  EXPECT_EQ(valve_model->dofs()[0].damping, 0.02);
  const auto drawer = load(valve("joint_friction: 4", "joint: slider, axis: [1, 0, 0]"));
  EXPECT_EQ(drawer->dofs()[0].friction, 4);
  EXPECT_EQ(drawer->dofs()[0].damping, 0);
  EXPECT_EQ(load(valve("friction: 0.5"))->dofs()[0].friction, 0) << "the key of surfaces";
}

TEST_F(JointFriction, DampingOfFreeAndPlanarObjects_IsThatOfEachCoordinate) {
  for (const char* joint : {"joint: free", "joint: planar_xy"}) {
    const auto model = load(valve("joint_damping: 0.02", joint));
    for (const Dof& dof : model->dofs()) EXPECT_EQ(dof.damping, dof.owner_kind == BodyKind::Object ? 0.02 : 0) << dof.name;
  }
}

TEST_F(JointFriction, NegativeOrOfAnObjectWithoutAJoint_NamesFileLineAndField) {
  const auto says = [&](const std::string& scene, const std::string& expected) {
    const std::string message = message_of([&] { (void)load(scene); });
    EXPECT_NE(message.find(expected), std::string::npos) << message;
  };
  says(valve("joint_friction: -1"), "scene.yaml:3: objects[0].joint_friction: got -1, expected a number ≥ 0");
  says(valve("joint_damping: none"), "scene.yaml:3: objects[0].joint_damping: got 'none', expected a number");
  says(valve("joint_friction: 1", "joint: free"),
       "scene.yaml:3: objects[0].joint_friction: got joint_friction of a free object, expected it only for hinge and slider objects");
  says(
      valve("joint_stiffness: 1", "joint: planar_xy"),
      "scene.yaml:3: objects[0].joint_stiffness: got joint_stiffness of a planar_xy object, expected it only for hinge and slider objects");
}

TEST_F(JointFriction, OfSceneMadeInCode_IsCheckedToo) {
  Scene scene = load_scene(write("scene.yaml", valve("friction: 1")));
  const auto says = [&](auto&& change) {
    Scene changed = scene;
    change(changed.objects[0]);
    return message_of([&] { (void)Model::make(changed); });
  };
  EXPECT_NE(says([](ObjectSpec& o) { o.joint_friction = -2; }).find("objects[0]: joint_friction: got -2"), std::string::npos);
  EXPECT_NE(says([](ObjectSpec& o) { o.joint_damping = kInfinity; }).find("objects[0]: joint_damping: got inf"), std::string::npos);
  EXPECT_NE(says([](ObjectSpec& o) {
              o.joint = ObjectJoint::Free, o.joint_friction = 1;
            }).find("objects[0]: joint_friction: got 1, expected it only for hinge and slider objects"),
            std::string::npos);
  EXPECT_NE(says([](ObjectSpec& o) {
              o.geometries[0].max_force = 0;
            }).find("sphere_0.max_force: got 0, expected a number > 0, or infinity for none"),
            std::string::npos);
}

/// At the same power a leader feels |ratio| of the friction and ratio² of the damping of what follows it.
TEST_F(JointFriction, OfUrdf_IsThatOfTheRobotsJoint) {
  write_arm("<dynamics friction='0.2' damping='0.5'/>", "<dynamics damping='3'/>");
  const auto two = load(arm_);
  EXPECT_EQ(two->dofs()[0].friction, 0.2);
  EXPECT_EQ(two->dofs()[0].damping, 0.5);
  EXPECT_EQ(two->dofs()[1].friction, 0);
  EXPECT_EQ(two->dofs()[1].damping, 3);
  write_arm("<dynamics friction='0.2' damping='0.5'/>", "<mimic joint='a' multiplier='-2'/><dynamics friction='0.1' damping='3'/>");
  const auto one = load(arm_);
  ASSERT_EQ(one->n_a(), 1);
  EXPECT_DOUBLE_EQ(one->dofs()[0].friction, 0.4);
  EXPECT_DOUBLE_EQ(one->dofs()[0].damping, 12.5);
}

TEST_F(JointFriction, NegativeInUrdf_NamesFileLineAndJoint) {
  write_arm("", "<dynamics friction='-0.2'/>");
  const std::string message = message_of([&] { (void)load(arm_); });
  EXPECT_NE(message.find("arm.urdf:5: joint 'b' friction: got -0.2, expected a number ≥ 0"), std::string::npos) << message;
}

TEST_F(JointFriction, OfMjcf_IsThatOfTheRobotsJoint) {
  (void)write("arm.xml", R"(<mujoco model="arm"><worldbody><body name="l1"><joint name="a" axis="1 0 0" frictionloss="0.4" damping="2"/>
  <geom size="0.1"/><body name="l2" pos="0 0 1"><joint name="b" type="slide" axis="1 0 0" damping="1"/><geom size="0.1"/></body></body>
  </worldbody></mujoco>)");
  const auto model = load("robots: [{name: arm, mjcf: arm.xml, stiffness: 1}]\n");
  EXPECT_EQ(model->dofs()[0].friction, 0.4);
  EXPECT_EQ(model->dofs()[0].damping, 2);
  EXPECT_EQ(model->dofs()[1].friction, 0);
  EXPECT_EQ(model->dofs()[1].damping, 1);
}

/// At the same energy a leader has ratio² of the armature of its follower.
TEST_F(JointFriction, ArmatureAndServoDampingOfMjcf_AreThoseOfTheRobotsJoint) {
  const std::string arm = R"(<mujoco model="arm"><worldbody><body name="l1"><joint name="a" type="slide" axis="1 0 0" armature="3"/>
  <geom size="0.1"/><body name="l2" pos="0 0 1"><joint name="b" type="slide" axis="1 0 0" armature="2"/><geom size="0.1"/></body></body>
  </worldbody><actuator><position joint="a" kp="400" kv="30" gear="2"/></actuator>)";
  (void)write("two.xml", arm + "</mujoco>");
  const auto two = load("robots: [{name: arm, mjcf: two.xml}]\n");
  EXPECT_EQ(joint_motors(*two)[0].armature, 3);
  EXPECT_EQ(joint_motors(*two)[0].damping, 30 * 4) << "k_v g²";
  EXPECT_EQ(joint_motors(*two)[1].armature, 2);
  EXPECT_EQ(joint_motors(*two)[1].damping, 0);
  Kinematics kinematics;
  KinematicsWorkspace work(*two);
  calc_kinematics(*two, two->neutral(), work, kinematics);
  const double ball = 1000 * 4.0 / 3 * M_PI * 1e-3;
  EXPECT_NEAR(calc_joint_inertia(*two, kinematics)[0], 3 + 2 * ball, 1e-9);
  EXPECT_NEAR(calc_joint_inertia(*two, kinematics)[1], 2 + ball, 1e-9);
  (void)write("one.xml", arm + "<equality><joint joint1='b' joint2='a' polycoef='0 -3 0 0 0'/></equality></mujoco>");
  const auto one = load("robots: [{name: arm, mjcf: one.xml}]\n");
  ASSERT_EQ(one->n_a(), 1);
  EXPECT_DOUBLE_EQ(joint_motors(*one)[0].armature, 1600.0 / 400) << "of 3 + 9 * 2, what the spring moves at 20 rad/s";
  EXPECT_TRUE(std::any_of(one->notes().begin(), one->notes().end(), [](const std::string& note) {
    return note == "arm: armatures that springs move at less than 20 rad/s are smaller here [kg·m², kg]: a 4 in place of 21";
  })) << fmt::format("{}", fmt::join(one->notes(), "\n"));
  const auto soft = load("robots: [{name: arm, mjcf: two.xml, stiffness: {a: 1600, b: 900}}]\n");
  EXPECT_EQ(joint_motors(*soft)[0].damping, 0) << "k_v belongs to the stiffness of the file";
}

TEST_F(JointFriction, LargestForce_IsThatOfTheShapeElseOfItsOwner) {
  const auto model = load(
      "objects:\n  - {name: egg, joint: free, mass: 1, max_force: 6,\n"
      "     shapes: [{name: shell, sphere: {radius: 0.1}}, {name: tip, sphere: {radius: 0.05}, max_force: 2}]}\n"
      "  - {name: stone, joint: free, mass: 1, shapes: [{name: s, sphere: {radius: 0.1}}]}\n"
      "fixed:\n  - {name: pane, max_force: 4, shapes: [{name: glass, half_space: {}}]}\n");
  const auto geometries = model->geometries();
  EXPECT_EQ(geometries[0].max_force, 6);
  EXPECT_EQ(geometries[1].max_force, 2);
  EXPECT_EQ(geometries[2].max_force, kInfinity);
  EXPECT_EQ(geometries[3].max_force, 4);
  for (const Pair& pair : model->pairs()) {
    EXPECT_EQ(pair.max_force, std::min(geometries[static_cast<std::size_t>(pair.geometry_a)].max_force,
                                       geometries[static_cast<std::size_t>(pair.geometry_b)].max_force));
  }
  EXPECT_EQ(model->pairs().size(), 5u);
}

TEST_F(JointFriction, LargestForceNotPositive_NamesFileLineAndField) {
  const auto says = [&](const std::string& scene, const std::string& expected) {
    const std::string message = message_of([&] { (void)load(scene); });
    EXPECT_NE(message.find(expected), std::string::npos) << message;
  };
  says(valve("max_force: 0"), "scene.yaml:3: objects[0].max_force: got 0, expected a number > 0");
  says("fixed:\n  - {name: pane, shapes: [{half_space: {}, max_force: -3}]}\n",
       "scene.yaml:2: fixed[0].shapes[0].max_force: got -3, expected a number > 0");
}

TEST_F(JointFriction, MomentsOfContacts_AreThoseOfTheShapeElseOfItsOwnerAndOfAPairTheLarger) {
  const auto model = load(
      "objects:\n  - {name: egg, joint: free, mass: 1, torsional_friction: 0.004,\n"
      "     shapes: [{name: shell, sphere: {radius: 0.1}}, {name: tip, sphere: {radius: 0.05}, torsional_friction: 0, rolling_friction: "
      "0.001}]}\n"
      "  - {name: stone, joint: free, mass: 1, shapes: [{name: s, sphere: {radius: 0.1}}]}\n"
      "fixed:\n  - {name: mat, torsional_friction: 0.002, shapes: [{name: m, half_space: {}}]}\n"
      "  - {name: bench, shapes: [{name: b, half_space: {}}]}\n");
  const auto numbers = [&](const std::string& a, const std::string& b) {
    for (const Pair& pair : model->pairs()) {
      const auto name = [&](int geometry) { return model->geometries()[static_cast<std::size_t>(geometry)].name; };
      if (name(pair.geometry_a) == a && name(pair.geometry_b) == b) return std::array{pair.friction, pair.torsional, pair.rolling};
    }
    ADD_FAILURE() << a << ' ' << b;
    return std::array{0.0, 0.0, 0.0};
  };
  EXPECT_EQ(numbers("egg/shell", "mat/m"), (std::array{1.0, 0.004, 0.0}));
  EXPECT_EQ(numbers("egg/tip", "mat/m"), (std::array{1.0, 0.002, 0.001}));
  EXPECT_EQ(numbers("egg/tip", "bench/b"), (std::array{1.0, 0.0, 0.001}));
  EXPECT_EQ(numbers("egg/shell", "stone/s"), (std::array{1.0, 0.004, 0.0}));
  EXPECT_EQ(numbers("stone/s", "mat/m"), (std::array{1.0, 0.002, 0.0}));
  EXPECT_EQ(numbers("stone/s", "bench/b"), (std::array{1.0, 0.0, 0.0}));
}

TEST_F(JointFriction, MomentsThatAreNegativeOrOfAnMjcf_NameFileLineAndField) {
  const auto says = [&](const std::string& scene, const std::string& expected) {
    const std::string message = message_of([&] { (void)load(scene); });
    EXPECT_NE(message.find(expected), std::string::npos) << message;
  };
  says("fixed:\n  - {name: pane, shapes: [{half_space: {}, rolling_friction: -3}]}\n",
       "scene.yaml:2: fixed[0].shapes[0].rolling_friction: got -3, expected a number ≥ 0");
  says("fixed:\n  - {name: pane, torsional_friction: .inf, shapes: [{half_space: {}}]}\n",
       "scene.yaml:2: fixed[0].torsional_friction: got ");
  write("arm.xml", "<mujoco><worldbody><body><joint/><geom size='.1'/></body></worldbody></mujoco>");
  says("robots: [{name: arm, mjcf: arm.xml, torsional_friction: 1}]\n",
       "robots[0].torsional_friction: got torsional_friction beside mjcf, expected it only for URDF robots");
}

}  // namespace
}  // namespace stiction::world::test
