// Linkages that a `connect` closes, against closed forms and against MuJoCo that simulates them.
#include "stiction/world/mjcf_loops.hpp"

#include <fmt/format.h>

#include <cmath>

#include "stiction/world/read.hpp"
#include "world/mjcf_oracle.hpp"

namespace stiction::world::test {
namespace {

/// A crank that an actuator moves, a coupler on its tip, and a rocker that stands beside the crank. They turn about y, and a crank at 0 points up.
/// @param rocker  its length; the coupler is as long as crank and rocker are apart at 0  @param spring  of the rocker   @param tip  a joint between coupler and
/// rocker, so that the loop leaves one joint free
std::string linkage(double rocker, const std::string& spring = "", bool tip = false) {
  const double rise = rocker - 0.1, coupler = std::hypot(0.06, rise);
  const double at_file = std::atan2(0.06, rise);  // of the coupler
  const std::string end =
      tip ? fmt::format(R"(<body name="tip" pos="0.02 0 {}"><joint name="tip" type="hinge" axis="0 1 0" range="-0.5 0.5"/>
    <geom size=".004" mass=".01"/></body>)",
                        0.6 * coupler)
          : "";
  return fmt::format(R"(<option gravity="0 0 0" timestep="0.001" integrator="implicitfast"/><worldbody><body name="base"><geom size=".01"/>
  <body name="crank"><joint name="crank" type="hinge" axis="0 1 0" range="-0.6 0.6"/><geom type="capsule" fromto="0 0 0 0 0 .1" size=".004" mass=".01"/>
    <body name="coupler" pos="0 0 .1" euler="0 {} 0"><joint name="coupler" type="hinge" axis="0 1 0"/><geom size=".004" mass=".01"/>{}</body></body>
  <body name="rocker" pos="0.06 0 0"><joint name="rocker" type="hinge" axis="0 1 0" {}/><geom type="capsule" fromto="0 0 0 0 0 {}" size=".004" mass=".01"/></body>
  </body></worldbody>
  <equality><connect body1="{}" body2="rocker" anchor="{} 0 {}" solref="0.004 1"/></equality>
  <actuator><position joint="crank" kp="100" kv="1"/></actuator>
  <default><joint damping="0.02" armature="0.001"/><geom contype="0" conaffinity="0"/></default>)",
                     at_file, end, spring, rocker, tip ? "tip" : "coupler", tip ? -0.02 : 0.0, tip ? 0.4 * coupler : coupler);
}

struct Linkage {
  explicit Linkage(const std::string& content, const RobotSpec& robot = {})
      : file(write_mjcf("<compiler angle='radian'/>" + content, "linkage.xml")),
        m(load_mujoco(file)),
        roles(*m, robot, file),
        view(m.get(), roles, file),
        couplings(view) {}

  int joint(const char* name) const { return mj_name2id(m.get(), mjOBJ_JOINT, name); }
  const MjcfCoupling& of(const char* name) const { return couplings.of(joint(name)); }

  /// Where MuJoCo comes to rest with the crank at x.
  Eigen::VectorXd simulate(double x) const {
    const Owned<mjData> d(mj_makeData(m.get()));
    d->ctrl[0] = x;
    for (int k = 0; k < 20000; ++k) mj_step(m.get(), d.get());
    EXPECT_LT(Eigen::Map<const Eigen::VectorXd>(d->qvel, m->nv).cwiseAbs().maxCoeff(), 1e-3);
    return Eigen::Map<const Eigen::VectorXd>(d->qpos, m->nq);
  }

  std::filesystem::path file;
  Owned<mjModel> m;
  MjcfRoles roles;
  MjcfView view;
  MjcfCouplings couplings;
};

TEST(MjcfLoops, Parallelogram_TurnsAsItsCrankDoes) {
  const Linkage linkage_(linkage(0.1));
  EXPECT_EQ(linkage_.of("rocker").leader, linkage_.joint("crank"));
  EXPECT_NEAR(linkage_.of("rocker").ratio, 1, 1e-6);
  EXPECT_NEAR(linkage_.of("rocker").offset, 0, 1e-6);
  EXPECT_NEAR(linkage_.of("coupler").ratio, -1, 1e-6);
  const RobotContents contents = read_mjcf(linkage_.file);
  int motors = 0;
  for (const RobotJoint& joint : contents.robot.joints) motors += joint.kind != RobotJoint::Kind::Fixed && joint.leader < 0;
  EXPECT_EQ(motors, 1);
  for (const std::string& note : contents.robot.notes) EXPECT_EQ(note.find("passed over"), std::string::npos) << note;
}

