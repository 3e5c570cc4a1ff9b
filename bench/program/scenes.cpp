#include "scenes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>

#include "stiction/core/invalid_input.hpp"
#include "stiction/dynamics/step.hpp"

namespace stiction::app {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;
using world::Model;

world::Scene ground_scene() {
  world::Scene scene;
  scene.name = "bench";
  scene.contact_distance = 0.02;
  scene.fixed.push_back(
      {.name = "ground", .X_WB = {}, .geometries = {{.name = "plane", .shape = world::HalfSpace{}, .X_BG = {}, .friction = 0.5}}});
  return scene;
}

/// The same state at rest again and again, reached from one that lies a little higher: a step from the very same one would find its contacts
/// in the workspace.
Scenario at_rest(const world::Scene& scene, const std::vector<Vector3d>& positions) {
  Scenario out;
  out.model = Model::make(scene);
  VectorXd q = out.model->neutral();
  for (std::size_t i = 0; i < positions.size(); ++i) q.segment<3>(out.model->objects()[i].q_begin) = positions[i];
  const VectorXd u(0);
  VectorXd q_before = q;
  for (std::size_t i = 0; i < positions.size(); ++i) q_before[out.model->objects()[i].q_begin + 2] += 1e-6;
  out.states.assign(20, {q_before, u, q, u});
  return out;
}

/// Rows of numbers after a header line.
std::vector<VectorXd> read_csv(const std::filesystem::path& file) {
  std::ifstream in(file);
  if (!in) core::throw_invalid(file.string(), "no such file", "the commands of the stacking scene");
  std::vector<VectorXd> rows;
  std::string line;
  std::getline(in, line);
  while (std::getline(in, line)) {
    std::vector<double> values;
    std::stringstream cells(line);
    for (std::string cell; std::getline(cells, cell, ',');) values.push_back(std::stod(cell));
    rows.push_back(Eigen::Map<VectorXd>(values.data(), static_cast<Eigen::Index>(values.size())));
  }
  return rows;
}

/// Linear between rows (t, u).
VectorXd command_at(const std::vector<VectorXd>& rows, double t) {
  const auto after = std::upper_bound(rows.begin(), rows.end(), t, [](double x, const VectorXd& row) { return x < row[0]; });
  if (after == rows.begin()) return rows.front().tail(rows.front().size() - 1);
  if (after == rows.end()) return rows.back().tail(rows.back().size() - 1);
  const VectorXd &a = *(after - 1), &b = *after;
  return (a + (b - a) * ((t - a[0]) / (b[0] - a[0]))).tail(a.size() - 1);
}

}  // namespace

Scenario make_stacking(const std::filesystem::path& models_dir, double h) {
  Scenario out;
  out.model = Model::make(world::load_scene(models_dir / "stacking.yaml"));
  const Model& model = *out.model;
  const auto commands = read_csv(models_dir / "stacking_commands.csv");
  constexpr double kPlaces[10][3] = {{0.55, 0, 0.03},     {0.70, 0, 0.04},    {0.70, 0, 0.115},  {0.70, 0, 0.19},    {0.50, -0.2, 0.04},
                                     {0.50, -0.2, 0.115}, {0.50, -0.2, 0.19}, {0.45, 0.2, 0.04}, {0.45, 0.2, 0.115}, {0.48, 0.3, 0.04}};
  VectorXd q = model.neutral(), u = command_at(commands, 0);
  for (std::size_t i = 0; i < 10; ++i) q.segment<3>(model.objects()[i].q_begin) = Vector3d(kPlaces[i][0], kPlaces[i][1], kPlaces[i][2]);
  q.tail(model.n_a()) = u;
  dynamics::StepWorkspace work(out.model);
  dynamics::StepResult step;
  VectorXd q_before = q, u_before = u;
  const int steps = static_cast<int>(std::lround(commands.back()[0] / h));
  for (int i = 1; i <= steps; ++i) {
    u = command_at(commands, i * h);
    out.states.push_back({q_before, u_before, q, u});
    const auto status = dynamics::step(model, {q, u}, {.h = h}, work, step);
    if (status != core::Status::Solved) core::throw_invalid("stacking", fmt::format("no solution at {:.1f} s", i * h), "a step");
    q_before = q, u_before = u, q = step.q_next;
  }
  return out;
}

Scenario make_feet(int n) {
  world::Scene scene = ground_scene();
  world::ObjectSpec object;
  object.name = "body";
  object.mass = 1;
  object.inertia = 0.01 * Eigen::Matrix3d::Identity();
  for (int i = 0; i < n; ++i) {  // on a spiral, so that no three of them are in line
    const double turn = 2.4 * i, radius = 0.1 * std::sqrt((i + 0.5) / n);
    world::GeometrySpec foot{.name = fmt::format("foot_{}", i), .shape = world::Sphere{0.005}, .X_BG = {}, .friction = 0.8};
    foot.X_BG.p = {radius * std::cos(turn), radius * std::sin(turn), -0.045};
    object.geometries.push_back(foot);
  }
  scene.objects.push_back(object);
  return at_rest(scene, {{0, 0, 0.05}});
}

Scenario make_tower(int n) {
  world::Scene scene = ground_scene();
  std::vector<Vector3d> positions;
  for (int i = 0; i < n; ++i) {
    world::ObjectSpec object;
    object.name = fmt::format("box_{}", i);
    object.mass = 0.5;
    object.inertia = 0.5 * 0.08 * 0.08 / 6 * Eigen::Matrix3d::Identity();
    object.geometries.push_back({.name = "cube", .shape = world::Box{Vector3d::Constant(0.04)}, .X_BG = {}, .friction = 1.0});
    scene.objects.push_back(object);
    positions.emplace_back(0, 0, 0.04 + 0.08 * i);
  }
  return at_rest(scene, positions);
}

}  // namespace stiction::app
