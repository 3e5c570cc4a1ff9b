#pragma once

#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <memory>
#include <set>
#include <string>

#include "stiction/world/call_mujoco.hpp"
#include "stiction/world/mjcf.hpp"
#include "support/message_of.hpp"
#include "support/temporary_folder.hpp"
#include "world/test_scenes.hpp"

// What MuJoCo makes of a file, to compare with what is read from it.

namespace stiction::world::test {

struct DeleteMujoco {
  void operator()(mjSpec* spec) const { mj_deleteSpec(spec); }
  void operator()(mjModel* model) const { mj_deleteModel(model); }
  void operator()(mjData* data) const { mj_deleteData(data); }
};
template <class T>
using Owned = std::unique_ptr<T, DeleteMujoco>;

inline Owned<mjModel> load_mujoco(const std::filesystem::path& file) {
  char error[1000] = "";
  mjModel* model = nullptr;
  call_mujoco([&] { model = mj_loadXML(file.c_str(), nullptr, error, sizeof(error)); });
  if (model == nullptr) ADD_FAILURE() << error;
  return Owned<mjModel>(model);
}

/// A file with the given content of <mujoco>.
inline std::filesystem::path write_mjcf(const std::string& content, const std::string& name = "written.xml") {
  const auto file = stiction::test::folder_of_the_process() / name;
  std::ofstream(file) << "<mujoco>" << content << "</mujoco>";
  return file;
}

/// What reading the file complains about; empty if nothing.
inline std::string message_of_file(const std::filesystem::path& file) {
  const std::string message = stiction::test::message_of([&] { (void)read_mjcf(file); });
  return message == "no exception" ? "" : message;
}

/// The file as a robot named "arm", with these stiffnesses in place of its own.
inline std::shared_ptr<const Model> make_robot(const std::filesystem::path& file,
                                               std::vector<std::pair<std::string, double>> stiffness = {}) {
  RobotSpec robot;
  robot.name = "arm";
  robot.mjcf = file;
  robot.stiffness = std::move(stiffness);
  Scene scene;
  add_mjcf(scene, robot);
  return Model::make(scene);
}

/// The same, with a stiffness of 1 where the file gives none.
inline std::shared_ptr<const Model> make_model(const std::filesystem::path& file) {
  std::vector<std::pair<std::string, double>> stiffness;
  for (const auto& joint : read_mjcf(file).robot.joints) {
    if (joint.moves_by_itself() && !joint.stiffness) stiffness.emplace_back(joint.name, 1.0);
  }
  return make_robot(file, std::move(stiffness));
}

inline std::string name_of(const mjModel* m, mjtObj type, int id) {
  const char* name = mj_id2name(m, type, id);
  std::string out = name != nullptr ? name : "";
  std::replace_if(
      out.begin(), out.end(), [](char c) { return c == '/' || c == '*' || c == ' '; }, '_');
  return out;
}

inline std::string body_name(const mjModel* m, int body) {
  const std::string name = name_of(m, mjOBJ_BODY, body);
  return name.empty() ? "body_" + std::to_string(body) : name;
}

inline bool is_on_free_body(const mjModel* m, int body) {
  const int top = m->body_weldid[body];
  return top != 0 && m->body_jntnum[top] > 0 && m->jnt_type[m->body_jntadr[top]] == mjJNT_FREE;
}

inline int body_index(const Model& model, const std::string& name) {
  for (std::size_t i = 0; i < model.bodies().size(); ++i) {
    if (model.bodies()[i].name == name) return static_cast<int>(i);
  }
  return -1;
}

inline Pose pose_of(const mjtNum* position, const mjtNum* rows) {
  return {Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(rows), Eigen::Map<const Eigen::Vector3d>(position)};
}

inline double distance(const Pose& a, const Pose& b) { return std::max((a.R - b.R).norm(), (a.p - b.p).norm()); }

/// Puts joints where the equalities between them want them, in the order of the file.
inline void apply_equalities(const mjModel* m, mjData* d) {
  for (int i = 0; i < m->neq; ++i) {
    if (!m->eq_active0[i] || m->eq_type[i] != mjEQ_JOINT) continue;
    const mjtNum* a = m->eq_data + i * mjNEQDATA;
    const int y = m->jnt_qposadr[m->eq_obj1id[i]];
    double sum = a[0], power = 1;
    if (m->eq_obj2id[i] >= 0) {
      const int x = m->jnt_qposadr[m->eq_obj2id[i]];
      for (int k = 1; k < 5; ++k) sum += a[k] * (power *= d->qpos[x] - m->qpos0[x]);
    }
    d->qpos[y] = m->qpos0[y] + sum;
  }
}

inline bool has_object(const Model& model, const std::string& name) {
  return std::any_of(model.objects().begin(), model.objects().end(), [&](const ObjectInfo& object) { return object.name == name; });
}

/// qpos in the coordinates of the model; joints that others move have none.
inline Eigen::VectorXd configuration(const Model& model, const mjModel* m, const mjData* d) {
  Eigen::VectorXd q = model.neutral();
  for (int j = 0; j < m->njnt; ++j) {
    const int body = m->jnt_bodyid[j];
    const mjtNum* value = d->qpos + m->jnt_qposadr[j];
    if (m->jnt_type[j] == mjJNT_FREE) {
      if (!has_object(model, body_name(m, body))) continue;  // only seen
      const auto& object = model.objects()[static_cast<std::size_t>(model.object_index(body_name(m, body)))];
      q.segment<3>(object.q_begin) << value[0], value[1], value[2];
      q.segment<4>(object.q_begin + 3) << value[4], value[5], value[6], value[3];
    } else {
      std::string name = name_of(m, mjOBJ_JOINT, j);
      if (name.empty()) name = body_name(m, body) + "_joint_" + std::to_string(j - m->body_jntadr[body]);
      const auto set = [&](const std::string& joint, double x) {
        const auto dofs = model.dofs().subspan(static_cast<std::size_t>(model.n_vu()));
        const auto dof = std::find_if(dofs.begin(), dofs.end(), [&](const Dof& entry) { return entry.name == "arm/" + joint; });
        if (dof != dofs.end()) q[model.n_qu() + (dof - dofs.begin())] = x;
      };
      if (m->jnt_type[j] == mjJNT_BALL) {
        const Eigen::Vector3d zyx = Eigen::Quaterniond(value[0], value[1], value[2], value[3]).toRotationMatrix().eulerAngles(2, 1, 0);
        set(name + "_z", zyx[0]), set(name + "_y", zyx[1]), set(name + "_x", zyx[2]);
      } else {
        set(name, value[0]);
      }
    }
  }
  return q;
}

/// Body of the model that carries a geom.
inline std::string carrier_of(const mjModel* m, int geom) {
  const int body = m->geom_bodyid[geom];
  if (is_on_free_body(m, body)) return body_name(m, m->body_weldid[body]);
  return body == 0 || m->geom_type[geom] == mjGEOM_PLANE ? "arm_world" : "arm/" + body_name(m, body);
}

inline void compare_bodies(const Model& model, const Kinematics& kinematics, const mjModel* m, const mjData* d) {
  for (int body = 1; body < m->nbody; ++body) {
    const bool free = is_on_free_body(m, body);
    if (free && m->body_weldid[body] != body) continue;  // part of its object
    const std::string name = body_name(m, body);
    if (free && !has_object(model, name)) continue;  // only seen: it is named in a note
    const int index = body_index(model, free ? name : "arm/" + name);
    ASSERT_GE(index, 0) << name;
    const Pose X_WB = pose_of(d->xpos + 3 * body, d->xmat + 9 * body);
    EXPECT_LT(distance(kinematics.X_WB[static_cast<std::size_t>(index)], X_WB), 1e-9) << name;
    if (free) {
      const auto& object = model.objects()[static_cast<std::size_t>(model.object_index(name))];
      EXPECT_NEAR(object.mass, m->body_subtreemass[body], 1e-12 * object.mass);
      const Eigen::Vector3d p_WCom = X_WB * model.inertias()[static_cast<std::size_t>(index)].p_BCom;
      EXPECT_LT((p_WCom - Eigen::Map<const Eigen::Vector3d>(d->subtree_com + 3 * body)).norm(), 1e-9) << name;
    }
  }
}

/// By its type and affinity, or in a contact pair of its own.
inline bool may_collide(const mjModel* m, int geom) {
  if ((m->geom_contype[geom] | m->geom_conaffinity[geom]) != 0) return true;
  for (int i = 0; i < m->npair; ++i) {
    if (m->pair_geom1[i] == geom || m->pair_geom2[i] == geom) return true;
  }
  return false;
}

/// Every geom that collides is a geometry of its body in the same place, and there are no others.
inline void compare_geoms(const Model& model, const Kinematics& kinematics, const mjModel* m, const mjData* d) {
  std::size_t colliding = 0;
  for (int g = 0; g < m->ngeom; ++g) {
    if (!may_collide(m, g)) continue;
    ++colliding;
    const int index = body_index(model, carrier_of(m, g));
    ASSERT_GE(index, 0) << carrier_of(m, g);
    const Pose X_WG = pose_of(d->geom_xpos + 3 * g, d->geom_xmat + 9 * g);
    const auto stands_there = [&](const Geometry& geometry) {
      return geometry.body == index && distance(kinematics.X_WB[static_cast<std::size_t>(index)] * geometry.X_BG, X_WG) < 1e-9;
    };
    EXPECT_TRUE(std::any_of(model.geometries().begin(), model.geometries().end(), stands_there))
        << "geom " << g << " '" << name_of(m, mjOBJ_GEOM, g) << "'";
  }
  EXPECT_EQ(model.geometries().size(), colliding);
}

/// Moves every joint of the file at random, in both programs, and compares all bodies and geoms that collide.
inline void compare_kinematics(const std::filesystem::path& file) {
  const auto model = make_model(file);
  const Owned<mjModel> m = load_mujoco(file);
  ASSERT_NE(m, nullptr);
  const Owned<mjData> d(mj_makeData(m.get()));
  core::Random random(5, 1);
  KinematicsWorkspace work(*model);
  Kinematics kinematics;
  for (int sample = 0; sample < 21; ++sample) {  // the first is the pose of the file
    for (int i = 0; i < m->nq; ++i) d->qpos[i] = sample == 0 ? m->qpos0[i] : random.normal();
    apply_equalities(m.get(), d.get());
    mj_normalizeQuat(m.get(), d->qpos);
    mj_kinematics(m.get(), d.get());  // no mass matrix, of which MuJoCo might warn in a file of its own
    mj_comPos(m.get(), d.get());
    calc_kinematics(*model, configuration(*model, m.get(), d.get()), work, kinematics);
    compare_bodies(*model, kinematics, m.get(), d.get());
    compare_geoms(*model, kinematics, m.get(), d.get());
    if (testing::Test::HasFailure()) return;
  }
}

}  // namespace stiction::world::test