TEST(MjcfLoops, FourBar_StandsWhereMujocoBringsIt) {
  const Linkage linkage_(linkage(0.14));
  const MjcfCoupling &rocker = linkage_.of("rocker"), &coupler = linkage_.of("coupler");
  ASSERT_EQ(rocker.leader, linkage_.joint("crank"));
  double worst = 0;
  for (const double x : {-0.6, -0.3, 0.0, 0.35, 0.6}) {
    const Eigen::VectorXd q = linkage_.simulate(x);
    const double crank = q[linkage_.joint("crank")];
    worst = std::max(worst, std::abs(q[linkage_.joint("rocker")] - rocker.ratio * crank - rocker.offset));
    EXPECT_NEAR(q[linkage_.joint("coupler")], coupler.ratio * crank + coupler.offset, 0.08);
  }
  const auto notes = linkage_.couplings.notes();
  ASSERT_EQ(notes.size(), 1u);
  const auto at = notes[0].find("rocker ");
  ASSERT_NE(at, std::string::npos) << notes[0];
  const double said = std::stod(notes[0].substr(at + 7));
  EXPECT_GT(said, 1e-3) << "not a line";
  EXPECT_LE(worst, said + 1e-3);
  EXPECT_GE(worst, 0.5 * said);
}

/// One joint more than the loop decides: a spring on the rocker brings it to a limit of the tip.
TEST(MjcfLoops, JointThatTheLoopLeavesFree_StandsWhereSpringsTakeIt) {
  for (const double rest : {1.5, -1.5}) {
    const Linkage linkage_(linkage(0.1, fmt::format("stiffness='0.05' springref='{}'", rest), true));
    const int equality = 0;
    std::vector<bool> driven(static_cast<std::size_t>(linkage_.m->njnt), false);
    driven[static_cast<std::size_t>(linkage_.joint("crank"))] = true;
    std::vector<MjcfCoupling> own;
    for (int j = 0; j < linkage_.m->njnt; ++j) own.push_back({.joint = j, .leader = j});
    auto loop = MjcfLoop::find(
        *linkage_.m, equality, linkage_.view, [&](int j) -> const MjcfCoupling& { return own[static_cast<std::size_t>(j)]; }, driven);
    ASSERT_TRUE(loop);
    EXPECT_EQ(loop->leader(), linkage_.joint("crank"));
    ASSERT_EQ(loop->joints().size(), 3u);
    for (const double x : {-0.4, 0.0, 0.4}) {
      const Eigen::VectorXd q = linkage_.simulate(x), y = loop->solve(q[linkage_.joint("crank")]);
      for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(y[static_cast<Eigen::Index>(i)], q[loop->joints()[i]], 0.01) << i << " at " << x;
    }
  }
}

TEST(MjcfLoops, WithTwoDrivenJoints_OrNone_ArePassedOver) {
  for (const char* actuators : {R"(<position joint="crank"/><position joint="rocker"/>)", ""}) {
    std::string text = linkage(0.1);
    const std::string one = R"(<position joint="crank" kp="100" kv="1"/>)";
    text.replace(text.find(one), one.size(), actuators);
    const Linkage linkage_(text);
    EXPECT_TRUE(linkage_.couplings.list().empty());
    EXPECT_EQ(linkage_.view.list_passed_over(linkage_.couplings.meaning()).size(), 1u);
  }
}

/// Each link of a linkage may stand on the ground by itself: all are the robot's. What has a free joint is an object all the same.
TEST(MjcfLoops, TreesThatALoopTiesToTheRobot_AreTheRobots) {
  const std::string ground = R"(<worldbody><body name="crank"><joint name="crank" type="hinge" axis="0 1 0"/><geom size=".01"/></body>
  <body name="rocker" pos=".1 0 0"><joint name="rocker" type="hinge" axis="0 1 0"/><geom size=".01"/></body>
  <body name="ball" pos=".3 0 0"><freejoint name="ball"/><geom size=".01"/></body></worldbody><actuator><position joint="crank"/></actuator>
  <equality><connect body1="crank" body2="{}" anchor="0 0 .1"/></equality>)";
  RobotSpec robot;
  robot.split.by_actuators = true;
  const auto role = [&](const char* tied, const char* joint) {
    const Linkage linkage_(fmt::format(fmt::runtime(ground), tied), robot);
    return linkage_.roles.of_joint(linkage_.joint(joint));
  };
  EXPECT_EQ(role("rocker", "rocker"), MjcfRole::Robot);
  EXPECT_EQ(role("ball", "rocker"), MjcfRole::Object);
  EXPECT_EQ(role("ball", "ball"), MjcfRole::Object);
}

}  // namespace
}  // namespace stiction::world::test
