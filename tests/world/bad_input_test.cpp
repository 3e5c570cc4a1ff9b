// What a caller is told about each mistake. Every message has the form "FILE:LINE: field: got …, expected …".
#include <gtest/gtest.h>

#include <fstream>
#include <limits>

#include "stiction/core/invalid_input.hpp"
#include "support/temporary_folder.hpp"
#include "world/test_scenes.hpp"

namespace stiction::world {
namespace {

namespace fs = std::filesystem;

/// A folder of its own for every test, removed at the end.
class BadInput : public testing::Test {
 protected:
  void SetUp() override {
    write("arm.urdf", R"(<robot name="arm">
  <link name="base"/>
  <link name="tip"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
  <joint name="elbow" type="revolute"><parent link="base"/><child link="tip"/><axis xyz="0 0 1"/><limit lower="-1" upper="1"/></joint>
</robot>
)");
  }

  fs::path write(const std::string& name, const std::string& text) {
    std::ofstream(dir_ / name, std::ios::binary) << text;
    return dir_ / name;
  }

  /// What loading and building the scene says, with the folder's name taken out.
  std::string message(const std::string& text) {
    const fs::path file = write("scene.yaml", text);
    return message_of([&] { Model::make(load_scene(file)); });
  }

  template <class F>
  std::string message_of(F&& action) {
    try {
      action();
    } catch (const core::InvalidInput& e) {
      std::string what = e.what();
      const std::string prefix = dir_.string() + "/";
      for (auto at = what.find(prefix); at != std::string::npos; at = what.find(prefix)) what.erase(at, prefix.size());
      return what;
    }
    return "";
  }

