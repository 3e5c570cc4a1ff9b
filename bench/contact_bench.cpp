// Cost of a contact query at a grasp: Allegro hand and ball, 163 pairs, about 30 contacts.
#include <benchmark/benchmark.h>

#include <Eigen/Geometry>
#include <numeric>
#include <string>

#include "stiction/contact/contact.hpp"
#include "stiction/contact/derivatives.hpp"

namespace {

using namespace stiction;

// Every pair counts within 25 mm, whatever the task says, as in the published benchmark.
std::shared_ptr<const world::Model> load_grasp_model() {
  world::Scene scene = world::load_scene(std::string(STICTION_SOURCE_DIR) + "/tasks/allegro_ball.yaml");
  scene.filters.clear();
  scene.contact_distance = 0.025;
  scene.max_contacts.reset();
  return world::Model::make(scene);
}

struct Grasp {
  std::shared_ptr<const world::Model> model = load_grasp_model();
  world::KinematicsWorkspace kinematics_work{*model};
  world::Kinematics kinematics;
  contact::Workspace work{*model};
  std::vector<contact::Contact> contacts;
  contact::Jacobians jacobians;

  Grasp() {
    Eigen::VectorXd q = model->neutral();
    q.head<3>() << -0.081, 0.001, 0.071;
    q.tail<16>() << 0.03501504, 0.75276565, 0.74146232, 0.83261002, -0.1438725, 0.74696812, 0.61908827, 0.70064279, -0.06922541, 0.78533142,
        0.82942863, 0.90415436, 0.63256269, 1.02378254, 0.64089555, 0.82444782;
    world::calc_kinematics(*model, q, kinematics_work, kinematics);
    contact::query(*model, kinematics, {}, work, contacts);
  }
};

void query(benchmark::State& state) {
  Grasp g;
  for (auto _ : state) {
    contact::query(*g.model, g.kinematics, {}, g.work, g.contacts);
    benchmark::DoNotOptimize(g.contacts.data());
  }
  state.counters["contacts"] = static_cast<double>(g.contacts.size());
  state.counters["pairs"] = static_cast<double>(g.model->pairs().size());
}
BENCHMARK(query)->Name("contact/query/allegro_ball");

void broad_phase(benchmark::State& state) {
  Grasp g;
  for (auto _ : state) {
    contact::query(*g.model, g.kinematics, {.cutoff = -1.0}, g.work, g.contacts);
    benchmark::DoNotOptimize(g.contacts.data());
  }
}
BENCHMARK(broad_phase)->Name("contact/broad_phase/allegro_ball");

void jacobians(benchmark::State& state) {
  Grasp g;
  for (auto _ : state) {
    contact::calc_jacobians(*g.model, g.kinematics, g.contacts, g.work, g.jacobians);
    benchmark::DoNotOptimize(g.jacobians.values.data());
  }
}
BENCHMARK(jacobians)->Name("contact/jacobians/allegro_ball");

void derivatives(benchmark::State& state) {
  Grasp g;
  contact::calc_jacobians(*g.model, g.kinematics, g.contacts, g.work, g.jacobians);
  const std::vector<Eigen::Vector3d> lambda(g.contacts.size(), Eigen::Vector3d(0.1, 0.02, 0.03));
  const Eigen::VectorXd delta = Eigen::VectorXd::LinSpaced(g.model->n_v(), -0.01, 0.01);
  contact::ContactDerivatives out;
  for (auto _ : state) {
    contact::calc_derivatives(*g.model, g.kinematics, g.contacts, g.jacobians, lambda, delta, {}, g.work, out);
    benchmark::DoNotOptimize(out.D_tau_q.data());
  }
}
BENCHMARK(derivatives)->Name("contact/derivatives/allegro_ball");

void jacobian_one_by_one(benchmark::State& state) {
  Grasp g;
  std::vector<double> J(3 * static_cast<std::size_t>(g.model->n_v()));
  for (auto _ : state) {
    for (const contact::Contact& c : g.contacts) {
      contact::calc_jacobian(*g.model, g.kinematics, c, J.data());
      benchmark::DoNotOptimize(J.data());
    }
  }
}
BENCHMARK(jacobian_one_by_one)->Name("contact/jacobian_one_by_one/allegro_ball");

void min_distance(benchmark::State& state) {
  Grasp g;
  std::vector<int> pairs(g.model->pairs().size());
  std::iota(pairs.begin(), pairs.end(), 0);
  for (auto _ : state) benchmark::DoNotOptimize(contact::calc_min_distance(*g.model, g.kinematics, pairs, -1.0, g.work));
}
BENCHMARK(min_distance)->Name("contact/min_distance/allegro_ball");

void shape_pair(benchmark::State& state, world::Shape a, world::Shape b) {
  world::Scene scene;
  const world::Pose X{{}, {0.02, 0.03, 0.11}};
  world::ObjectSpec object;
  object.name = "a";
  object.mass = 1;
  object.inertia = Eigen::Matrix3d::Identity();
  object.geometries = {{"g", a, {}, 1.0}};
  scene.objects.push_back(object);
  scene.fixed.push_back(
      {"b", {Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix(), {0, 0, 0}}, {{"g", b, {}, 1.0}}});
  const auto model = world::Model::make(scene);
  world::KinematicsWorkspace kinematics_work(*model);
  world::Kinematics kinematics;
  Eigen::VectorXd q = model->neutral();
  q.head<3>() = X.p;
  world::calc_kinematics(*model, q, kinematics_work, kinematics);
  contact::Workspace work(*model);
  for (auto _ : state) {
    const contact::Distance d = contact::pair_distance(*model, kinematics, 0, work);
    benchmark::DoNotOptimize(&d);
  }
}
// All points of one pair, the first shape flat on the second or `tilt` away from that.
void flat_pair(benchmark::State& state, world::Shape a, world::Shape b, double height, double tilt) {
  world::Scene scene;
  world::ObjectSpec object;
  object.name = "a";
  object.mass = 1;
  object.inertia = Eigen::Matrix3d::Identity();
  object.geometries = {{"g", a, {}, 1.0}};
  scene.objects.push_back(object);
  scene.fixed.push_back({"b", {}, {{"g", b, {}, 1.0}}});
  const auto model = world::Model::make(scene);
  world::KinematicsWorkspace kinematics_work(*model);
  world::Kinematics kinematics;
  Eigen::VectorXd q = model->neutral();
  const Eigen::Quaterniond turned(Eigen::AngleAxisd(tilt, Eigen::Vector3d(1, 0.3, 0).normalized()) *
                                  Eigen::AngleAxisd(0.4, Eigen::Vector3d::UnitZ()));
  q.head<7>() << 0.01, 0.02, height, turned.coeffs();
  world::calc_kinematics(*model, q, kinematics_work, kinematics);
  contact::Workspace work(*model);
  std::vector<contact::Contact> contacts;
  for (auto _ : state) {
    contact::query(*model, kinematics, {}, work, contacts);
    benchmark::DoNotOptimize(contacts.data());
  }
  state.counters["contacts"] = static_cast<double>(contacts.size());
}
const world::Box kBox{{0.05, 0.04, 0.06}};
const world::Capsule kCapsule{0.02, 0.05};
const world::Cylinder kCylinder{0.04, 0.05};
BENCHMARK_CAPTURE(shape_pair, sphere_box, world::Sphere{0.03}, kBox)->Name("contact/distance/sphere_box");
BENCHMARK_CAPTURE(shape_pair, capsule_capsule, kCapsule, kCapsule)->Name("contact/distance/capsule_capsule");
BENCHMARK_CAPTURE(shape_pair, capsule_box, kCapsule, kBox)->Name("contact/distance/capsule_box");
BENCHMARK_CAPTURE(shape_pair, box_box, kBox, kBox)->Name("contact/distance/box_box");
BENCHMARK_CAPTURE(shape_pair, box_cylinder, kBox, kCylinder)->Name("contact/distance/box_cylinder");
BENCHMARK_CAPTURE(flat_pair, box_box, kBox, kBox, 0.12, 0.0)->Name("contact/patch/box_box");
BENCHMARK_CAPTURE(flat_pair, box_box_tilted, kBox, kBox, 0.123, 0.05)->Name("contact/patch/box_box_tilted");
BENCHMARK_CAPTURE(flat_pair, box_halfspace, kBox, world::HalfSpace{}, 0.06, 0.0)->Name("contact/patch/box_halfspace");
BENCHMARK_CAPTURE(flat_pair, cylinder_halfspace, kCylinder, world::HalfSpace{}, 0.05, 0.0)->Name("contact/patch/cylinder_halfspace");
BENCHMARK_CAPTURE(flat_pair, box_cylinder, kBox, kCylinder, 0.11, 0.0)->Name("contact/patch/box_cylinder");

}  // namespace

BENCHMARK_MAIN();
