// Files that are no robots, where a robot is asked for.
#include <gtest/gtest.h>

#include <sstream>

#include "stiction/world/encoding.hpp"
#include "stiction/world/urdf.hpp"
#include "world/robot_files.hpp"

namespace stiction::world::test {
namespace {

TEST(ForeignXml, UnderUrdf_IsRefusedByName) {
  const RobotFolder folder;
  const auto message = [&](const std::string& text) {
    folder.write("r.urdf", text);
    return folder.message("urdf: r.urdf");
  };
  for (const char* empty : {"", "\n", "<?xml version='1.0'?>", "<!-- to be written -->"})
    EXPECT_EQ(message(empty), "r.urdf: urdf: got no element, expected 'robot'") << "'" << empty << "'";
  EXPECT_EQ(message("<sdf version='1.9'/>"),
            "r.urdf:1: root element: got 'sdf', so an SDF, expected 'robot', the root of a URDF; `stiction import r.urdf -o NEW.yaml` "
            "makes an MJCF of it, NEW.xml");
  EXPECT_EQ(message("\n<!doctype HTML>\n<HTML><img src=x></HTML>"),
            "r.urdf:1: urdf: got a web page, expected a URDF; download the file itself");
  EXPECT_EQ(message("<COLLADA/>"),
            "r.urdf:1: root element: got 'COLLADA', so a mesh, expected 'robot', the root of a URDF; a mesh is named in the file "
            "of a robot");
  EXPECT_EQ(message("<plan/>"), "r.urdf:1: root element: got 'plan', expected 'robot'");
  EXPECT_EQ(message("<robot name='r'/>"), "r.urdf:1: robot: got no link, expected at least one");
  EXPECT_EQ(message("version https://git-lfs.github.com/spec/v1\noid sha256:1\n"),
            "r.urdf:1: urdf: got a pointer of Git LFS, expected a URDF; `git lfs pull` fetches the file itself");
  EXPECT_EQ(message("scene: {file: r.xml}"), "r.urdf:1: urdf: got a text that is no XML, expected a URDF");
}

TEST(ForeignXml, UnderMjcf_IsRefusedByName) {
  const RobotFolder folder;
  const auto message = [&](const std::string& text) {
    folder.write("r.xml", text);
    return folder.message("mjcf: r.xml");
  };
  for (const char* empty : {"", "<?xml version='1.0'?>", "<!-- to be written -->"})
    EXPECT_EQ(message(empty), "r.xml: mjcf: got no element, expected 'mujoco'") << "'" << empty << "'";
  EXPECT_EQ(message("<robot name='r'><link name='a'/></robot>"),
            "r.xml:1: root element: got 'robot', so a URDF, expected 'mujoco', the root of an MJCF; a URDF stands under the key "
            "urdf");
  EXPECT_EQ(message("<html/>"),
            "r.xml:1: root element: got 'html', so a web page, expected 'mujoco', the root of an MJCF; download the file itself");
  EXPECT_EQ(message("<mujocoinclude/>"),
            "r.xml:1: root element: got 'mujocoinclude', so a part of an MJCF, expected 'mujoco', the root of an MJCF; the MJCF "
            "that includes it stands under the key mjcf");
  EXPECT_EQ(message("<mujoco>\n<worldbody"), "r.xml:2: mjcf: got malformed XML (XML_ERROR_PARSING_ELEMENT), expected an MJCF");
}

TEST(ForeignXml, RootElement_IsReadNoFurther) {
  const auto root = [](const std::string& text) {
    std::istringstream in(text);
    return find_root(in);
  };
  EXPECT_EQ(root("<robot name='r'><link"), "robot") << "what follows may be anything";
  EXPECT_EQ(root("\xEF\xBB\xBF<?xml version='1.0'?>\n<!-- <sdf> -- > --><!DOCTYPE robot [<!ENTITY a '<b>'>]>\n<mujoco\tmodel='m'/>"),
            "mujoco");
  EXPECT_EQ(root("<!><sdf>"), "sdf");
  for (const char* none : {"", "solid cube", "<?xml version='1.0'?>", "<!-- <robot>", "<!DOCTYPE robot"}) EXPECT_EQ(root(none), "") << none;
}

TEST(ForeignXml, UrdfFile_IsKnownByItsRootElement) {
  const RobotFolder folder;
  const auto is = [&](const char* name, const std::string& text) { return is_urdf(folder.write(name, text)); };
  EXPECT_TRUE(is("r.xml", "<robot name='r'/>"));
  EXPECT_FALSE(is("r.urdf", "<mujoco/>"));
  EXPECT_TRUE(is("r.urdf", "")) << "nothing but the ending tells";
  EXPECT_FALSE(is("r.xml", ""));
}

}  // namespace
}  // namespace stiction::world::test
