#include "stiction/simulation/plant_impl.hpp"

#include <algorithm>
#include <filesystem>

#include "simulation/scenes.hpp"
#include "stiction/world/robot_tree.hpp"
#include "support/message_of.hpp"

namespace stiction::simulation::test {
namespace {

using stiction::test::message_of;

std::shared_ptr<const world::Model> load(const std::string& name) {
  if (name == "zoo") return world::Model::make(world::test::make_zoo());
  if (name == "stacking") return world::Model::make(world::load_scene(source_dir() / "models/stacking.yaml"));
  if (name == "odd_mjcf") return world::Model::make(world::load_scene(source_dir() / "tests/world/data/odd_mjcf.yaml"));
  return load_task(name);
}

/// All task scenes, and two with every kind of joint.
std::vector<std::string> scene_names() {
  std::vector<std::string> names{"zoo", "odd_mjcf", "stacking"};
  for (const auto& entry : std::filesystem::directory_iterator(source_dir() / "tasks")) {
    if (entry.path().extension() == ".yaml") names.push_back(entry.path().stem());
  }
  std::sort(names.begin(), names.end());
  return names;
}

class PlantOf : public testing::TestWithParam<std::string> {
 protected:
  /// Calls check(q) at the neutral configuration, near it and at random ones, with `kinematics_` and MuJoCo's `data_` of each.
  template <class F>
  void for_each_configuration(int samples, F&& check) {
    world::KinematicsWorkspace work(*model_);
    core::Random random(3, 1);
    for (int sample = 0; sample < samples; ++sample) {
      const double scale = sample == 0 ? 0.0 : sample == 1 ? 1e-6 : 1.0;
      const Eigen::VectorXd q = world::test::random_configuration(*model_, random, scale);
      world::calc_kinematics(*model_, q, work, kinematics_);
      copy_to_qpos(plant_->impl(), q, data_->qpos);
      mj_fwdPosition(m_, data_.get());
      check(q);
    }
  }

