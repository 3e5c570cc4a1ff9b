#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "stiction/simulation/plant_impl.hpp"

namespace stiction::simulation {
namespace {

void tilt_upright_cylinders(const Plant::Impl& plant, mjData* d) {
  constexpr double kRounding = 1e-10, kTilt = 1e-8;  // [rad]
  const mjModel* m = plant.mujoco.get();
  mj_kinematics(m, d);
  const auto axis = [&](int geom) {
    return Eigen::Vector3d(d->geom_xmat[9 * geom + 2], d->geom_xmat[9 * geom + 5], d->geom_xmat[9 * geom + 8]);
  };
  for (int p = 0; p < m->npair; ++p) {
    int plane = m->pair_geom1[p], cylinder = m->pair_geom2[p];
    if (m->geom_type[plane] != mjGEOM_PLANE) std::swap(plane, cylinder);
    if (m->geom_type[plane] != mjGEOM_PLANE || m->geom_type[cylinder] != mjGEOM_CYLINDER) continue;
    const int joint = m->body_jntadr[m->geom_bodyid[cylinder]];
    if (joint < 0 || m->jnt_type[joint] != mjJNT_FREE) continue;
    const double tilt = axis(cylinder).cross(axis(plane)).norm();
    if (tilt == 0 || tilt > kRounding) continue;
    const mjtNum turn[] = {kTilt, 0.7 * kTilt, 0.4 * kTilt};
    mju_quatIntegrate(d->qpos + m->jnt_qposadr[joint] + 3, turn, 1.0);
  }
}

}  // namespace

void start_at(const Plant::Impl& plant, const VectorRef& q, mjData* data) {
  copy_to_qpos(plant, q, data->qpos);
  tilt_upright_cylinders(plant, data);
  const mjModel* m = plant.mujoco.get();
  mj_kinematics(m, data);
  mj_comPos(m, data);
  mj_makeM(m, data);
}

/// MuJoCo counts its warnings in the data, even those that it does not print.
std::string find_fault(const Plant::Impl& plant, const mjData* data, const world::MujocoReport& report, double t) {
  if (report.failed) return report.error;
  mjtNum largest = 0;
  for (int i = 0; i < plant.mujoco->nq; ++i) largest = std::max(largest, std::isfinite(data->qpos[i]) ? std::abs(data->qpos[i]) : mjMAXVAL);
  for (int i = 0; i < plant.mujoco->nv; ++i) largest = std::max(largest, std::isfinite(data->qvel[i]) ? std::abs(data->qvel[i]) : mjMAXVAL);
  if (largest >= mjMAXVAL) return fmt::format("positions or velocities out of range after {:.6g} s", t);
  for (int w = 0; w < mjNWARNING; ++w) {
    if (data->warning[w].number > 0) return mju_warningText(w, static_cast<size_t>(data->warning[w].lastinfo));
  }
  return report.warnings.empty() ? std::string() : report.warnings.front();
}

}  // namespace stiction::simulation