  const stiction::test::TemporaryFolder temporary_;
  const std::filesystem::path& dir_ = temporary_.path();
};

std::string ball(const std::string& more) {
  return "objects:\n  - name: ball\n    joint: free\n    mass: 1\n    shapes: [{sphere: {radius: 0.1}}]\n" + more;
}

std::string arm(const std::string& more) { return "robots:\n  - name: arm\n    urdf: arm.urdf\n" + more; }

TEST_F(BadInput, GoodScenes_SayNothing) {
  EXPECT_EQ(message(ball("")), "");
  EXPECT_EQ(message(arm("    stiffness: {elbow: 3}\n")), "");
  EXPECT_EQ(message("{}"), "");
}

TEST_F(BadInput, UnknownKey_ListsTheAllowedOnesWithAHint) {
  EXPECT_EQ(message("gravty: [0, 0, 0]\n"),
            "scene.yaml:1: gravty: got an unknown key, expected one of name, file, robot, gravity, contact_distance, max_contacts, robots, "
            "objects, "
            "fixed, places, filters; "
            "did you mean 'gravity'?");
  EXPECT_EQ(message("fixed:\n  - name: floor\n    shapes:\n      - half_space: {}\n        frictoin: 1\n"),
            "scene.yaml:5: fixed[0].shapes[0].frictoin: got an unknown key, expected one of name, pose, friction, torsional_friction, "
            "rolling_friction, max_force, sphere, box, "
            "capsule, "
            "cylinder, ellipsoid, mesh, "
            "half_space; did you mean 'friction'?");
  EXPECT_EQ(message(ball("    wibble: 1\n")).substr(0, 62), "scene.yaml:6: objects[0].wibble: got an unknown key, expected ");
}

TEST_F(BadInput, SecondDocument_IsRefusedRatherThanPassedOver) {
  EXPECT_EQ(message("name: a\n---\nname: b\n"), "scene.yaml:3: file: got a second document, expected one: '---' ends the first");
  for (const char* text : {"---\nname: a\n", "name: a\n---\n", "name: a\n...\n", "%YAML 1.2\n---\nname: a\n"})
    EXPECT_EQ(message(text).find("document"), std::string::npos) << text;
}

TEST_F(BadInput, Byte0_IsRefused) {
  using namespace std::string_literals;
  EXPECT_EQ(message("name: a\ngravity: [0, 0, \0-9.81]\n"s), "scene.yaml:2: file: got a byte 0, expected text");
}

TEST_F(BadInput, NumbersBeyondAllSizes_AreRefused) {
  EXPECT_EQ(message("gravity: [0, 0, -1e300]\n"), "scene.yaml:1: gravity[2]: got -1e300, expected a number of at most 1e+50");
  EXPECT_EQ(message("objects: [{name: b, joint: free, mass: 1, shapes: [{box: {size: [1e-200, 1e-200, 1e-200]}}]}]"),
            "scene.yaml:1: objects[0].shapes: got a volume of 0 m³, expected sizes in metres");
  write("far.urdf",
        "<robot name='r'><link name='a'/><link name='b'/><joint name='j' type='fixed'><origin xyz='1e300 0 0'/><parent link='a'/>"
        "<child link='b'/></joint></robot>");
  EXPECT_EQ(message("robots: [{name: r, urdf: far.urdf}]"), "far.urdf:1: origin xyz: got '1e300 0 0', expected 3 finite numbers");
}

TEST_F(BadInput, EmptyFile_IsNamedByItsFirstLine) {
  EXPECT_EQ(message(""), "scene.yaml:1: top level: got nothing, expected a map");
  EXPECT_EQ(message("# to do\n"), "scene.yaml:1: top level: got nothing, expected a map");
}

TEST_F(BadInput, KeyTwice_IsNamed) { EXPECT_EQ(message("name: a\nname: b\n"), "scene.yaml:2: name: got this key twice, expected it once"); }

TEST_F(BadInput, MissingKey_IsNamed) {
  EXPECT_EQ(message("objects:\n  - name: ball\n    joint: free\n    shapes: [{sphere: {radius: 0.1}}]\n"),
            "scene.yaml:2: objects[0].mass: got nothing, expected this key");
  EXPECT_EQ(message(arm("")), "");  // a stiffness has a default
}

TEST_F(BadInput, WrongType_IsNamed) {
  EXPECT_EQ(message("gravity: down\n"), "scene.yaml:1: gravity: got 'down', expected a list of 3 numbers");
  EXPECT_EQ(message("gravity: [0, 0]\n"), "scene.yaml:1: gravity: got a list of 2, expected a list of 3 numbers");
  EXPECT_EQ(message("gravity: [0, 0, \"1\"]\n"), "scene.yaml:1: gravity[2]: got '1', expected a number");
  EXPECT_EQ(message("max_contacts: 2.5\n"), "scene.yaml:1: max_contacts: got 2.5, expected an integer");
  EXPECT_EQ(message("robots: arm\n"), "scene.yaml:1: robots: got 'arm', expected a list");
  EXPECT_EQ(message("- 1\n"), "scene.yaml:1: top level: got a list of 1, expected a map");
  EXPECT_EQ(message("objects:\n  - name: ball\n    joint: floating\n    mass: 1\n    shapes: [{sphere: {radius: 1}}]\n"),
            "scene.yaml:3: objects[0].joint: got 'floating', expected one of free, planar_xy, planar_yz, planar_xz, hinge, slider");
}

TEST_F(BadInput, NumbersThatAreNotFinite_AreNamed) {
  EXPECT_EQ(message("gravity: [0, .nan, 0]\n"), "scene.yaml:1: gravity[1]: got .nan, expected a finite number");
  EXPECT_EQ(message("contact_distance: .inf\n"), "scene.yaml:1: contact_distance: got .inf, expected a finite number");
  EXPECT_EQ(message("contact_distance: 1e999\n"), "scene.yaml:1: contact_distance: got 1e999, expected a finite number");
}

TEST_F(BadInput, NegativeMassStiffnessFrictionAndSizes_AreNamed) {
  EXPECT_EQ(message("objects:\n  - name: ball\n    joint: free\n    mass: -1\n    shapes: [{sphere: {radius: 0.1}}]\n"),
            "scene.yaml:4: objects[0].mass: got -1, expected a number > 0");
  EXPECT_EQ(message("objects:\n  - name: ball\n    joint: free\n    mass: 1\n    shapes: [{sphere: {radius: 0}}]\n"),
            "scene.yaml:5: objects[0].shapes[0].sphere.radius: got 0, expected a number > 0");
  EXPECT_EQ(message("objects:\n  - name: ball\n    joint: free\n    mass: 1\n    shapes: [{box: {size: [1, -1, 1]}}]\n"),
            "scene.yaml:5: objects[0].shapes[0].box.size: got 1, -1, 1, expected three numbers > 0");
  EXPECT_EQ(message(arm("    stiffness: -3\n")), "scene.yaml:4: robots[0].stiffness: got -3, expected a number > 0");
  EXPECT_EQ(message(arm("    stiffness: {elbow: 0}\n")), "scene.yaml:4: robots[0].stiffness.elbow: got 0, expected a number > 0");
  EXPECT_EQ(message(arm("    stiffness: 1\n    friction: -0.1\n")), "scene.yaml:5: robots[0].friction: got -0.1, expected a number ≥ 0");
  EXPECT_EQ(message(ball("    inertia: [1, 0, 1]\n")), "scene.yaml:6: objects[0].inertia: got 1, 0, 1, expected three numbers > 0");
}

TEST_F(BadInput, QuaternionThatIsNotUnit_IsNamed) {
  EXPECT_EQ(message(arm("    stiffness: 1\n    base: {quaternion_wxyz: [1, 1, 0, 0]}\n")),
            "scene.yaml:5: robots[0].base.quaternion_wxyz: got a quaternion of length 1.41421, expected length 1");
  EXPECT_EQ(message(arm("    stiffness: 1\n    base: {quaternion_wxyz: [1, 0, 0, 0], rpy: [0, 0, 0]}\n")),
            "scene.yaml:5: robots[0].base.rpy: got rpy beside quaternion_wxyz, expected one of the two");
}

TEST_F(BadInput, UnknownNames_AreNamedWithAHint) {
  EXPECT_EQ(message(arm("    stiffness: {elbw: 1}\n")),
            "scene.yaml:4: robots[0].stiffness.elbw: got unknown joint 'elbw', expected one of elbow; did you mean 'elbow'?");
  EXPECT_EQ(message(arm("    stiffness: 1\n    link_friction: {tipp: 1}\n")),
            "scene.yaml:5: robots[0].link_friction.tipp: got unknown link 'tipp', expected one of base, tip; did you mean 'tip'?");
  EXPECT_EQ(
      message(ball("filters:\n  - exclude: [ball, bal]\n")),
      "scene.yaml:7: filters[0].exclude[1]: got unknown body or geometry 'bal', expected one of ball, ball/sphere_0; did you mean 'ball'?");
  const auto model = Model::make(load_scene(write("good.yaml", arm("    stiffness: 1\n"))));
  EXPECT_EQ(message_of([&] { static_cast<void>(model->joint_index("wrist")); }),
            "joint: got unknown name 'wrist', expected one of arm/elbow");
  EXPECT_EQ(message_of([&] { static_cast<void>(model->object_index("cup")); }),
            "object: got unknown name 'cup', expected none (there are none)");
}

TEST_F(BadInput, NamesTwice_AreNamed) {
  EXPECT_EQ(message(ball("  - name: ball\n    joint: free\n    mass: 1\n    shapes: [{sphere: {radius: 0.1}}]\n")),
            "scene.yaml:6: objects[1].name: got 'ball' twice, expected each name once");
  EXPECT_EQ(message("objects:\n  - {name: a/b, joint: free, mass: 1, shapes: [{sphere: {radius: 1}}]}\n"),
            "scene.yaml:2: objects[0].name: got 'a/b', expected a name without '/', '*' or spaces");
}

TEST_F(BadInput, UrdfThatIsMissingOrMalformed_IsNamed) {
  EXPECT_EQ(message("robots:\n  - name: arm\n    urdf: no.urdf\n    stiffness: 1\n"),
            "scene.yaml:3: robots[0].urdf: got 'no.urdf', which does not exist, expected a URDF file, or its text");
  write("arm.urdf", "<robot name='arm'>\n  <link name='a'>\n</robot>\n");
  EXPECT_EQ(message(arm("    stiffness: 1\n")), "arm.urdf:2: urdf: got malformed XML (XML_ERROR_MISMATCHED_ELEMENT), expected a URDF");
  write("arm.urdf", "<model/>\n");
  EXPECT_EQ(message(arm("    stiffness: 1\n")), "arm.urdf:1: root element: got 'model', expected 'robot'");
  write("arm.urdf", "<robot name='arm'>\n</robot>\n");
  EXPECT_EQ(message(arm("    stiffness: 1\n")), "arm.urdf:1: robot: got no link, expected at least one");
  write("arm.urdf", "<robot name='arm' xmlns:xacro='http://www.ros.org/wiki/xacro'/>\n");
  EXPECT_EQ(message(arm("    stiffness: 1\n")),
            "arm.urdf:1: robot: got no link, in a file of xacro, expected the URDF that xacro makes of it");
  write("arm.urdf", "<robot name='arm' xmlns:xacro='http://www.ros.org/wiki/xacro'><xacro:arm/></robot>\n");
  const std::string refused = "expected the URDF that xacro makes of it: xacro arm.urdf > robot.urdf";
  EXPECT_EQ(message(arm("    stiffness: 1\n")), "arm.urdf:1: robot: got 'xacro:arm', so an xacro file, " + refused);
  write("arm.urdf",
        "<robot name='arm'>\n<link name='a'><collision><geometry>\n<xacro:ball r='${r}'/></geometry></collision></link></robot>\n");
  EXPECT_EQ(message(arm("    stiffness: 1\n")), "arm.urdf:3: robot: got 'xacro:ball', so an xacro file, " + refused);
}

TEST_F(BadInput, UrdfAsExportersWriteIt_IsTaken) {
  const std::string ball = "<collision name='c'><geometry><sphere radius='0.1'/></geometry></collision>";
  write("arm.urdf", "<robot name='arm'><link name='a'/><link name='b'>" + ball + ball + ball +
                        "</link><joint name='j' type='revolute'><parent link='a'/><child link='b'/><limit effort='1' "
                        "velocity='1'/></joint></robot>");
  const auto model = Model::make(load_scene(write("scene.yaml", arm("    stiffness: 1\n"))));
  ASSERT_EQ(model->geometries().size(), 3u);
  EXPECT_EQ(model->geometries()[0].name, "arm/b/c");
  EXPECT_EQ(model->geometries()[1].name, "arm/b/c_1");
  EXPECT_EQ(model->geometries()[2].name, "arm/b/c_2");
  EXPECT_EQ(model->n_a(), 1);
}

TEST_F(BadInput, MjcfRobots_TakeOnlyWhatTheirFileDoesNotSay) {
  const auto robot = [](const std::string& more) { return "robots:\n  - name: arm\n    mjcf: arm.xml\n" + more; };
  EXPECT_EQ(message(robot("")), "scene.yaml:3: robots[0].mjcf: got 'arm.xml', which does not exist, expected an MJCF file, or its text");
  write("arm.xml", R"(<mujoco><worldbody><body name="b"><joint name="j"/><geom size="1"/></body></worldbody></mujoco>)");
  EXPECT_EQ(message(robot("")), "");
  EXPECT_EQ(message(robot("    stiffness: {j: 3}\n")), "");
  EXPECT_EQ(message(robot("    stiffness: 3\n")), "");
  EXPECT_EQ(message(robot("    stiffness: {k: 3}\n")),
            "scene.yaml:4: robots[0].stiffness.k: got unknown joint 'k', expected one of j; did you mean 'j'?");
  EXPECT_EQ(message(robot("    stiffness: 3\n    friction: 1\n")),
            "scene.yaml:5: robots[0].friction: got friction beside mjcf, expected it only for URDF robots");
  EXPECT_EQ(message(robot("    stiffness: 3\n    urdf: arm.urdf\n")),
            "scene.yaml:5: robots[0].urdf: got urdf beside mjcf, expected it only for URDF robots");
}

TEST_F(BadInput, UrdfContent_IsNamedWithItsLine) {
  const auto with_joint = [&](const std::string& joint) {
    write("arm.urdf", "<robot name='arm'>\n<link name='a'/>\n<link name='b'/>\n" + joint + "\n</robot>\n");
    return message(arm("    stiffness: 1\n"));
  };
  EXPECT_EQ(with_joint("<joint name='j' type='floating'><parent link='a'/><child link='b'/></joint>"),
            "arm.urdf:4: joint 'j': got type 'floating', expected revolute, continuous, prismatic or fixed");
  EXPECT_EQ(with_joint("<joint name='j' type='continuous'><parent link='a'/><child link='b'/><mimic joint='k'/></joint>"),
            "arm.urdf:4: joint 'j': got unknown joint 'k' to mimic, expected a joint");
  EXPECT_EQ(with_joint("<joint name='j' type='continuous'><parent link='a'/><child link='b'/><mimic joint='j'/></joint>"),
            "arm.urdf: robot: got joint 'j', which follows itself, expected a leader that moves by itself");
  EXPECT_EQ(with_joint("<joint name='j' type='continuous'><parent link='a'/><child link='b'/>\n<axis xyz='0 0 0'/></joint>"),
            "arm.urdf:5: joint 'j': got axis 0 0 0, expected an axis other than 0");
  EXPECT_EQ(with_joint("<joint name='j' type='continuous'><parent link='a'/><child link='b'/>\n<origin xyz='0 0 nan'/></joint>"),
            "arm.urdf:5: origin xyz: got '0 0 nan', expected 3 finite numbers");
  EXPECT_EQ(with_joint("<joint name='j' type='continuous'><parent link='a'/><child link='bb'/></joint>"),
            "arm.urdf:4: joint 'j': got unknown link 'bb', expected one of a, b; did you mean 'b'?");
  EXPECT_EQ(with_joint(""), "arm.urdf:1: robot: got 2 links without a parent: a, b, expected one");
  EXPECT_EQ(with_joint("<joint name='j' type='fixed'><parent link='b'/><child link='a'/></joint>\n<joint name='k' type='fixed'><parent "
                       "link='a'/><child link='b'/></joint>"),
            "arm.urdf:1: robot: got links that form a circle, expected a tree");
}

TEST_F(BadInput, Meshes_AreNamed) {
  const auto with_mesh = [&](const std::string& uri) {
    write("arm.urdf", "<robot name='arm'>\n<link name='a'><collision><geometry>\n<mesh filename='" + uri +
                          "'/></geometry></collision></link>\n</robot>\n");
    return message(arm("    stiffness: 1\n"));
  };
  EXPECT_EQ(with_mesh("package://nowhere/a.stl"),
            "arm.urdf:3: mesh filename: got 'package://nowhere/a.stl', which is nowhere, expected a file that exists (package:// is looked "
            "for in package_dirs and above the URDF)");
  write("a.ply", "x");
  EXPECT_EQ(with_mesh("a.ply"), "arm.urdf:3: mesh: a.ply: mesh: got '.ply', expected .stl, .obj or .dae");
  write("a.obj", "v 0 0 0\nf 1 2 3\n");
  EXPECT_EQ(with_mesh("a.obj").substr(0, 62), "arm.urdf:3: mesh: a.obj: mesh: got a file that cannot be read ");
  write("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  EXPECT_EQ(with_mesh("a.obj"), "arm.urdf:3: mesh: a.obj: mesh: got 1 triangles, expected a closed convex mesh");
  write("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 3\nf 2 3 4\nf 1 2 4\nf 1 3 4\n");
  EXPECT_EQ(with_mesh("a.obj"), "arm.urdf:3: mesh: a.obj: mesh: got a flat mesh, expected a body with a volume");
  EXPECT_EQ(message("fixed:\n  - name: rock\n    shapes:\n      - mesh: {file: rock.stl}\n"),
            "scene.yaml:4: fixed[0].shapes[0].mesh.file: got 'rock.stl', which does not exist, expected a mesh file");
}

TEST_F(BadInput, ObjectsThatMakeNoSense_AreNamed) {
  EXPECT_EQ(message(ball("    pose: {position: [0, 0, 1]}\n")),
            "scene.yaml:6: objects[0].pose: got pose of a free object, expected none (where it starts is part of the start)");
  EXPECT_EQ(message(ball("    axis: [0, 0, 1]\n")),
            "scene.yaml:6: objects[0].axis: got axis of a free object, expected it only for hinge and slider objects");
  EXPECT_EQ(
      message(ball("    inertia: [0.8333, 0.01, 0.01]\n")),
      "scene.yaml:6: objects[0].inertia: got 0.8333, 0.01, 0.01, expected moments that a body can have: none larger than the other two "
      "together");
  EXPECT_EQ(message(ball("    inertia: [0.02, 0.01, 0.01]\n")), "");  // a thin rod
  EXPECT_EQ(message("objects:\n  - name: part\n    joint: free\n    mass: 1\n    shapes: [{half_space: {}}]\n"),
            "scene.yaml:5: objects[0].shapes[0].half_space: got a half-space, expected a shape with a finite volume (half-spaces are for "
            "fixed bodies)");
  EXPECT_EQ(
      message("objects:\n  - name: part\n    joint: free\n    mass: 1\n    shapes: [{sphere: {radius: 1}, box: {size: [1, 1, 1]}}]\n"),
      "scene.yaml:5: objects[0].shapes[0]: got 2 shapes, expected exactly one of sphere, box, capsule, cylinder, ellipsoid, mesh, "
      "half_space");
}

TEST_F(BadInput, FilesThatCannotBeRead_AreNamed) {
  EXPECT_EQ(message_of([&] { load_scene(dir_ / "none.yaml"); }), "none.yaml: file: got no file of this name, expected a YAML file");
  EXPECT_EQ(message("a: [1, 2\n").substr(0, 40), "scene.yaml:2: file: got malformed YAML (");
  EXPECT_EQ(message("base: other.yaml\n").substr(0, 47), "scene.yaml:1: base: got 'other.yaml', expected ");
  EXPECT_EQ(message("base: scene.yaml\n"), "scene.yaml:1: base: got 'scene.yaml', expected a file that does not lead back to this one");
}

TEST_F(BadInput, XmlInPlaceOfYaml_SaysWhatToDoWithIt) {
  EXPECT_EQ(message("\n<mujoco model='hand: right'>\n</mujoco>\n"),
            "scene.yaml:1: file: got XML, expected YAML: `stiction import` makes a task of a whole scene in MJCF, URDF or SDF, and a scene "
            "names the file of a robot as `mjcf` or `urdf`");
}

TEST_F(BadInput, LongTexts_AreShortenedBetweenTwoCharacters) {
  std::string text;
  for (int i = 0; i < 60; ++i) text += "\xC3\xA9";
  EXPECT_EQ(message("gravity: x" + text + "\n"),
            "scene.yaml:1: gravity: got 'x" + text.substr(0, 98) + " …', expected a list of 3 numbers");
}

TEST_F(BadInput, YamlThatIsNotUtf8_IsNamedWithItsLine) {
  const auto with_name = [&](const std::string& name) { return message("gravity: [0, 0, 0]\nname: " + name + "\n"); };
  EXPECT_EQ(with_name("pouss\xC3\xA9"
                      "e \xE2\x82\xAC \xF0\x9F\xA6\xBE"),
            "");
  const std::string refused = "scene.yaml:2: file: got bytes that are not UTF-8, expected text in UTF-8";
  EXPECT_EQ(with_name("pouss\xE9"
                      "e"),
            refused);                                 // Latin-1
  EXPECT_EQ(with_name("\xC3"), refused);              // cut off
  EXPECT_EQ(with_name("\xC0\xAF"), refused);          // longer than it has to be
  EXPECT_EQ(with_name("\xED\xA0\x80"), refused);      // half of a UTF-16 pair
  EXPECT_EQ(with_name("\xF4\x90\x80\x80"), refused);  // behind the last character
}

TEST_F(BadInput, SeveralFaults_AreNamedInOneRun) {
  EXPECT_EQ(
      message("gravity: [0, 0]\ncontact: 3\nobjects:\n"
              "  - {name: a, joint: free, mass: -1, shapes: [{sphere: {radius: 0}}, {ball: {}}]}\n"
              "  - {name: b, joint: free, mass: 1, shapes: [{box: {size: [1, 1, 1]}}], colour: red, weight: 2}\n"
              "  - {name: c, parent: a, joint: hinge, axis: [0, 0, 1], mass: 1, shapes: [{sphere: {radius: 0.1}}]}\n"
              "fixed:\n  - {name: d, shapes: [{sphere: {}}]}\n"),
      "scene.yaml:2: contact: got an unknown key, expected one of name, file, robot, gravity, contact_distance, max_contacts, "
      "robots, objects, "
      "fixed, places, filters\n"
      "scene.yaml:1: gravity: got a list of 2, expected a list of 3 numbers\n"
      "scene.yaml:4: objects[0].shapes[0].sphere.radius: got 0, expected a number > 0\n"
      "scene.yaml:4: objects[0].shapes[1].ball: got an unknown key, expected one of name, pose, friction, torsional_friction, "
      "rolling_friction, max_force, sphere, box, capsule, cylinder, ellipsoid, mesh, half_space\n"
      "scene.yaml:4: objects[0].mass: got -1, expected a number > 0\n"
      "scene.yaml:5: objects[1].colour: got an unknown key, expected one of name, parent, joint, axis, pose, mass, inertia, "
      "center_of_mass, friction, torsional_friction, rolling_friction, max_force, limits, joint_friction, joint_damping, joint_stiffness, "
      "joint_rest, shapes\n"
      "scene.yaml:5: objects[1].weight: got an unknown key, expected one of name, parent, joint, axis, pose, mass, inertia, "
      "center_of_mass, friction, torsional_friction, rolling_friction, max_force, limits, joint_friction, joint_damping, joint_stiffness, "
      "joint_rest, shapes\n"
      "scene.yaml:8: fixed[0].shapes[0].sphere.radius: got nothing, expected this key");
  write("arm.urdf",
        "<robot name='arm'>\n<link name='a'><collision><geometry><sphere radius='-1'/></geometry></collision></link>\n"
        "<link name='b'><collision><geometry><mesh filename='no.stl'/></geometry></collision></link>\n"
        "<joint name='j' type='ball'><parent link='a'/><child link='b'/></joint>\n"
        "<joint name='k' type='fixed'><parent link='a'/><child link='c'/></joint>\n</robot>\n");
  EXPECT_EQ(message(arm("    stiffness: 1\n")),
            "arm.urdf:2: sphere radius: got -1, expected a number > 0, or 0 for no shape\n"
            "arm.urdf:3: mesh filename: got 'no.stl', which is nowhere, expected a file that exists (package:// is looked for in "
            "package_dirs and above the URDF)\n"
            "arm.urdf:4: joint 'j': got type 'ball', expected revolute, continuous, prismatic or fixed\n"
            "arm.urdf:5: joint 'k': got unknown link 'c', expected one of a, b; did you mean 'a'?");
}

TEST_F(BadInput, YamlIndentedByTabs_NamesTheLine) {
  const std::string refused = "got a tab in front of a line, expected spaces: YAML indents with them alone";
  EXPECT_EQ(message("gravity: [0, 0, 0]\nobjects:\n\t- name: ball\n"), "scene.yaml:3: file: " + refused);
  EXPECT_EQ(message("gravity: [0, 0, 0]\nobjects:\n  - name: ball\n  \tmass: 1\n"), "scene.yaml:4: file: " + refused);
  EXPECT_EQ(message("gravity: [0,\t0, 0]\n"), "") << "tabs between values are YAML";
  EXPECT_NE(message("gravity: [0, 0\nname:\ta\n").find("malformed YAML"), std::string::npos) << "not the tab's fault";
}

TEST_F(BadInput, YamlAliasesOfAliases_AreRefusedBeforeTheyFillMemory) {
  std::string text = "a: &a [x, x, x, x, x, x, x, x, x]\n";
  for (char c = 'b'; c <= 'i'; ++c) {
    text += std::string(1, c) + ": &" + c + " [";
    for (int k = 0; k < 9; ++k) text += std::string(k ? ", *" : "*") + static_cast<char>(c - 1);
    text += "]\n";
  }
  const std::string said = message(text);
  EXPECT_TRUE(said.starts_with("scene.yaml:")) << said;
  EXPECT_NE(said.find("got aliases that stand for more than 32 values a character, expected fewer"), std::string::npos) << said;
  EXPECT_EQ(message("objects:\n  - &ball {name: a, joint: free, mass: 1, shapes: [{sphere: {radius: 0.1}}]}\nfixed: []\n"), "");
}

TEST_F(BadInput, UrdfInLatin1_IsReadWhereItSaysSo) {
  const auto with_encoding = [&](const std::string& declaration) {
    write("arm.urdf", declaration + "\n<robot name='arm'><link name='b\xE4ll'/></robot>\n");
    return arm("    stiffness: 1\n");
  };
  for (const char* name : {"ISO-8859-1", "latin1"}) {
    const fs::path file = write("scene.yaml", with_encoding(std::string("<?xml version=\"1.0\" encoding=\"") + name + "\"?>"));
    EXPECT_EQ(Model::make(load_scene(file))->bodies()[0].name, "arm/b\xC3\xA4ll");
  }
  EXPECT_EQ(message(with_encoding("<?xml version='1.0' encoding='utf-8'?>")),
            "arm.urdf:2: urdf: got bytes that are not UTF-8, expected UTF-8, or ISO-8859-1 with a declaration that says so");
}

TEST_F(BadInput, SceneMadeInMemory_IsCheckedAsWell) {
  const auto of = [&](auto&& change) {
    Scene scene = test::make_zoo();
    change(scene);
    return message_of([&] { Model::make(scene); });
  };
  EXPECT_EQ(of([](Scene&) {}), "");
  EXPECT_EQ(of([](Scene& s) { s.objects[2].mass = -1; }), "objects[2]: mass: got -1, expected a finite number > 0");
  EXPECT_EQ(of([](Scene& s) { s.objects[0].inertia(0, 0) = -1; }),
            "objects[0]: inertia: got a matrix that is not symmetric positive definite, expected one that is");
  EXPECT_EQ(of([](Scene& s) { s.gravity[0] = std::numeric_limits<double>::quiet_NaN(); }),
            "scene: gravity[0]: got nan, expected a finite number");
  EXPECT_EQ(of([](Scene& s) { s.robots[0].stiffness.back().second = 0; }),
            "robots[0]: stiffness.a_right: got 0, expected a finite number > 0");
  EXPECT_EQ(of([](Scene& s) { s.rest = {0, 0}; }), "scene: rest: got 2 numbers, expected 5");
  EXPECT_EQ(of([](Scene& s) { s.robots[0].X_WBase.R *= 2; }), "robots[0]: base: got no rigid transform, expected one");
  EXPECT_EQ(of([](Scene& s) { s.objects[1].geometries[0].shape = HalfSpace{}; }),
            "objects[1]: ball: got a half-space, expected half-spaces on fixed bodies only");
  EXPECT_EQ(of([](Scene& s) {
              s.filters.push_back({"flor", "*", std::nullopt});
            }).substr(0, 57),
            "filters[0]: name: got unknown body or geometry 'flor', ex");
}

}  // namespace
}  // namespace stiction::world
