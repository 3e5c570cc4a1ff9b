// Random physical scenes: every step must have a solution, whatever touches whatever.
#include <algorithm>
#include <map>
#include <numbers>

#include "dynamics/systems.hpp"

namespace stiction::dynamics::test {
namespace {

using core::Random;
using core::Status;
using Eigen::Vector3d;
using Eigen::VectorXd;
using world::Model;

/// Irregular octahedron, whose faces are never parallel to those of a box by chance.
world::Mesh make_mesh(double size) {
  auto m = std::make_shared<world::ConvexMesh>();
  m->vertices.resize(3, 6);
  m->vertices << 1, -0.9, 0.1, 0, 0.05, 0, 0.1, 0, 0.8, -0.7, 0, -0.1, 0, 0.1, 0, 0.05, 0.7, -0.8;
  m->vertices *= size;
  m->triangles.resize(3, 8);
  m->triangles << 0, 2, 1, 3, 2, 1, 3, 0, 2, 1, 3, 0, 0, 2, 1, 3, 4, 4, 4, 4, 5, 5, 5, 5;
  return {m};
}

world::Shape random_shape(Random& random) {
  const double a = random.uniform(0.02, 0.06), b = random.uniform(0.02, 0.06), c = random.uniform(0.02, 0.06);
  switch (random.index(5)) {
    case 0:
      return world::Sphere{a};
    case 1:
      return world::Capsule{0.6 * a, b};
    case 2:
      return world::Box{{a, b, c}};
    case 3:
      return world::Cylinder{a, b};
    default:
      return make_mesh(a);
  }
}

/// 1 to 10 bodies of 0.01 to 10 kg and any friction on the ground, with a compliant ball on two joints among them or not.
world::Scene random_scene(Random& random) {
  world::Scene scene = empty_scene();
  scene.gravity = {0, 0, -9.81};
  scene.contact_distance = 0.02;
  const auto friction = [&] { return random.chance(0.15) ? 0.0 : random.uniform(0.05, 1.2); };
  scene.fixed.push_back(half_space(Vector3d::UnitZ(), Vector3d::Zero(), friction()));
  if (random.chance(0.5)) scene.robots.push_back(pusher(friction()));
  const int bodies = 1 + random.index(10);
  for (int i = 0; i < bodies; ++i) {
    world::ObjectSpec object;
    object.name = "body_" + std::to_string(i);
    object.mass = std::pow(10, random.uniform(-2, 1));
    object.inertia = object.mass * 0.002 * Eigen::Matrix3d::Identity();
    object.geometries.push_back({.name = "shape", .shape = random_shape(random), .X_BG = {}, .friction = friction()});
    scene.objects.push_back(std::move(object));
  }
  return scene;
}

/// Half of the orientations are upright or turned by 90°, so that faces lie on faces.
Eigen::Quaterniond random_rotation(Random& random) {
  if (random.chance(0.5)) {
    const double quarter = std::numbers::pi / 2;
    return Eigen::AngleAxisd(quarter * random.index(4), Vector3d::UnitX()) *
           Eigen::AngleAxisd(quarter * random.index(4), Vector3d::UnitY()) *
           Eigen::AngleAxisd(random.chance(0.5) ? 0.0 : random.uniform(-3, 3), Vector3d::UnitZ());
  }
  return Eigen::Quaterniond(random.normal(), random.normal(), random.normal(), random.normal()).normalized();
}

/// A heap: each body is let down until it is between 2 mm inside and 5 mm above what lies there.
VectorXd random_heap(const Model& model, Random& random, contact::Workspace& work) {
  world::KinematicsWorkspace kinematics_work(model);
  world::Kinematics kinematics;
  VectorXd q = model.neutral();
  if (model.n_a() > 0) q.tail(2) << random.uniform(-0.3, 0.3), 0.1 + random.uniform(0, 0.1);
  for (const auto& object : model.objects()) q[object.q_begin + 2] = 10.0 + 10.0 * object.q_begin;  // out of the way
  for (const auto& object : model.objects()) {
    q[object.q_begin] = 0.12 * random.normal();
    q[object.q_begin + 1] = 0.12 * random.normal();
    q.segment<4>(object.q_begin + 3) = random_rotation(random).coeffs();
    std::vector<int> pairs;
    for (std::size_t i = 0; i < model.pairs().size(); ++i) {
      const auto body = [&](int g) { return model.geometries()[static_cast<std::size_t>(g)].body; };
      if (body(model.pairs()[i].geometry_a) == object.body || body(model.pairs()[i].geometry_b) == object.body)
        pairs.push_back(static_cast<int>(i));
    }
    double z = 1.0;
    for (int k = 0; k < 40; ++k) {  // sphere tracing: no step is longer than the free distance
      q[object.q_begin + 2] = z;
      world::calc_kinematics(model, q, kinematics_work, kinematics);
      const double free = contact::calc_min_distance(model, kinematics, pairs, -1e300, work);
      if (free < 1e-4) break;
      z -= free;
    }
    q[object.q_begin + 2] = z - random.uniform(-0.005, 0.002);
  }
  return q;
}

StepOptions random_options(Random& random, bool has_robot) {
  StepOptions options;
  options.h = std::pow(10, random.uniform(-3, -0.7));
  options.warm_start = false;
  if (!has_robot || random.chance(0.3)) options.regularisation = FixedEpsilon{1};
  if (random.chance(0.3)) options.smoothing = Analytic{.kappa = std::pow(10, random.uniform(1, 4))};
  if (random.chance(0.2)) options.friction_cone = PolyhedralCone{4};
  options.with_A = options.with_B = random.chance(0.25);
  return options;
}

struct Counts {
  int steps = 0, contacts = 0, most_contacts = 0;
  std::map<std::string, int> failed;
};

/// Three steps from one heap; whatever is not solved is counted with its scene.
void run_scene(std::uint64_t seed, Counts& counts) {
  Random random(seed, 0);
  const auto model = Model::make(random_scene(random));
  contact::Workspace contact_work(*model);
  VectorXd q = random_heap(*model, random, contact_work);
  StepWorkspace work(model);
  const StepOptions options = random_options(random, model->n_a() > 0);
  StepResult r;
  VectorXd u = q.tail(model->n_a());
  for (int k = 0; k < 3; ++k) {
    for (double& x : u) x += 0.02 * random.normal();
    const Status status = step(*model, {q, u}, options, work, r);
    ++counts.steps;
    if (status != Status::Solved) {
      ++counts.failed[std::string(core::to_string(status))];
      ADD_FAILURE() << "seed " << seed << " step " << k << ": " << core::to_string(status);
      return;
    }
    ASSERT_TRUE(r.q_next.allFinite()) << "seed " << seed;
    for (const auto& c : r.contacts) ASSERT_GE(c.gap, -1e-8) << "seed " << seed;
    counts.contacts += static_cast<int>(r.contacts.size());
    counts.most_contacts = std::max(counts.most_contacts, static_cast<int>(r.contacts.size()));
    q = r.q_next;
  }
}

TEST(STICTION_RANDOM_SUITE, AllShapesAndUpToTenBodies_EveryStepSolved) {
  Counts counts;
  for (int i = 0; i < STICTION_RANDOM_SCENES && counts.failed.size() == 0; ++i) run_scene(static_cast<std::uint64_t>(i), counts);
  EXPECT_GT(counts.contacts, 5 * counts.steps) << "hardly anything touched";
  RecordProperty("steps", counts.steps);
  RecordProperty("most_contacts", counts.most_contacts);
}

}  // namespace
}  // namespace stiction::dynamics::test
