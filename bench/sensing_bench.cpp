// Residuals, nearest points, cycles and discrimination. The case of Figs 4-6 and 4-10 on an iiwa of capsules.
#include <benchmark/benchmark.h>
#include <coal/BVH/BVH_model.h>
#include <coal/distance.h>
#include <coal/shape/geometric_shapes.h>

#include <filesystem>
#include <memory>
#include <vector>

#include "stiction/sensing/discriminate.hpp"
#include "stiction/sensing/scenario.hpp"
#include "stiction/world/read.hpp"

namespace {

using namespace stiction;
using Eigen::Vector3d;
using Eigen::VectorXd;

std::shared_ptr<const sensing::Sensor> make_sensor(const std::string& urdf, sensing::SensorOptions options) {
  const std::vector<std::filesystem::path> packages{STICTION_PACKAGE_DIR};
  const auto scene = world::parse_scene("robots: [{name: arm, urdf: '" + urdf + "'}]", STICTION_SOURCE_DIR, packages);
  return sensing::Sensor::make(world::Model::make(scene), options);
}

const sensing::Sensor& iiwa() {
  static const auto sensor = [] {
    sensing::SensorOptions options;
    options.links = {"arm/link_5", "arm/link_6"};
    options.sampling = sensing::Sampling::Uniform;
    return make_sensor("models/iiwa_primitives.urdf", options);
  }();
  return *sensor;
}

std::shared_ptr<const sensing::Sensor> ur5() {
  static const auto sensor = make_sensor("package://example-robot-data/robots/ur_description/urdf/ur5_robot.urdf", {});
  return sensor;
}

const VectorXd kQ = (VectorXd(7) << -1.75956086, 0.74755266, 2.72834054, 2.05278647, 2.3270361, -1.27883698, 0.61326711).finished();
const VectorXd kTau = (VectorXd(7) << 0.966613398, -2.82202806, -0.00160744425, 0.662280818, 0.0319086728, 0.0817417009, 0).finished();

sensing::LinkTorque make_torque(const sensing::Sensor& sensor, int link) {
  world::KinematicsWorkspace work(sensor.model());
  world::Kinematics kinematics;
  world::calc_kinematics(sensor.model(), kQ, work, kinematics);
  Eigen::Matrix3Xd J_w, J_v;
  sensing::calc_link_jacobian(sensor.model(), kinematics, sensor.links()[static_cast<std::size_t>(link)].surface.body, J_w, J_v);
  return {J_w, J_v, kTau};
}

void residual(benchmark::State& state) {
  const auto& link = iiwa().links()[1];
  const sensing::LinkTorque torque = make_torque(iiwa(), 1);
  const sensing::FrictionCone cone(1, static_cast<int>(state.range(0)));
  Eigen::Index i = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(sensing::calc_residual(torque, link.batch.p_L(i), link.batch.R_LC(i), cone).value);
    if (++i == link.batch.size) i = 0;
  }
}
BENCHMARK(residual)->Arg(4)->Arg(8)->Arg(0);

void residual_batched(benchmark::State& state) {
  const auto& link = iiwa().links()[1];
  const sensing::LinkTorque torque = make_torque(iiwa(), 1);
  const sensing::FrictionCone cone(1, static_cast<int>(state.range(0)));
  VectorXd values(link.batch.rows.cols());
  for (auto _ : state) {
    sensing::calc_residuals(torque, link.batch, cone, values);
    benchmark::DoNotOptimize(values.data());
  }
  state.SetItemsProcessed(state.iterations() * link.batch.size);
}
BENCHMARK(residual_batched)->Arg(4)->Arg(8);

/// Points a few millimetres off the forearm of the UR5, as a descent asks.
std::vector<Vector3d> near_points(const sensing::Surface& surface) {
  std::vector<Vector3d> out;
  for (const auto& s : sensing::sample_surface(surface, 1000, sensing::Sampling::Uniform, 1))
    out.push_back(s.p_L + 0.01 * surface.size * surface.normals.col(s.triangle));
  return out;
}

void nearest_own(benchmark::State& state) {
  const auto& surface = ur5()->links()[2].surface;
  const auto points = near_points(surface);
  std::size_t i = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(surface.tree.closest(points[i]).point);
    if (++i == points.size()) i = 0;
  }
}
BENCHMARK(nearest_own);

void nearest_coal(benchmark::State& state) {
  const auto& surface = ur5()->links()[2].surface;
  const auto points = near_points(surface);
  auto mesh = std::make_shared<coal::BVHModel<coal::OBBRSS>>();
  mesh->beginModel();
  for (int t = 0; t < surface.tree.size(); ++t)
    mesh->addTriangle(surface.tree.corner(t, 0), surface.tree.corner(t, 1), surface.tree.corner(t, 2));
  mesh->endModel();
  const coal::Sphere ball(1e-6);
  const coal::DistanceRequest request(true);
  coal::DistanceResult result;
  std::size_t i = 0;
  for (auto _ : state) {
    result.clear();
    coal::distance(mesh.get(), coal::Transform3s::Identity(), &ball, coal::Transform3s(coal::Matrix3s::Identity(), points[i]), request,
                   result);
    benchmark::DoNotOptimize(result.nearest_points[0]);
    if (++i == points.size()) i = 0;
  }
}
BENCHMARK(nearest_coal);

void cycle(benchmark::State& state, sensing::Method method) {
  sensing::SenseOptions options;
  options.noise = 1e-3;
  options.accept = 0.2;  // δ = 0.1 of the thesis
  options.method = method;
  const std::shared_ptr<const sensing::Sensor> sensor(std::shared_ptr<void>(), &iiwa());
  sensing::SenseWorkspace work(sensor);
  sensing::SenseResult result;
  for (auto _ : state) sensing::sense(*sensor, {kQ, kTau}, options, work, result);
  state.counters["accepted"] = result.accepted;
  state.counters["descents"] = result.descents;
  state.counters["converged"] = result.converged;
}
BENCHMARK_CAPTURE(cycle, rejection, sensing::RejectionSampling{});
BENCHMARK_CAPTURE(cycle, rsgd, sensing::SteepestDescent{});
BENCHMARK_CAPTURE(cycle, gauss_newton, sensing::GaussNewton{});

/// Ten points on the last three links of the UR5.
void discrimination(benchmark::State& state) {
  const auto sensor = ur5();
  core::Random random(static_cast<std::uint64_t>(state.range(0)), 0);
  std::vector<sensing::Candidate> candidates(10);
  for (auto& candidate : candidates) {
    const int link = 3 + random.index(3);
    const auto& surface = sensor->links()[static_cast<std::size_t>(link)].surface;
    const auto sample = sensing::sample_surface(surface, 1, sensing::Sampling::Uniform, random.bits())[0];
    candidate.best.link = link;
    candidate.best.p_L = sample.p_L;
    candidate.best.n_L = surface.normals.col(sample.triangle);
  }
  VectorXd q(6);
  for (double& x : q) x = random.uniform(-2, 2);
  sensing::Discrimination out;
  for (auto _ : state) (void)sensing::discriminate(*sensor, q, candidates, {}, out);
  state.counters["programs"] = static_cast<double>(out.nodes);
  state.counters["solved"] = out.status == core::Status::Solved;
}
BENCHMARK(discrimination)->DenseRange(0, 7);

}  // namespace

BENCHMARK_MAIN();
