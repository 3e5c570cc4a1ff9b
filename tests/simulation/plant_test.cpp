#include "stiction/simulation/plant_impl.hpp"

#include <algorithm>
#include <filesystem>

#include "simulation/scenes.hpp"
#include "stiction/core/invalid_input.hpp"

namespace stiction::simulation::test {
namespace {

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

class PlantOf : public testing::TestWithParam<std::string> {};

/// Two programs that share no code place every body alike.
TEST_P(PlantOf, RandomConfigurations_BodiesAreWhereTheModelSays) {
  auto model = load(GetParam());
  const auto plant = Plant::make(model);
  const mjModel* m = plant->impl().mujoco.get();
  const std::unique_ptr<mjData, DeleteMujoco> data(mj_makeData(m));
  world::KinematicsWorkspace work(*model);
  world::Kinematics kinematics;
  core::Random random(3, 1);
  for (int sample = 0; sample < 50; ++sample) {
    const double scale = sample == 0 ? 0.0 : sample == 1 ? 1e-6 : 1.0;
    const Eigen::VectorXd q = world::test::random_configuration(*model, random, scale);
    world::calc_kinematics(*model, q, work, kinematics);
    copy_to_qpos(plant->impl(), q, data->qpos);
    Eigen::VectorXd back(model->n_q());
    copy_from_qpos(plant->impl(), data->qpos, back);
    ASSERT_EQ(back, q);
    mj_kinematics(m, data.get());
    for (std::size_t i = 0; i < model->bodies().size(); ++i) {
      const int id = plant->impl().body_id[i];
      ASSERT_GE(id, 0);
      const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> R(data->xmat + 9 * id);
      const Eigen::Map<const Eigen::Vector3d> p(data->xpos + 3 * id);
      EXPECT_LT((R - kinematics.X_WB[i].R).norm(), 1e-9) << model->bodies()[i].name;
      EXPECT_LT((p - kinematics.X_WB[i].p).norm(), 1e-9) << model->bodies()[i].name;
    }
  }
}

TEST_P(PlantOf, RandomConfigurations_ObjectsHaveTheInertiaOfTheModel) {
  auto model = load(GetParam());
  const auto plant = Plant::make(model);
  const mjModel* m = plant->impl().mujoco.get();
  const std::unique_ptr<mjData, DeleteMujoco> data(mj_makeData(m));
  world::KinematicsWorkspace work(*model);
  world::Kinematics kinematics;
  core::Random random(3, 2);
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> M(m->nv, m->nv);
  for (int sample = 0; sample < 10; ++sample) {
    const Eigen::VectorXd q = world::test::random_configuration(*model, random);
    world::calc_kinematics(*model, q, work, kinematics);
    copy_to_qpos(plant->impl(), q, data->qpos);
    mj_fwdPosition(m, data.get());
    mj_fullM(m, data.get(), M.data());
    for (std::size_t i = 0; i < model->objects().size(); ++i) {
      const auto& object = model->objects()[i];
      Eigen::MatrixXd want(object.n_v, object.n_v), got(object.n_v, object.n_v);
      world::calc_object_mass(*model, kinematics, static_cast<int>(i), want);
      for (int r = 0; r < object.n_v; ++r) {
        for (int c = 0; c < object.n_v; ++c) {
          got(r, c) = M(plant->impl().v_address[static_cast<std::size_t>(object.v_begin + r)],
                        plant->impl().v_address[static_cast<std::size_t>(object.v_begin + c)]);
        }
      }
      EXPECT_LT((got - want).norm(), 1e-9 * want.norm()) << object.name;
    }
  }
}

TEST_P(PlantOf, Pairs_AreThoseOfTheModelWithItsFriction) {
  auto model = load(GetParam());
  PlantOptions options;
  options.contact.friction_scale = 0.5;
  const auto plant = Plant::make(model, options);
  const mjModel* m = plant->impl().mujoco.get();
  ASSERT_EQ(static_cast<std::size_t>(m->npair), model->pairs().size());
  for (int g = 0; g < m->ngeom; ++g) EXPECT_EQ(m->geom_contype[g] | m->geom_conaffinity[g], 0) << "no contacts but those of the pairs";
  const std::size_t n = model->geometries().size();
  for (int p = 0; p < m->npair; ++p) {
    const auto a = static_cast<std::size_t>(plant->impl().geometry_of[static_cast<std::size_t>(m->pair_geom1[p])]);
    const auto b = static_cast<std::size_t>(plant->impl().geometry_of[static_cast<std::size_t>(m->pair_geom2[p])]);
    const int pair = std::max(plant->impl().pair_of[a * n + b], plant->impl().pair_of[b * n + a]);
    ASSERT_GE(pair, 0);
    EXPECT_DOUBLE_EQ(m->pair_friction[5 * p], 0.5 * model->pairs()[static_cast<std::size_t>(pair)].friction);
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
  EXPECT_DOUBLE_EQ(hand->inertias()[0].mass, 1.0) << "the ball";
}

TEST(Plant, StiffSprings_GetTheArmatureThatTheTimestepNeeds) {
  PlantOptions options;
  options.timestep = 1e-3;
  options.spring_resolution = 0.5;
  const auto plant = Plant::make(load("allegro_ball"), options);
  EXPECT_NEAR(plant->armature()[3], 100 * 4e-6, 1e-15);
  options.armature = 0.01;
  EXPECT_EQ(Plant::make(load("allegro_ball"), options)->armature()[3], 0.01);
}

std::string message(PlantOptions options) {
  try {
    (void)Plant::make(load("planar_pushing"), options);
  } catch (const core::InvalidInput& e) {
    return e.what();
  }
  return "accepted";
}

TEST(Plant, OptionsOutOfRange_AreNamed) {
  const auto with = [](auto&& change) {
    PlantOptions options;
    change(options);
    return message(options);
  };
  EXPECT_EQ(with([](auto& o) { o.timestep = 0; }), "timestep: got 0, expected a finite number > 0");
  EXPECT_EQ(with([](auto& o) { o.contact.time_constant = 3e-4; }),
            "contact.time_constant: got 0.0003 s, expected at least 2 timesteps of 0.0002 s");
  EXPECT_EQ(with([](auto& o) { o.contact.impedance = 1; }), "contact.impedance: got 1, expected a number in (0, 0.9999]");
  EXPECT_EQ(with([](auto& o) { o.contact.friction_stiffening = 0.5; }), "contact.friction_stiffening: got 0.5, expected a number ≥ 1");
  EXPECT_EQ(with([](auto& o) { o.contact.noslip_iterations = -1; }), "contact.noslip_iterations: got -1, expected an integer ≥ 0");
}

TEST(Plant, InertiaThatNoBodyHas_IsRefusedWithTheReason) {
  world::Scene scene = empty_scene(Eigen::Vector3d::Zero());
  scene.objects.push_back(world::test::make_object("thing", world::ObjectJoint::Free));
  scene.objects[0].inertia = Eigen::Vector3d(1, 1, 3).asDiagonal();
  try {
    (void)Plant::make(world::Model::make(scene));
    FAIL() << "accepted";
  } catch (const core::InvalidInput& e) {
    EXPECT_NE(std::string(e.what()).find("thing"), std::string::npos) << e.what();
  }
}

}  // namespace
}  // namespace stiction::simulation::test
