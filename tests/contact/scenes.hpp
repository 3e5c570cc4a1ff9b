#pragma once

#include <gtest/gtest.h>
// Scenes made in code for the tests of queries and Jacobians.

#include <filesystem>
#include <fstream>
#include <numeric>

#include "contact/shapes.hpp"
#include "support/temporary_folder.hpp"

namespace stiction::contact::test {

using Eigen::VectorXd;

inline world::ObjectSpec make_object(const std::string& name, const world::Shape& shape,
                                     world::ObjectJoint joint = world::ObjectJoint::Free) {
  world::ObjectSpec o;
  o.name = name;
  o.joint = joint;
  o.mass = 1;
  o.inertia = 1e-3 * Eigen::Matrix3d::Identity();
  o.geometries = {{"g", shape, {}, 0.5}};
  return o;
}

/// A trunk that turns about z and carries two fingers, one of two hinges, the other of a slider and a hinge, written as URDF.
/// @param following  the outer hinge of the left finger and the joints of the right one follow the inner one of the left and the trunk
inline std::filesystem::path write_gripper_urdf(bool following = false) {
  const std::filesystem::path file =
      stiction::test::folder_of_the_process() / (following ? "stiction_following_gripper.urdf" : "stiction_gripper.urdf");
  const auto link = [](const std::string& name, const std::string& geometry) {
    return "<link name='" + name + "'><collision><origin xyz='0.01 0.02 0.06' rpy='0.2 0.1 0'/><geometry>" + geometry +
           "</geometry></collision></link>";
  };
  const auto joint = [following](const std::string& name, const std::string& type, const std::string& parent, const std::string& child,
                                 const std::string& xyz, const std::string& axis, const std::string& mimic = "") {
    return "<joint name='" + name + "' type='" + type + "'><parent link='" + parent + "'/><child link='" + child + "'/><origin xyz='" +
           xyz + "' rpy='0.1 0 0.2'/><axis xyz='" + axis + "'/>" + (following ? mimic : "") +
           "<limit lower='-1.5' upper='1.5' effort='1' velocity='1'/></joint>";
  };
  std::ofstream out(file);
  out << "<robot name='gripper'><link name='base'/>" << link("trunk", "<box size='0.1 0.2 0.05'/>")
      << link("left_1", "<sphere radius='0.02'/>") << link("left_2", "<box size='0.03 0.02 0.08'/>")
      << link("right_1", "<sphere radius='0.02'/>") << link("right_2", "<sphere radius='0.025'/>")
      << joint("turn", "revolute", "base", "trunk", "0 0 0", "0 0 1") << joint("l1", "revolute", "trunk", "left_1", "0 0.08 0.05", "1 0 0")
      << joint("l2", "revolute", "left_1", "left_2", "0 0 0.1", "1 0 0", "<mimic joint='l1' multiplier='0.7' offset='0.2'/>")
      << joint("r1", "prismatic", "trunk", "right_1", "0 -0.08 0.05", "0 1 0", "<mimic joint='l1' multiplier='-0.1'/>")
      << joint("r2", "revolute", "right_1", "right_2", "0 0 0.1", "0 1 0", "<mimic joint='turn' multiplier='2'/>") << "</robot>";
  return file;
}

/// A gripper, five objects of different shapes and a ground: about fifty pairs of every kind.
inline world::Scene make_busy_scene(bool following = false) {
  world::Scene scene;
  scene.name = "busy";
  scene.contact_distance = 0.05;
  world::RobotSpec robot;
  robot.name = "gripper";
  robot.urdf = write_gripper_urdf(following);
  for (const char* joint : {"turn", "l1", "l2", "r1", "r2"}) {
    if (!following || std::string_view(joint) == "turn" || std::string_view(joint) == "l1") robot.stiffness.emplace_back(joint, 10.0);
  }
  scene.robots.push_back(robot);
  for (const Named& s : all_shapes()) {
    if (!is_half_space(s.shape)) scene.objects.push_back(make_object(s.name, s.shape));
  }
  scene.objects.back().geometries.push_back({"second", world::Sphere{0.03}, {Eigen::Matrix3d::Identity(), {0.05, 0, 0.05}}, 0.4});
  world::FixedSpec ground;
  ground.name = "ground";
  ground.X_WB.p.z() = -0.1;
  ground.geometries = {{"plane", world::HalfSpace{}, {}, 1.0},
                       {"post", world::Capsule{0.02, 0.1}, {Eigen::Matrix3d::Identity(), {0.1, 0.1, 0.1}}, 1.0}};
  scene.fixed.push_back(ground);
  return scene;
}

/// Everything a query needs at one configuration.
struct Fixture {
  explicit Fixture(const world::Scene& scene) : model(world::Model::make(scene)) {}