  std::shared_ptr<const world::Model> model_ = load(GetParam());
  std::shared_ptr<const Plant> plant_ = Plant::make(model_);
  const mjModel* m_ = plant_->impl().mujoco.get();
  std::unique_ptr<mjData, DeleteMujoco> data_{mj_makeData(m_)};
  world::Kinematics kinematics_;
};

/// Two programs that share no code place every body alike.
TEST_P(PlantOf, RandomConfigurations_BodiesAreWhereTheModelSays) {
  for_each_configuration(50, [&](const Eigen::VectorXd& q) {
    Eigen::VectorXd back(model_->n_q());
    copy_from_qpos(plant_->impl(), data_->qpos, back);
    ASSERT_EQ(back, q);
    for (std::size_t i = 0; i < model_->bodies().size(); ++i) {
      const int id = plant_->impl().body_id[i];
      ASSERT_GE(id, 0);
      const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> R(data_->xmat + 9 * id);
      const Eigen::Map<const Eigen::Vector3d> p(data_->xpos + 3 * id);
      EXPECT_LT((R - kinematics_.X_WB[i].R).norm(), 1e-9) << model_->bodies()[i].name;
      EXPECT_LT((p - kinematics_.X_WB[i].p).norm(), 1e-9) << model_->bodies()[i].name;
    }
  });
}

TEST_P(PlantOf, RandomConfigurations_ObjectsHaveTheInertiaOfTheModel) {
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> M(m_->nv, m_->nv);
  for_each_configuration(10, [&](const Eigen::VectorXd&) {
    mj_fullM(m_, data_.get(), M.data());
    for (std::size_t i = 0; i < model_->objects().size(); ++i) {
      const auto& object = model_->objects()[i];
      Eigen::MatrixXd want(object.n_v, object.n_v), got(object.n_v, object.n_v);
      world::calc_object_mass(*model_, kinematics_, static_cast<int>(i), want);
      const int* address = plant_->impl().v_address.data() + object.v_begin;
      for (int r = 0; r < object.n_v; ++r) {
        for (int c = 0; c < object.n_v; ++c) got(r, c) = M(address[r], address[c]);
      }
      EXPECT_LT((got - want).norm(), 1e-9 * want.norm()) << object.name;
    }
  });
}

TEST_P(PlantOf, Pairs_AreThoseOfTheModelWithItsFriction) {
  PlantOptions options;
  options.contact.friction_scale = 0.5;
  const auto plant = Plant::make(model_, options);
  const mjModel* m = plant->impl().mujoco.get();
  ASSERT_EQ(static_cast<std::size_t>(m->npair), model_->pairs().size());
  for (int g = 0; g < m->ngeom; ++g) EXPECT_EQ(m->geom_contype[g] | m->geom_conaffinity[g], 0) << "no contacts but those of the pairs";
  const std::size_t n = model_->geometries().size();
  for (int p = 0; p < m->npair; ++p) {
    const auto a = static_cast<std::size_t>(plant->impl().geometry_of[static_cast<std::size_t>(m->pair_geom1[p])]);
    const auto b = static_cast<std::size_t>(plant->impl().geometry_of[static_cast<std::size_t>(m->pair_geom2[p])]);
    const int pair = std::max(plant->impl().pair_of[a * n + b], plant->impl().pair_of[b * n + a]);
    ASSERT_GE(pair, 0);
    EXPECT_DOUBLE_EQ(m->pair_friction[5 * p], 0.5 * model_->pairs()[static_cast<std::size_t>(pair)].friction);
  }
}

INSTANTIATE_TEST_SUITE_P(Scenes, PlantOf, testing::ValuesIn(scene_names()), [](const auto& param) { return param.param; });

TEST(Plant, LinkWithoutInertial_HasThatOfItsShapesAtTheStatedDensity) {
  auto model = load("zoo");
  const auto index = [&](std::string_view name) {
    for (std::size_t i = 0; i < model->bodies().size(); ++i) {
      if (model->bodies()[i].name == name) return i;
    }
    return model->bodies().size();
  };
  EXPECT_NEAR(model->inertias()[index("odd/rail")].mass, world::kLinkDensity * 0.2 * 0.1 * 0.05, 1e-9);
  EXPECT_EQ(model->inertias()[index("odd/left")].mass, 0);
  EXPECT_EQ(model->inertias()[index("floor")].mass, 0);
  auto hand = load("allegro_ball");
  EXPECT_DOUBLE_EQ(hand->inertias()[1].mass, 0.4154);
  EXPECT_DOUBLE_EQ(hand->inertias()[1].inertia(0, 2), 0.0002233);
  EXPECT_DOUBLE_EQ(hand->inertias()[0].mass, 0.05) << "the ball";
}

TEST(Plant, StiffSprings_GetTheArmatureThatTheTimestepNeeds) {
  PlantOptions options;
  options.timestep = 1e-3;
  options.spring_resolution = 0.5;
  const auto plant = Plant::make(load("allegro_ball"), options);
  EXPECT_NEAR(plant->armature()[3], 3 * 4e-6, 1e-15);
  options.armature = 0.01;
  EXPECT_EQ(Plant::make(load("allegro_ball"), options)->armature()[3], 0.01);
}

TEST(Plant, OptionsOutOfRange_AreNamed) {
  const auto with = [](auto&& change) {
    PlantOptions options;
    change(options);
    return message_of([&] { (void)Plant::make(load("planar_pushing"), options); });
  };
  EXPECT_EQ(with([](auto& o) { o.timestep = 0; }), "timestep: got 0, expected a finite number > 0");
  EXPECT_EQ(with([](auto& o) { o.contact.time_constant = 3e-4; }),
            "contact.time_constant: got 0.0003 s, expected at least 2 timesteps of 0.0002 s");
  EXPECT_EQ(with([](auto& o) { o.contact.impedance = 1; }), "contact.impedance: got 1, expected a number in (0, 0.9999]");
  EXPECT_EQ(with([](auto& o) { o.contact.friction_stiffening = 0.5; }), "contact.friction_stiffening: got 0.5, expected a number ≥ 1");
  EXPECT_EQ(with([](auto& o) { o.contact.noslip_iterations = -1; }), "contact.noslip_iterations: got -1, expected an integer ≥ 0");
  EXPECT_EQ(with([](auto& o) { o.contact.ground_softness = 0.5; }), "contact.ground_softness: got 0.5, expected a number ≥ 1");
}

TEST(Plant, InertiaThatNoBodyHas_IsRefusedWithTheReason) {
  world::Scene scene = empty_scene(Eigen::Vector3d::Zero());
  scene.objects.push_back(world::test::make_object("thing", world::ObjectJoint::Free));
  scene.objects[0].inertia = Eigen::Vector3d(1, 1, 3).asDiagonal();
  const std::string message = message_of([&] { (void)Plant::make(world::Model::make(scene)); });
  EXPECT_NE(message.find("thing"), std::string::npos) << message;
}

}  // namespace
}  // namespace stiction::simulation::test
