#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <functional>
#include <initializer_list>

#include "cone_allocations.hpp"
#include "descent_trace.hpp"
#include "published_cycle.hpp"
#include "stiction/core/quantile.hpp"
#include "stiction/core/random.hpp"
#include "stiction/sensing/discriminate.hpp"
#include "stiction/sensing/sense.hpp"
#include "stiction/tasks/task.hpp"
#include "stiction/world/cache_file.hpp"
#include "stiction/world/read.hpp"
#include "table.hpp"

namespace stiction::app {
namespace {

/// Published [s]: T. Pang, PhD thesis, MIT 2023, section 4.7, one thread of an i7-8700B with OSQP, FCL and GUROBI. A cycle: 1000 residuals of 6 µs and 184
/// descents of 472 µs, which the text calls roughly 10 Hz. Peer: the same algorithm with ProxQP for every residual, on this machine in this run.
constexpr Reference kResidual = {6e-6, {}};
constexpr Reference kDescent = {472e-6, {}};
constexpr Reference kCycle = {1000 * 6e-6 + 184 * 472e-6, {}};
constexpr Reference kDiscrimination = {5e-3, {}};
constexpr int kLoops = 200;      // over all samples of a link, or cycles, per repetition
constexpr int kCandidates = 10;  // to tell apart
constexpr int kPrograms = 8;     // random sets of them
constexpr double kAccept = 0.2;  // δ = 0.1 of ½ ‖·‖² in the thesis's figures [(N m)²]
constexpr double kNoise = 1e-3;  // [N m]
constexpr int kPeerCycles = 3;   // of the published algorithm, of which each takes tens of milliseconds, per repetition
constexpr int kSteps = 20;       // solves of a program, of which each takes a fraction of a millisecond

/// The case of Figs 4-6, 4-7 and 4-10: 500 samples on each of links 5 and 6.
struct Measurement {
  std::shared_ptr<const sensing::Sensor> sensor;
  Eigen::VectorXd q{{-1.75956086, 0.74755266, 2.72834054, 2.05278647, 2.3270361, -1.27883698, 0.61326711}};
  Eigen::VectorXd tau{{0.966613398, -2.82202806, -0.00160744425, 0.662280818, 0.0319086728, 0.0817417009, 0}};

  Measurement(const std::filesystem::path& models_dir, const std::string& urdf) {
    const auto scene =
        world::parse_scene(fmt::format("robots: [{{name: arm, urdf: {}}}]", urdf), models_dir, tasks::default_package_dirs());
    sensing::SensorOptions options;
    options.surface.cache_dir = world::default_cache_dir();
    options.links = {"arm/link_5", "arm/link_6"};
    sensor = sensing::Sensor::make(world::Model::make(scene), options);
  }
  const sensing::SensedLink& link() const { return sensor->links()[1]; }

  sensing::LinkTorque make_torque() const {
    world::KinematicsWorkspace work(sensor->model());
    world::Kinematics kinematics;
    world::calc_kinematics(sensor->model(), q, work, kinematics);
    Eigen::Matrix3Xd J_w, J_v;
    sensing::calc_link_jacobian(sensor->model(), kinematics, link().surface.body, J_w, J_v);
    return {J_w, J_v, tau};
  }
};

/// Times `once`, which does `count` equal things, so often that the clock does not matter.
template <class Once>
Row time_loops(const std::string& name, const Reference& reference, int loops, double count, Once&& once) {
  once();
  std::vector<double> seconds;
  long allocations = 0;
  for (int r = 0; r < loops && !interrupted(); ++r) {
    const long before = bench::allocations();
    const auto start = BenchClock::now();
    once();
    const double elapsed = seconds_since(start);
    allocations = std::max(allocations, bench::allocations() - before);
    seconds.push_back(elapsed / count);
  }
  if (seconds.empty()) seconds.push_back(0);
  return make_row(name, std::move(seconds), reference, allocations, 0);
}

using Make = std::function<const Measurement&()>;

/// The published algorithm with ProxQP in this run, if any row that is wanted has it beside it: a residual and a cycle.
struct Peer {
  std::optional<double> residual, cycle;

