// Robots that a scene has as a text in place of a file.
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>
#include <tuple>

#include "stiction/core/invalid_input.hpp"
#include "stiction/world/model.hpp"
#include "stiction/world/read.hpp"
#include "support/temporary_folder.hpp"

namespace stiction::world {
namespace {

namespace fs = std::filesystem;

constexpr const char* kElbow = R"(<robot name="arm">
  <link name="base"/>
  <link name="tip"><collision><geometry><mesh filename="meshes/tip.obj"/></geometry></collision></link>
  <joint name="elbow" type="revolute"><parent link="base"/><child link="tip"/><axis xyz="0 0 1"/>
    <limit lower="-1" upper="1" effort="5" velocity="2"/></joint>
</robot>
)";

constexpr const char* kElbowMjcf = R"(<mujoco model="arm"><compiler meshdir="meshes"/>
  <include file="assets.xml"/>
  <worldbody><body name="tip"><joint name="elbow" axis="0 0 1" range="-57 57"/><geom type="mesh" mesh="tip"/></body></worldbody>
</mujoco>
)";

class RobotText : public testing::Test {
 protected:
  void SetUp() override {
    fs::create_directories(dir_ / "meshes");
    write("meshes/tip.obj", "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nv 0 0 0.1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n");
    write("assets.xml", "<mujoco><asset><mesh name='tip' file='tip.obj'/></asset></mujoco>");
    write("arm.urdf", kElbow);
    write("arm.xml", kElbowMjcf);
  }

  void write(const std::string& name, const std::string& text) const { std::ofstream(dir_ / name, std::ios::binary) << text; }

  static std::string scene_of(const std::string& key, std::string text, const std::string& more = "") {
    std::string quoted;
    for (const char c : text) quoted += c == '"' ? "\\\"" : c == '\n' ? "\\n" : std::string(1, c);
    return "{\"robots\": [{\"name\": \"arm\", \"" + key + "\": \"" + quoted + "\"" + more + "}]}";
  }

  std::shared_ptr<const Model> make(const std::string& key, const std::string& text) const {
    return Model::make(parse_scene(scene_of(key, text), dir_));
  }

  std::string message(const std::string& key, const std::string& text, const std::string& more = "") const {
    try {
      (void)Model::make(parse_scene(scene_of(key, text, more), dir_));
    } catch (const core::InvalidInput& e) {
      return e.what();
    }
    return "";
  }

  const stiction::test::TemporaryFolder temporary_;
  const std::filesystem::path& dir_ = temporary_.path();
};

TEST_F(RobotText, IsTheRobotOfTheFile) {
  for (const auto& [key, text, file] : {std::tuple{"urdf", kElbow, "arm.urdf"}, std::tuple{"mjcf", kElbowMjcf, "arm.xml"}}) {
    const auto of_text = make(key, text), of_file = make(key, file);
    ASSERT_EQ(of_text->n_a(), 1) << key;
    EXPECT_EQ(of_text->dofs()[0].name, of_file->dofs()[0].name);
    EXPECT_EQ(of_text->lower(), of_file->lower());
    EXPECT_EQ(of_text->effort(), of_file->effort());
    ASSERT_EQ(of_text->geometries().size(), 1u) << key;
    EXPECT_EQ(std::get<Mesh>(of_text->geometries()[0].shape).mesh->vertices, std::get<Mesh>(of_file->geometries()[0].shape).mesh->vertices);
    EXPECT_EQ(of_text->speed_limit(), of_file->speed_limit());
  }
  EXPECT_EQ(make("urdf", kElbow)->speed_limit()[0], 2);
}

TEST_F(RobotText, MayStandInAYamlFile) {
  std::string text = "robots:\n  - name: arm\n    urdf: |\n";
  std::istringstream lines(kElbow);
  for (std::string line; std::getline(lines, line);) text += "      " + line + "\n";
  write("scene.yaml", text);
  const auto model = Model::make(load_scene(dir_ / "scene.yaml"));
  EXPECT_EQ(model->dofs()[0].name, "arm/elbow");
}

TEST_F(RobotText, PackagesAreLookedUpAsInAFile) {
  std::string text = kElbow;
  const std::string relative = "meshes/tip.obj";
  fs::create_directories(dir_ / "pkg");
  text.replace(text.find(relative), relative.size(), "package://meshes/tip.obj");
  EXPECT_EQ(make("urdf", text)->geometries().size(), 1u);  // a folder above what the text's paths are relative to
  text.replace(text.find("package://meshes"), 16, "package://my_arm");
  EXPECT_EQ(
      message("urdf", text),
      "robots[0].urdf: text:3: mesh filename: got 'package://my_arm/tip.obj', which is nowhere, expected a file that exists (package:// is "
      "looked for in package_dirs and above '" +
          dir_.string() + "', which paths in this text are relative to)");
  fs::create_directories(dir_ / "other" / "my_arm");
  fs::copy(dir_ / relative, dir_ / "other" / "my_arm" / "tip.obj");
  EXPECT_EQ(message("urdf", text, R"(, "package_dirs": ["other"])"), "");
}

TEST_F(RobotText, MistakesAreSaidWithTheirKeyAndLine) {
  EXPECT_EQ(message("urdf", "<robot name='arm'>\n<link name='a'/>\n<link name='a'/>\n<link/></robot>"),
            "robots[0].urdf: text:3: link name: got 'a' twice, expected each name once\n"
            "robots[0].urdf: text:4: link: got no attribute name, expected one");
  EXPECT_EQ(message("urdf", "\n <robot>\n<link"),
            "robots[0].urdf: text:3: urdf: got malformed XML (XML_ERROR_PARSING_ELEMENT), expected a URDF");
  EXPECT_EQ(message("urdf", "<!-- nothing -->"), "robots[0].urdf: text: urdf: got no element, expected 'robot'");
  EXPECT_EQ(
      message("urdf", kElbowMjcf),
      "robots[0].urdf: text:1: root element: got 'mujoco', so an MJCF, expected 'robot', the root of a URDF; an MJCF stands under the key "
      "mjcf");
  EXPECT_EQ(message("urdf", "<robot><xacro:arm/></robot>"),
            "robots[0].urdf: text:1: robot: got 'xacro:arm', so an xacro file, expected the URDF that xacro makes of it");
  EXPECT_EQ(
      message("mjcf", "<mujoco><bad/></mujoco>"),
      "robots[0].mjcf: text: mjcf: got 'XML Error: Schema violation: unrecognized element Element 'bad', line 1', expected a file that "
      "MuJoCo compiles");
  EXPECT_EQ(message("urdf", "robot:\n  links: []"),
            "robots[0].urdf: got 'robot:…', which does not exist, expected a URDF file, or its text");
  EXPECT_EQ(message("urdf", std::string(5000, 'a')),
            "robots[0].urdf: got '" + std::string(80, 'a') + "…', which does not exist, expected a URDF file, or its text");
}

TEST_F(RobotText, LargerThanAnyRobotIsRefused) {
  const std::string large = "<!--" + std::string(std::size_t{16} << 20, ' ') + "-->" + kElbow;
  EXPECT_EQ(message("urdf", large),
            "robots[0].urdf: got a text of " + std::to_string(large.size()) + " bytes, expected 16777216 bytes at most, or a file");
}

}  // namespace
}  // namespace stiction::world
