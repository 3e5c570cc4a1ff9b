#include "stiction/world/mjcf.hpp"

#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include <algorithm>
#include <fstream>
#include <set>

#include "stiction/core/invalid_input.hpp"
#include "stiction/world/call_mujoco.hpp"
#include "world/test_scenes.hpp"

namespace stiction::world::test {
namespace {

namespace fs = std::filesystem;

struct Delete {
  void operator()(mjModel* model) const { mj_deleteModel(model); }
  void operator()(mjData* data) const { mj_deleteData(data); }
};

fs::path data(const std::string& name) { return source_dir() / "tests/world/data" / name; }

std::string message_of(const fs::path& file) {
  try {
    (void)read_mjcf(file);
  } catch (const core::InvalidInput& e) {
    return e.what();
  }
  return "";
}

/// A file with the given content of <mujoco>.
fs::path write_mjcf(const std::string& content) {
  const fs::path file = fs::path(testing::TempDir()) / "refused.xml";
  std::ofstream(file) << "<mujoco>" << content << "</mujoco>";
  return file;
}

std::string refused(const std::string& content) {
  const std::string message = message_of(write_mjcf(content));
  const auto at = message.find("mjcf: ");
  return at == std::string::npos ? message : message.substr(at);
}

std::shared_ptr<const Model> make_model(const fs::path& file) {
  RobotSpec robot;
  robot.name = "arm";
  robot.mjcf = file;
  for (const auto& joint : read_mjcf(file).robot.joints) {
    if (joint.kind != RobotJoint::Kind::Fixed && !joint.stiffness) robot.stiffness.emplace_back(joint.name, 1.0);
  }
  Scene scene;
  add_mjcf(scene, robot);
  return Model::make(scene);
}

std::string name_of(const mjModel* m, mjtObj type, int id) {
  const char* name = mj_id2name(m, type, id);
  return name != nullptr ? name : "";
}

int body_index(const Model& model, const std::string& name) {
  for (std::size_t i = 0; i < model.bodies().size(); ++i) {
    if (model.bodies()[i].name == name) return static_cast<int>(i);
  }
  return -1;
}

std::string body_name(const mjModel* m, int body) {
  const std::string name = name_of(m, mjOBJ_BODY, body);
  return name.empty() ? "body_" + std::to_string(body) : name;
}

/// Moves every joint of the file at random, in both programs, and compares all bodies.
void compare_kinematics(const fs::path& file) {
  const auto model = make_model(file);
  char error[1000] = "";
  const std::unique_ptr<mjModel, Delete> m(mj_loadXML(file.c_str(), nullptr, error, sizeof(error)));
  ASSERT_NE(m, nullptr) << error;
  const std::unique_ptr<mjData, Delete> d(mj_makeData(m.get()));
  core::Random random(5, 1);
  KinematicsWorkspace work(*model);
  Kinematics kinematics;
  for (int sample = 0; sample < 20; ++sample) {
    for (int i = 0; i < m->nq; ++i) d->qpos[i] = sample == 0 ? m->qpos0[i] : random.normal();
    mj_normalizeQuat(m.get(), d->qpos);
    mj_fwdPosition(m.get(), d.get());
    Eigen::VectorXd q = model->neutral();
    for (int j = 0; j < m->njnt; ++j) {
      const int body = m->jnt_bodyid[j];
      const mjtNum* value = d->qpos + m->jnt_qposadr[j];
      if (m->jnt_type[j] == mjJNT_FREE) {
        const auto& object = model->objects()[static_cast<std::size_t>(model->object_index(body_name(m.get(), body)))];
        q.segment<3>(object.q_begin) = Eigen::Map<const Eigen::Vector3d>(d->subtree_com + 3 * body);
        q.segment<4>(object.q_begin + 3) << value[4], value[5], value[6], value[3];
      } else {
        std::string name = name_of(m.get(), mjOBJ_JOINT, j);
        if (name.empty()) name = body_name(m.get(), body) + "_joint_" + std::to_string(j - m->body_jntadr[body]);
        q[model->n_qu() + model->joint_index(name)] = value[0];
      }
    }
    calc_kinematics(*model, q, work, kinematics);
    for (int body = 1; body < m->nbody; ++body) {
      const std::string name = body_name(m.get(), body);
      const int top = m->body_weldid[body];
      const bool free = top != 0 && m->jnt_type[m->body_jntadr[top]] == mjJNT_FREE;
      if (free && top != body) continue;  // part of its object
      const int index = body_index(*model, free ? name : "arm/" + name);
      ASSERT_GE(index, 0) << name;
      const Pose& X_WB = kinematics.X_WB[static_cast<std::size_t>(index)];
      const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> R(d->xmat + 9 * body);
      const Eigen::Map<const Eigen::Vector3d> p((free ? d->subtree_com : d->xpos) + 3 * body);
      EXPECT_LT((X_WB.R - R).norm(), 1e-9) << name;
      EXPECT_LT((X_WB.p - p).norm(), 1e-9) << name;
      if (free) {
        EXPECT_NEAR(model->objects()[static_cast<std::size_t>(model->object_index(name))].mass, m->body_subtreemass[body], 1e-12);
      }
    }
    // Every geom that collides stands where MuJoCo has it: a mesh by its vertices, whose frame MuJoCo chooses.
    for (int g = 0; g < m->ngeom; ++g) {
      if ((m->geom_contype[g] | m->geom_conaffinity[g]) == 0 || name_of(m.get(), mjOBJ_GEOM, g).empty()) continue;
      const std::string name = "/" + name_of(m.get(), mjOBJ_GEOM, g);
      const auto found = std::find_if(model->geometries().begin(), model->geometries().end(), [&](const Geometry& geometry) {
        return geometry.name.ends_with(name) || geometry.name.ends_with("." + name.substr(1));
      });
      ASSERT_NE(found, model->geometries().end()) << name;
      const Pose X_WG = kinematics.X_WB[static_cast<std::size_t>(found->body)] * found->X_BG;
      EXPECT_LT((X_WG.p - Eigen::Map<const Eigen::Vector3d>(d->geom_xpos + 3 * g)).norm(), 1e-9) << name;
    }
  }
}

TEST(Mjcf, OddModel_StandsWhereMujocoHasIt) { compare_kinematics(data("odd.xml")); }

TEST(Mjcf, OddModel_HasTheJointsStiffnessesAndObjectsOfTheFile) {
  const MjcfModel odd = read_mjcf(data("odd.xml"));
  EXPECT_EQ(odd.robot.name, "odd");
  EXPECT_EQ(odd.robot.movable_joints(), (std::vector<std::string>{"lift", "yaw", "pitch", "elbow", "finger_joint_0"}));
  const auto joint = [&](const std::string& name) {
    return *std::find_if(odd.robot.joints.begin(), odd.robot.joints.end(), [&](const RobotJoint& j) { return j.name == name; });
  };
  EXPECT_DOUBLE_EQ(*joint("lift").stiffness, 500);
  EXPECT_DOUBLE_EQ(*joint("yaw").stiffness, 20 * 9) << "k_p g²";
  EXPECT_DOUBLE_EQ(*joint("pitch").stiffness, 40) << "of its class";
  EXPECT_DOUBLE_EQ(*joint("elbow").stiffness, 7) << "the motor beside it holds nothing";
  EXPECT_FALSE(joint("finger_joint_0").stiffness.has_value());
  EXPECT_NEAR(joint("elbow").upper, 120 * M_PI / 180, 1e-12) << "class and degrees";
  EXPECT_NEAR(joint("yaw").lower, -M_PI / 2, 1e-12);
  EXPECT_EQ(joint("lift").lower, -0.1);
  ASSERT_EQ(odd.objects.size(), 2u);
  EXPECT_EQ(odd.objects[0].name, "cube");
  EXPECT_NEAR(odd.objects[0].mass, 0.4, 1e-12);
  EXPECT_EQ(odd.objects[0].geometries.size(), 2u) << "the welded knob belongs to it";
  EXPECT_EQ(odd.objects[0].geometries[1].name, "knob.sphere_0");
  ASSERT_EQ(odd.fixed.size(), 3u);
  EXPECT_EQ(odd.fixed[0].friction, 0.5);
  EXPECT_TRUE(std::any_of(odd.fixed.begin(), odd.fixed.end(), [](const auto& g) { return g.name == "pedestal.ramp"; }));
  EXPECT_EQ(odd.excludes.size(), 2u);
}

/// The whole object turns about its centre of mass as MuJoCo's body does.
TEST(Mjcf, ObjectOfSeveralBodies_HasTheInertiaOfAll) {
  const MjcfModel odd = read_mjcf(data("odd.xml"));
  char error[1000] = "";
  const std::unique_ptr<mjModel, Delete> m(mj_loadXML(data("odd.xml").c_str(), nullptr, error, sizeof(error)));
  const std::unique_ptr<mjData, Delete> d(mj_makeData(m.get()));
  mj_fwdPosition(m.get(), d.get());
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> M(m->nv, m->nv);
  mj_fullM(m.get(), d.get(), M.data());
  const int v = m->jnt_dofadr[m->body_jntadr[mj_name2id(m.get(), mjOBJ_BODY, "cube")]];
  const Eigen::Matrix3d about_origin = M.block<3, 3>(v + 3, v + 3);
  const int body = mj_name2id(m.get(), mjOBJ_BODY, "cube");
  const Eigen::Vector3d c =
      Eigen::Map<const Eigen::Vector3d>(d->subtree_com + 3 * body) - Eigen::Map<const Eigen::Vector3d>(d->xpos + 3 * body);
  const Eigen::Matrix3d about_com = about_origin - 0.4 * (c.squaredNorm() * Eigen::Matrix3d::Identity() - c * c.transpose());
  EXPECT_LT((odd.objects[0].inertia - about_com).norm(), 1e-12);
}

TEST(Mjcf, SceneFile_MayReplaceStiffnessAndFrictionAndFilter) {
  const Scene scene = load_scene(data("odd_mjcf.yaml"));
  const auto model = Model::make(scene);
  ASSERT_EQ(model->n_a(), 5);
  EXPECT_EQ(model->stiffness()[model->joint_index("elbow")], 9);
  EXPECT_EQ(model->stiffness()[model->joint_index("lift")], 500);
  EXPECT_EQ(model->stiffness()[model->joint_index("finger_joint_0")], 800);
  EXPECT_EQ(model->objects()[0].name, "cube");
  EXPECT_TRUE(model->bodies()[static_cast<std::size_t>(body_index(*model, "arm_world"))].dofs.empty());

  std::set<std::pair<std::string, std::string>> pairs;
  for (const auto& pair : model->pairs()) {
    const auto& a = model->geometries()[static_cast<std::size_t>(pair.geometry_a)];
    const auto& b = model->geometries()[static_cast<std::size_t>(pair.geometry_b)];
    pairs.emplace(a.name, b.name);
    if (a.name == "cube/body" && b.name == "arm/finger/pad") {
      EXPECT_EQ(pair.max_distance, 0.01);
      EXPECT_DOUBLE_EQ(pair.friction, 2 * 0.5 * 0.9 / 1.4);
    }
  }
  EXPECT_TRUE(pairs.contains({"cube/body", "arm/finger/pad"}));
  EXPECT_TRUE(pairs.contains({"body_8/sphere_0", "arm_world/floor"}));
  EXPECT_FALSE(pairs.contains({"cube/body", "arm_world/floor"})) << "excluded";
  EXPECT_FALSE(pairs.contains({"arm/pedestal/box_0", "arm/finger/pad"})) << "excluded";
  EXPECT_FALSE(pairs.contains({"cube/body", "arm/flange/sphere_0"})) << "types and affinities 2 against 1";
  for (const auto& geometry : model->geometries()) EXPECT_EQ(geometry.name.find("cover"), std::string::npos) << "only seen";
}

TEST(Mjcf, WhatIsNotSupported_IsListedInOneMessage) {
  EXPECT_EQ(
      refused(R"(<worldbody><body name="b"><joint name="j" type="ball"/><geom name="g" type="ellipsoid" size="1 1 2"/></body>
                       <body><joint name="s" stiffness="3"/><geom size="1"/></body></worldbody>)"),
      "mjcf: got 3 unsupported elements: joint 'j' (a ball joint); joint 's' (a passive spring); geom 'g' (an ellipsoid), expected hinge, "
      "slide and free joints; sphere, capsule, box, cylinder, plane and mesh geoms; actuators on joints");
  EXPECT_NE(
      refused(
          R"(<worldbody><body name="b"><freejoint/><geom size="1"/><body name="arm"><joint/><geom size="1"/></body></body></worldbody>)")
          .find("body 'arm' (a joint on a body with a free joint)"),
      std::string::npos);
  EXPECT_NE(refused(R"(<worldbody><body name="b"><joint name="j"/><geom size="1"/></body></worldbody>
                       <equality><joint name="lock" joint1="j"/></equality>)")
                .find("equality 'lock' (a constraint beside joints and contacts)"),
            std::string::npos);
  EXPECT_NE(refused(R"(<worldbody><body name="b"><joint name="j"/><geom size="1"/></body></worldbody>
                       <tendon><fixed name="t"><joint joint="j" coef="1"/></fixed></tendon>)")
                .find("tendon 't' (a tendon)"),
            std::string::npos);
  EXPECT_NE(refused(R"(<worldbody><geom name="a" size="1"/><body name="b"><joint name="j"/><geom name="c" size="1"/></body></worldbody>
                       <contact><pair name="p" geom1="a" geom2="c"/></contact>)")
                .find("pair 'p'"),
            std::string::npos);
}

TEST(Mjcf, FilesThatMujocoRefuses_AreNamedWithItsReason) {
  EXPECT_EQ(message_of("nowhere.xml"), "nowhere.xml: mjcf: got a file that does not exist, expected an MJCF file");
  EXPECT_NE(refused("<worldbody><bodi/></worldbody>").find("bodi"), std::string::npos) << refused("<worldbody><bodi/></worldbody>");
  EXPECT_NE(refused(R"(<worldbody><body><joint/></body></worldbody>)").find("mass and inertia"), std::string::npos);
  EXPECT_NE(refused(R"(<worldbody><geom type="mesh" mesh="no"/></worldbody>)").find("no"), std::string::npos);
  EXPECT_FALSE(fs::exists("MUJOCO_LOG.TXT"));
}

/// Every model that the wheel brings (its archives are unpacked by CMake) loads and agrees, or is refused by named elements.
TEST(Mjcf, ModelsOfTheWheel_LoadOrAreRefusedByName) {
  std::vector<fs::path> files;
  for (const char* folder : {STICTION_MUJOCO_TESTDATA, STICTION_MUJOCO_UNPACKED}) {
    for (const auto& entry : fs::recursive_directory_iterator(folder)) {
      if (entry.path().extension() == ".xml") files.push_back(entry.path());
    }
  }
  std::sort(files.begin(), files.end());
  std::vector<std::string> loaded, refusals;
  for (const auto& file : files) {
    const std::string message = message_of(file);
    if (message.empty()) {
      loaded.push_back(file.filename());
      compare_kinematics(file);
    } else {
      EXPECT_NE(message.find("unsupported element"), std::string::npos) << message;
      EXPECT_NE(message.find(" ("), std::string::npos) << message;
      refusals.push_back(file.filename());
    }
  }
  std::sort(refusals.begin(), refusals.end());
  EXPECT_EQ(loaded, std::vector<std::string>{"msh.xml"});
  EXPECT_EQ(refusals, (std::vector<std::string>{"model.xml", "model_with_assetdir.xml", "model_with_assetdir.xml"}));
}

}  // namespace
}  // namespace stiction::world::test