  std::shared_ptr<const world::Model> model;
  world::KinematicsWorkspace kinematics_work{*model};
  world::Kinematics kinematics;
  Workspace work{*model};
  VectorXd q = model->neutral();

  void move_to(const VectorXd& configuration) {
    q = configuration;
    world::calc_kinematics(*model, q, kinematics_work, kinematics);
  }

  void move_to_random(Random& random, double spread = 0.2) {
    VectorXd delta(model->n_v());
    for (int i = 0; i < delta.size(); ++i) {
      const world::Dof& dof = model->dofs()[i];
      const bool place = dof.owner_kind == world::BodyKind::Object && dof.kind == world::DofKind::Prismatic;
      delta[i] = random.uniform(-1, 1) * (place || dof.kind == world::DofKind::Prismatic ? spread : 1.4);
    }
    VectorXd next(model->n_q());
    world::retract(*model, model->neutral(), delta, next);
    move_to(next);
  }

  void move_by(const VectorXd& delta) {
    VectorXd next(model->n_q());
    world::retract(*model, q, delta, next);
    move_to(next);
  }

  std::vector<Contact> query_contacts(const QueryOptions& options = {}) {
    std::vector<Contact> out;
    query(*model, kinematics, options, work, out);
    return out;
  }

  world::Pose X_WG(int geometry) const {
    const world::Geometry& g = model->geometries()[geometry];
    return kinematics.X_WB[g.body] * g.X_BG;
  }

  Distance distance(int pair) const {
    const world::Pair& p = model->pairs()[pair];
    return calc_distance(model->geometries()[p.geometry_a].shape, X_WG(p.geometry_a), model->geometries()[p.geometry_b].shape,
                         X_WG(p.geometry_b));
  }

  std::vector<int> all_pairs() const {
    std::vector<int> out(model->pairs().size());
    std::iota(out.begin(), out.end(), 0);
    return out;
  }
};

struct ShapePair {
  Named a, b;
};
inline void PrintTo(const ShapePair& p, std::ostream* os) { *os << p.a.name << "_" << p.b.name; }
inline std::string case_name(const ::testing::TestParamInfo<ShapePair>& info) { return info.param.a.name + "_" + info.param.b.name; }

/// All pairs but those of two half-spaces.
inline std::vector<ShapePair> shape_pairs() {
  std::vector<ShapePair> out;
  for (const auto& a : all_shapes()) {
    for (const auto& b : all_shapes()) {
      if (!is_half_space(a.shape)) out.push_back({a, b});
    }
  }
  return out;
}

/// Of several files, with one instance for all of them.
class EveryShapePair : public ::testing::TestWithParam<ShapePair> {};

/// The two as free objects; a half-space as a fixed body at a slant.
inline world::Scene make_pair_scene(const ShapePair& pair) {
  world::Scene scene;
  scene.contact_distance = 10;
  scene.objects = {make_object("a", pair.a.shape)};
  if (is_half_space(pair.b.shape)) {
    scene.fixed = {
        {"b", {Eigen::AngleAxisd(0.4, Vector3d(1, 2, 3).normalized()).toRotationMatrix(), {0, 0, -0.08}}, {{"g", pair.b.shape, {}, 1.0}}}};
  } else {
    scene.objects.push_back(make_object("b", pair.b.shape));
  }
  return scene;
}

}  // namespace stiction::contact::test
