#include "stiction/world/read.hpp"
#include "world/mjcf_oracle.hpp"

// Files that an MJCF names, names of its elements, and numbers that it should not state.

namespace stiction::world::test {
namespace {

namespace fs = std::filesystem;

constexpr const char* kBall = R"(<worldbody><body name="b"><joint name="j"/><geom size=".1"/></body></worldbody>)";

bool file_has_note(const fs::path& file, const std::string& part) {
  const auto notes = read_mjcf(file).robot.notes;
  return std::any_of(notes.begin(), notes.end(), [&](const auto& note) { return note.find(part) != std::string::npos; });
}

fs::path write_in(const fs::path& folder, const std::string& name, const std::string& content) {
  const fs::path file = stiction::test::folder_of_the_process() / folder / name;
  fs::create_directories(file.parent_path());
  std::ofstream(file) << "<mujoco>" << content << "</mujoco>";
  return file;
}

/// A pyramid, which MuJoCo and the library read.
void write_mesh(const fs::path& folder) {
  const fs::path file = stiction::test::folder_of_the_process() / folder / "link.obj";
  fs::create_directories(file.parent_path());
  std::ofstream(file) << "v 0 0 0\nv .1 0 0\nv 0 .2 0\nv 0 0 .3\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n";
}

/// Body of a gripper that is seen by a mesh, and weighs as that mesh.
std::string gripper(const std::string& compiler) {
  return "<compiler " + compiler + R"(/><asset><mesh name="link" file="link.obj"/></asset><worldbody><body name="hand">
    <joint name="w" range="-.1 .1"/><geom type="mesh" mesh="link" contype="0" conaffinity="0"/><geom size=".05"/></body></worldbody>)";
}

TEST(MjcfFiles, MeshesOfAnAttachedFile_AreFoundInItsOwnFolder) {
  write_mesh("sub/assets");
  write_in("sub", "gripper.xml", gripper(R"(meshdir="assets" angle="radian")"));
  const fs::path file = write_mjcf(
      R"(<asset><model name="g" file="sub/gripper.xml"/></asset><worldbody><body name="base"><joint name="j" type="slide"/><geom size=".1"/>
         <attach model="g" body="hand" prefix="g_"/></body></worldbody>)");
  const Owned<mjModel> m = load_mujoco(file);
  EXPECT_FALSE(file_has_note(file, "missing"));
  EXPECT_FALSE(file_has_note(file, "angles")) << "the attached file states that its angles are radians";
  const RobotTree robot = read_mjcf(file).robot;
  EXPECT_EQ(robot.links.back().name, "g_hand");
  EXPECT_DOUBLE_EQ(robot.links.back().inertia->mass, m->body_mass[m->nbody - 1]);
}

TEST(MjcfFiles, PathsThatTheFileStrips_AreNotMissing) {
  write_mesh("assets");
  const fs::path file = write_mjcf(R"(<compiler meshdir="assets" strippath="true"/><asset><mesh name="m" file="C:\cad/link.obj"/></asset>
    <worldbody><body><joint/><geom type="mesh" mesh="m" contype="0" conaffinity="0"/><geom size=".1"/></body></worldbody>)");
  (void)load_mujoco(file);
  EXPECT_FALSE(file_has_note(file, "missing"));
}

TEST(MjcfFiles, IncludedFileOfTheSameName_IsAnotherFile) {
  write_in("robot", "scene.xml", kBall);
  const fs::path file = write_mjcf(R"(<include file="robot/scene.xml"/>)", "scene.xml");
  EXPECT_EQ(read_mjcf(file).robot.links.size(), 2u);
  EXPECT_NE(message_of_file(write_mjcf(R"(<include file="self.xml"/>)", "self.xml")).find("self.xml"), std::string::npos);
}

TEST(MjcfFiles, Latin1_IsReadWhereTheFileDeclaresIt) {
  const fs::path file = stiction::test::folder_of_the_process() / "latin.xml";
  const std::string text =
      "<mujoco><worldbody><body name='gr\xf6\xdf"
      "e'><joint/><geom size='.1'/></body></worldbody></mujoco>";
  std::ofstream(file) << "<?xml version='1.0' encoding='ISO-8859-1'?>" << text;
  EXPECT_EQ(read_mjcf(file).robot.links.back().name, "größe");
  std::ofstream(file) << text;
  EXPECT_NE(message_of_file(file).find("latin.xml:1: mjcf: got bytes that are not UTF-8"), std::string::npos) << message_of_file(file);
  const fs::path outer = write_mjcf(R"(<include file="latin.xml"/>)", "outer.xml");
  EXPECT_NE(message_of_file(outer).find("names with bytes that are not UTF-8"), std::string::npos) << message_of_file(outer);
}

TEST(MjcfFiles, AnglesOfFilesWithoutAUnit_AreNamedByTheJointsOfThoseFilesOnly) {
  write_mesh(".");
  write_in(".", "gripper.xml", gripper(R"(meshdir=".")"));
  const fs::path file = write_mjcf(
      R"(<compiler angle="radian"/><asset><model name="g" file="gripper.xml"/></asset><worldbody><body name="base">
         <attach model="g" body="hand" prefix="g_"/><joint name="own" range="-1 1"/><geom size=".1"/></body></worldbody>)");
  EXPECT_TRUE(file_has_note(file, "in degrees: g_w [-0.1, 0.1];"));
}

TEST(MjcfFiles, BodyOfNoMass_WeighsNothing) {
  const fs::path file = write_mjcf(R"(<worldbody><body name="arm"><joint name="j"/><geom size=".1" mass="1"/>
    <body name="plate" pos="1 0 0"><geom type="box" size=".1 .1 .1" mass="0"/></body></body></worldbody>)");
  const RobotTree robot = read_mjcf(file).robot;
  ASSERT_EQ(robot.links.back().name, "plate");
  ASSERT_TRUE(robot.links.back().inertia);
  EXPECT_EQ(robot.links.back().inertia->mass, 0);
}

/// dm_control names by paths, and a file may name an element as the library names one without a name.
TEST(MjcfFiles, NamesThatBecomeTheSame_AreMadeUnique) {
  const fs::path file =
      write_mjcf(R"(<worldbody><body name="a/b"><joint name="j k"/><geom name="g h" size=".1"/><geom name="g_h" size=".1"/>
    <geom size=".1"/><geom name="sphere_2" size=".1"/><body name="a_b" pos="1 0 0"><joint name="j_k"/><geom size=".1"/>
    <body><joint/><geom size=".1"/></body><body name="body_3"><geom size=".1"/></body></body></body></worldbody>)");
  const auto model = make_model(file);
  std::vector<std::string> joints;
  for (const auto& dof : model->dofs()) joints.push_back(dof.name);
  EXPECT_EQ(joints, (std::vector<std::string>{"arm/j_k_2", "arm/j_k", "arm/body_3_2_joint_0"}));
  std::vector<std::string> shapes;
  for (const auto& geometry : model->geometries()) shapes.push_back(geometry.name);
  EXPECT_EQ(shapes, (std::vector<std::string>{"arm/a_b_2/g_h_", "arm/a_b_2/g_h", "arm/a_b_2/sphere_2_", "arm/a_b_2/sphere_2",
                                              "arm/a_b/sphere_0", "arm/body_3_2/sphere_0", "arm/body_3/sphere_0"}));
}

/// As with one joint, and as in MuJoCo.
TEST(MjcfFiles, BodiesThatSeveralJointsLink_NeverTouch) {
  for (const char* joints : {"<joint name='x'/>", "<joint name='x'/><joint name='y' axis='0 1 0'/>",
                             "<joint name='x'/><joint name='y' axis='0 1 0'/><joint name='z' axis='1 0 0' pos='.1 0 0'/>"}) {
    const std::string bodies = std::string("<worldbody><body name='a'><joint name='j'/><geom size='.1'/><body name='b' pos='.3 0 0'>") +
                               joints +
                               "<geom size='.1'/><body name='c' pos='.3 0 0'><joint name='k'/><geom size='.1'/></body></body></body>";
    const auto robot = make_model(write_mjcf(bodies + "</worldbody>"));
    ASSERT_EQ(robot->pairs().size(), 1u) << joints << ": a and c";
    write_mjcf(bodies +
                   "<body name='r'><joint name='motor'/><inertial pos='0 0 0' mass='1' diaginertia='1 1 1'/></body></worldbody>"
                   "<actuator><motor joint='motor'/></actuator>",
               "scene.xml");
    const auto objects = Model::make(parse_scene("file: scene.xml", stiction::test::folder_of_the_process()));
    EXPECT_EQ(objects->pairs().size(), 1u) << joints;
  }
}

TEST(MjcfFiles, NumbersThatAreNone_AreRefusedByElementAndAttribute) {
  const auto message = [](const std::string& body, const std::string& joint, const std::string& geom, const std::string& motor) {
    return message_of_file(write_mjcf("<worldbody><body name='b' " + body + "><joint name='j' " + joint + "/><geom name='g' size='.1' " +
                                      geom + "/></body></worldbody><actuator><position name='m' joint='j' kp='5' " + motor +
                                      "/></actuator>"));
  };
  EXPECT_EQ(message("", "range='-inf inf'", "", "forcerange='-inf inf'"), "");
  const std::string all = message("pos='nan 0 0'", "damping='-1'", "friction='inf'", "gear='nan'");
  for (const char* part : {"pos and quat of the bodies 'b'", "damping, frictionloss and armature of the joints 'j'",
                           "friction of the geoms 'g'", "gear of the actuators 'm'", "expected finite numbers"})
    EXPECT_NE(all.find(part), std::string::npos) << all;
  for (const char* joint : {"axis='nan 0 0'", "ref='inf'", "range='nan 1' limited='true'", "stiffness='nan'", "frictionloss='inf'",
                            "armature='nan'", "armature='-1'"})
    EXPECT_NE(message("", joint, "", "").find("of the joints 'j'"), std::string::npos) << joint;
  EXPECT_NE(message("", "", "", "forcerange='nan 1'").find("ranges of the actuators 'm'"), std::string::npos);
}

/// Sizes of a file are for its simulation. MuJoCo would refuse the first, and take minutes for the others.
TEST(MjcfFiles, SizesOfTheSimulation_AreNotMade) {
  for (const char* size : {"memory='100T'", "nuserdata='2000000000'", "nuser_body='2000000000'", "njmax='2000000000'"}) {
    const fs::path file = write_mjcf(std::string("<size ") + size + "/>" + kBall);
    EXPECT_EQ(message_of_file(file), "") << size;
  }
}

TEST(MjcfFiles, MotorWithoutABound_HasNoEffort) {
  const fs::path file = write_mjcf(R"(<worldbody><body><joint name="j"/><geom size=".1"/></body></worldbody>
    <actuator><motor joint="j" ctrlrange="-inf inf"/></actuator>)");
  EXPECT_FALSE(read_mjcf(file).robot.joints[0].effort);
}

}  // namespace
}  // namespace stiction::world::test
