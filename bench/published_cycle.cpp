#include "published_cycle.hpp"

#ifdef STICTION_HAS_PROXQP
#include <chrono>

#include "descent_trace.hpp"
#include "proxqp.hpp"
#include "stiction/sensing/residual_map.hpp"

namespace stiction::bench {
namespace {

using Eigen::Index;

/// (4.5) as a program of β ≥ 0.
class QpResidual {
 public:
  explicit QpResidual(int rays)
      : solver_(rays, 0, rays, {.residual = 1e-5, .max_iterations = 10000, .warm_start = true}) {  // a hundredth of OSQP's
    program_.C.setIdentity(rays, rays);
    program_.lower.setZero(rays);
    program_.upper.setConstant(rays, 1e20);
  }

  sensing::ContactPoint evaluate(const sensing::LinkTorque& torque, const sensing::FrictionCone& cone, const sensing::ContactPoint& point) {
    const Eigen::Matrix3d R_LC = sensing::make_contact_frame(point.n_L);
    const Eigen::MatrixXd J = (torque.torque_map(point.p_L) * R_LC * cone.ray_matrix()).transpose();
    program_.H = 2 * J * J.transpose();
    program_.g = -2 * J * torque.R_tau;
    unsolved_ += !solver_.solve(program_);
    sensing::ContactPoint out = point;
    out.f_L = R_LC * cone.ray_matrix() * solver_.x();
    out.residual = (J.transpose() * solver_.x() - torque.R_tau).squaredNorm();
    return out;
  }

  int unsolved() const { return unsolved_; }

 private:
  ProxQp solver_;
  QuadraticProgram program_;
  int unsolved_ = 0;
};

}  // namespace

std::optional<PublishedCycle> time_published_cycle(const sensing::Sensor& sensor, const Eigen::VectorXd& q, const Eigen::VectorXd& tau,
                                                   const sensing::FrictionCone& cone, double accept, int repeat) {
  using Clock = std::chrono::steady_clock;
  const auto seconds = [](Clock::time_point since) { return std::chrono::duration<double>(Clock::now() - since).count(); };
  PublishedCycle out;
  QpResidual qp(cone.rays());
  for (int r = 0; r < repeat; ++r) {
    const auto begin = Clock::now();
    const std::vector<sensing::LinkTorque> torques = sensing::make_link_torques(sensor, q, tau);
    std::vector<sensing::ContactPoint> starts;
    Index samples = 0;
    for (std::size_t i = 0; i < torques.size(); ++i) {
      const sensing::SensedLink& link = sensor.links()[i];
      for (const sensing::SurfacePoint& sample : link.samples) {
        const sensing::ContactPoint point{
            .link = static_cast<int>(i), .triangle = sample.triangle, .p_L = sample.p_L, .n_L = link.surface.normals.col(sample.triangle)};
        ++samples;
        starts.push_back(qp.evaluate(torques[i], cone, point));
        if (starts.back().residual > accept) starts.pop_back();
      }
    }
    out.residuals.push_back(seconds(begin) / static_cast<double>(samples));
    for (const sensing::ContactPoint& start : starts) {
      const auto link = static_cast<std::size_t>(start.link);
      const auto evaluate = [&](const sensing::ContactPoint& point) { return qp.evaluate(torques[link], cone, point); };
      descend(evaluate, sensor.links()[link], torques[link], sensing::Normals::Flat, sensing::SenseOptions{}.tolerance, start, nullptr);
    }
    out.cycles.push_back(seconds(begin));
    out.accepted = static_cast<int>(starts.size());
  }
  out.unsolved = qp.unsolved();
  return out;
}

}  // namespace stiction::bench
#else
namespace stiction::bench {
std::optional<PublishedCycle> time_published_cycle(const sensing::Sensor&, const Eigen::VectorXd&, const Eigen::VectorXd&,
                                                   const sensing::FrictionCone&, double, int) {
  return std::nullopt;
}
}  // namespace stiction::bench
#endif