  Peer(const BenchTable& table, const Make& measurement, std::initializer_list<std::string> rows) {
    if (std::none_of(rows.begin(), rows.end(), [&](const std::string& row) { return table.wanted(row); })) return;
    const Measurement& m = measurement();
    auto times = bench::time_published_cycle(*m.sensor, m.q, m.tau, sensing::FrictionCone(1, 4), kAccept, kPeerCycles * table.repeat());
    if (!times || times->unsolved > 0) return;
    residual = core::quantile(times->residuals, 0.5);
    cycle = core::quantile(times->cycles, 0.5);
  }
};

void residuals(BenchTable& table, const Make& measurement, const Peer& peer) {
  for (const int rays : {4, 8, 0}) {
    const std::string name = rays > 0 ? fmt::format("residual/rays_{}", rays) : "residual/exact_cone";
    const Reference reference = rays == 4 ? Reference{kResidual.published, peer.residual} : Reference{};
    const bool one_by_one = table.wanted(name), batched = rays > 0 && table.wanted(name + "/batched");
    if (!one_by_one && !batched) continue;
    const sensing::SampleBatch& batch = measurement().link().batch;
    const sensing::LinkTorque torque = measurement().make_torque();
    const sensing::FrictionCone cone(1, rays);
    const auto count = static_cast<double>(batch.size);
    volatile double sink = 0;
    const auto all = [&] {
      double sum = 0;
      for (Eigen::Index i = 0; i < batch.size; ++i) sum += sensing::calc_residual(torque, batch.p_L(i), batch.R_LC(i), cone).value;
      sink = sum;
    };
    Eigen::VectorXd values(batch.rows.cols());
    const auto at_once = [&] {
      sensing::calc_residuals(torque, batch, cone, values);
      sink = values[0];
    };
    if (one_by_one) table.add(time_loops(name, reference, kLoops * table.repeat(), count, all));
    if (batched) table.add(time_loops(name + "/batched", reference, kLoops * table.repeat(), count, at_once));
  }
}

/// From every sample that δ accepts.
template <class Method>
void descents(BenchTable& table, const Make& measurement, const std::string& name, const Method& method, const Reference& reference) {
  if (!table.wanted(name)) return;
  const Measurement& m = measurement();
  const sensing::LinkTorque torque = m.make_torque();
  const sensing::FrictionCone cone(1, 4);
  const sensing::DescentProblem problem{m.link(), 1, torque, cone, m.sensor->options().normals, sensing::SenseOptions{}.tolerance};
  std::vector<sensing::ContactPoint> starts;
  for (const sensing::SurfacePoint& sample : m.link().samples) {
    const sensing::ContactPoint start = sensing::evaluate(problem, sample.triangle, sample.p_L);
    if (start.residual <= kAccept) starts.push_back(start);
  }
  const auto all = [&] {
    for (sensing::ContactPoint point : starts) (void)sensing::descend(problem, method, point);
  };
  table.add(time_loops(name, reference, kLoops * table.repeat(), static_cast<double>(starts.size()), all));
}

/// The parts of Algorithm 4 by themselves, at the points of the same descents: what of a descent each of them takes.
void descent_parts(BenchTable& table, const Make& measurement, const std::string& suffix) {
  const std::string name = "descent/parts/";
  const auto wanted = [&](const char* part) { return table.wanted(name + part + suffix); };
  if (!wanted("residual") && !wanted("retraction") && !wanted("chain_rule")) return;
  const Measurement& m = measurement();
  const sensing::LinkTorque torque = m.make_torque();
  const sensing::FrictionCone cone(1, 4);
  const sensing::DescentProblem problem{m.link(), 1, torque, cone, m.sensor->options().normals, sensing::SenseOptions{}.tolerance};
  const auto evaluate = [&](const sensing::ContactPoint& at) { return sensing::evaluate(problem, at.triangle, at.p_L); };
  bench::DescentTrace trace;
  double starts = 0;
  for (const sensing::SurfacePoint& sample : m.link().samples) {
    const sensing::ContactPoint start = sensing::evaluate(problem, sample.triangle, sample.p_L);
    if (start.residual > kAccept) continue;
    ++starts;
    bench::descend(evaluate, m.link(), torque, problem.normals, problem.tolerance, start, &trace);
  }
  volatile double sink = 0;
  const auto time = [&](const char* part, const auto& queries, const auto& answer) {
    if (!wanted(part)) return;
    table.add(time_loops(name + part + suffix, {}, kLoops * table.repeat(), starts, [&] {
      double sum = 0;
      for (const auto& query : queries) sum += answer(query);
      sink = sum;
    }));
  };
  time("residual", trace.residuals, [&](const sensing::ContactPoint& at) {
    return sensing::calc_residual(torque, at.p_L, sensing::make_contact_frame(at.n_L), cone).value;
  });
  time("retraction", trace.retractions, [&](const bench::DescentTrace::Query& query) {
    const auto closest = m.link().surface.tree.closest(query.p_L, query.triangle);
    return m.link().surface.normal(closest.triangle, closest.point, problem.normals).x();
  });
  time("chain_rule", trace.gradients, [&](const sensing::ContactPoint& at) {
    const Eigen::Vector3d gradient = 0.5 * sensing::calc_gradient(torque, at.p_L, at.f_L);
    return (gradient - at.n_L.dot(gradient) * at.n_L).norm();
  });
}

void cycle(BenchTable& table, const Make& measurement, const std::string& name, const sensing::Method& method, const Peer& peer) {
  if (!table.wanted(name)) return;
  const Measurement& m = measurement();
  sensing::SenseOptions options;
  options.noise = kNoise;
  options.accept = kAccept;
  options.method = method;
  sensing::SenseWorkspace work(m.sensor);
  sensing::SenseResult result;
  table.add(time_loops(name, {kCycle.published, peer.cycle}, kLoops * table.repeat(), 1, [&] {
    sensing::sense(*m.sensor, {m.q, m.tau}, options, work, result);
  }));
}

/// Random points on the last three links of a UR5 at random postures.
void discrimination(BenchTable& table) {
  const std::string name = fmt::format("discriminate/{}", kCandidates);
  if (!table.wanted(name)) return;
  const auto scene =
      world::parse_scene("robots: [{name: arm, urdf: 'package://example-robot-data/robots/ur_description/urdf/ur5_robot.urdf'}]",
                         table.models_dir(), tasks::default_package_dirs());
  const auto sensor = sensing::Sensor::make(world::Model::make(scene));
  std::vector<double> seconds;
  int undecided = 0;
  for (int set = 0; set < kPrograms; ++set) {
    core::Random random(static_cast<std::uint64_t>(set), 0);
    std::vector<sensing::Candidate> candidates(kCandidates);
    for (sensing::Candidate& candidate : candidates) {
      candidate.best.link = 3 + random.index(3);
      const sensing::Surface& surface = sensor->links()[static_cast<std::size_t>(candidate.best.link)].surface;
      const sensing::SurfacePoint point = sensing::sample_surface(surface, 1, sensing::Sampling::Uniform, random.bits())[0];
      candidate.best.p_L = point.p_L;
      candidate.best.n_L = surface.normals.col(point.triangle);
    }
    Eigen::VectorXd q(sensor->model().n_q());
    for (double& x : q) x = random.uniform(-2, 2);
    sensing::Discrimination out;
    for (int r = 0; r < kSteps * table.repeat(); ++r) {
      const auto start = BenchClock::now();
      const core::Status status = sensing::discriminate(*sensor, q, candidates, {}, out);
      seconds.push_back(seconds_since(start));
      undecided += r == 0 && status != core::Status::Solved && status != core::Status::Infeasible;
    }
  }
  table.add(make_row(name, std::move(seconds), kDiscrimination, {}, undecided));
}

/// Whether `make experiments` unpacked the meshes of the iiwa.
bool has_meshes() {
  const auto dirs = tasks::default_package_dirs();
  return std::any_of(dirs.begin(), dirs.end(),
                     [](const auto& dir) { return std::filesystem::exists(dir / "iiwa_description" / "iiwa7" / "link_6.obj"); });
}

/// The same on the meshes of the thesis's arm.
void mesh_rows(BenchTable& table) {
  const std::string steepest = "sense_cycle/steepest_descent/meshes", newton = "sense_cycle/gauss_newton/meshes";
  if (!has_meshes()) return;
  std::optional<Measurement> made;
  const Make measurement = [&]() -> const Measurement& { return made ? *made : made.emplace(table.models_dir(), "iiwa_meshes.urdf"); };
  descents(table, measurement, "descent/steepest/meshes", sensing::SteepestDescent{}, kDescent);
  descent_parts(table, measurement, "/meshes");
  const Peer peer(table, measurement, {steepest, newton});
  cycle(table, measurement, steepest, sensing::SteepestDescent{}, peer);
  cycle(table, measurement, newton, sensing::GaussNewton{}, peer);
}

}  // namespace

void add_sensing_rows(BenchTable& table) {
  std::optional<Measurement> made;
  const Make measurement = [&]() -> const Measurement& { return made ? *made : made.emplace(table.models_dir(), "iiwa_primitives.urdf"); };
  const Peer peer(table, measurement, {"residual/rays_4", "sense_cycle/steepest_descent", "sense_cycle/gauss_newton"});
  residuals(table, measurement, peer);
  descents(table, measurement, "descent/steepest", sensing::SteepestDescent{}, kDescent);
  descent_parts(table, measurement, "");
  descents(table, measurement, "descent/gauss_newton", sensing::GaussNewton{}, {});
  cycle(table, measurement, "sense_cycle/steepest_descent", sensing::SteepestDescent{}, peer);  // Algorithm 4
  cycle(table, measurement, "sense_cycle/gauss_newton", sensing::GaussNewton{}, peer);
  mesh_rows(table);
  discrimination(table);
}

}  // namespace stiction::app
