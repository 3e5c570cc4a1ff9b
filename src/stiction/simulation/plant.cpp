#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "stiction/core/invalid_input.hpp"
#include "stiction/simulation/plant_impl.hpp"
#include "stiction/world/call_mujoco.hpp"
#include "stiction/world/joint_motor.hpp"

namespace stiction::simulation {

namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// Fills the maps from indices of the model to those of MuJoCo.
void find_addresses(Plant::Impl& plant) {
  const world::Model& model = *plant.model;
  const mjModel* m = plant.mujoco.get();
  for (const auto& body : model.bodies()) plant.body_id.push_back(mj_name2id(m, mjOBJ_BODY, body.name.c_str()));
  plant.geometry_of.assign(at(static_cast<int>(m->ngeom)), -1);
  for (std::size_t i = 0; i < model.geometries().size(); ++i) {
    plant.geometry_of[at(mj_name2id(m, mjOBJ_GEOM, model.geometries()[i].name.c_str()))] = static_cast<int>(i);
  }
  const std::size_t n = model.geometries().size();
  plant.pair_of.assign(n * n, -1);
  for (std::size_t i = 0; i < model.pairs().size(); ++i) {
    const auto& pair = model.pairs()[i];
    plant.pair_of[at(pair.geometry_a) * n + at(pair.geometry_b)] = static_cast<int>(i);
  }
  for (int v = 0; v < model.n_v();) {
    const int joint = mj_name2id(m, mjOBJ_JOINT, model.dofs()[at(v)].name.c_str());
    const int n_v = m->jnt_type[joint] == mjJNT_FREE ? 6 : 1;
    plant.q_address.push_back(m->jnt_qposadr[joint]);
    for (int k = 0; k < n_v; ++k) plant.v_address.push_back(m->jnt_dofadr[joint] + k);
    v += n_v;
  }
  for (const world::Follower& follower : model.followers()) {
    const int joint = mj_name2id(m, mjOBJ_JOINT, follower.name.c_str());
    plant.follower_q_address.push_back(m->jnt_qposadr[joint]);
    plant.follower_v_address.push_back(m->jnt_dofadr[joint]);
  }
  for (int j = 0; j < model.n_a(); ++j) {
    plant.actuator_id.push_back(mj_name2id(m, mjOBJ_ACTUATOR, model.dofs()[at(model.n_vu() + j)].name.c_str()));
  }
}

/// MuJoCo keeps the lower triangle of the mass matrix, by rows.
void find_inertia_terms(Plant::Impl& plant) {
  const mjModel* m = plant.mujoco.get();
  std::vector<int> coordinate(at(static_cast<int>(m->nv)), -1);  // coordinate of the model that moves each joint of the simulation
  std::vector<double> ratio(coordinate.size(), 1);
  for (int i = 0; i < plant.model->n_v(); ++i) coordinate[at(plant.v_address[at(i)])] = i;
  for (std::size_t i = 0; i < plant.follower_v_address.size(); ++i) {
    const world::Follower& follower = plant.model->followers()[i];
    coordinate[at(plant.follower_v_address[i])] = follower.dof;
    ratio[at(plant.follower_v_address[i])] = follower.ratio;
  }
  for (int row = 0; row < m->nv; ++row) {
    for (int entry = m->M_rowadr[row]; entry < m->M_rowadr[row] + m->M_rownnz[row]; ++entry) {
      const int column = m->M_colind[entry];
      if (coordinate[at(row)] < 0 || coordinate[at(row)] != coordinate[at(column)]) continue;
      plant.inertia_terms.push_back({coordinate[at(row)], entry, (row == column ? 1 : 2) * ratio[at(row)] * ratio[at(column)]});
    }
  }
}

Eigen::VectorXd calc_inertia_at_neutral(const Plant::Impl& plant) {
  const mjModel* m = plant.mujoco.get();
  const std::unique_ptr<mjData, DeleteMujoco> data(mj_makeData(m));
  copy_to_qpos(plant, plant.model->neutral(), data->qpos);
  const auto report = world::call_mujoco([&] { mj_fwdPosition(m, data.get()); });
  if (report.failed) core::throw_invalid("scene", fmt::format("'{}'", report.error), "a scene that MuJoCo simulates");
  Eigen::VectorXd out;
  calc_inertia(plant, *data, out);
  return out;
}

/// MuJoCo derives the softness of a contact from the motion of its bodies under forces on their centres of mass, averaged over directions.
/// Such forces do not move a body whose centre lies on its joint axes. A contact of two such links, or of one with the ground, is then
/// rigid, and its equations have no solution. This function gives such bodies the motion that a force on their surface causes.
void weigh_surfaces(mjModel* m) {
  constexpr double kRounding = 1e-9;
  for (int body = 1; body < m->nbody; ++body) {
    double radius = 0;  // distance of the farthest surface point [m]
    for (int g = m->body_geomadr[body]; g >= 0 && g < m->body_geomadr[body] + m->body_geomnum[body]; ++g)
      radius = std::max(radius, mju_dist3(m->geom_pos + 3 * g, m->body_ipos + 3 * body) + m->geom_rbound[g]);
    mjtNum* weight = m->body_invweight0 + 2 * body;
    const double at_surface = 2.0 / 3 * weight[1] * radius * radius;  // ‖ω × r‖², averaged over directions
    if (weight[0] < kRounding * at_surface) weight[0] = at_surface;
  }
}

/// Damps the joints of objects, so that they come to rest within rest_time.
void damp_objects(const Plant::Impl& plant, const Eigen::VectorXd& inertia) {
  for (std::size_t i = 0; i < plant.model->objects().size(); ++i) {
    if (plant.model->scene().objects[i].joint == world::ObjectJoint::Free) continue;
    const auto& object = plant.model->objects()[i];
    for (int v = object.v_begin; v < object.v_begin + object.n_v; ++v)
      plant.mujoco->dof_damping[plant.v_address[at(v)]] += inertia[v] / plant.options.rest_time;
  }
}

}  // namespace

void ContactOptions::validate(double timestep) const {
  core::require_positive("contact.time_constant", time_constant);
  if (time_constant < 2 * timestep) {
    core::throw_invalid("contact.time_constant", fmt::format("{} s", time_constant), fmt::format("at least 2 timesteps of {} s", timestep));
  }
  core::require_positive("contact.friction_time_constant", friction_time_constant);
  if (friction_time_constant < 2 * timestep) {
    core::throw_invalid("contact.friction_time_constant", fmt::format("{} s", friction_time_constant),
                        fmt::format("at least 2 timesteps of {} s", timestep));
  }
  if (!(impedance > 0 && impedance <= mjMAXIMP)) {
    core::throw_invalid("contact.impedance", fmt::format("{}", impedance), fmt::format("a number in (0, {}]", mjMAXIMP));
  }
  if (!(friction_stiffening >= 1) || !std::isfinite(friction_stiffening)) {
    core::throw_invalid("contact.friction_stiffening", fmt::format("{}", friction_stiffening), "a number ≥ 1");
  }
  if (noslip_iterations < 0) core::throw_invalid("contact.noslip_iterations", fmt::format("{}", noslip_iterations), "an integer ≥ 0");
  core::require_nonnegative("contact.friction_scale", friction_scale);
  if (!(ground_softness >= 1) || !std::isfinite(ground_softness))
    core::throw_invalid("contact.ground_softness", fmt::format("{}", ground_softness), "a number ≥ 1");
}

void PlantOptions::validate() const {
  core::require_positive("timestep", timestep);
  core::require_nonnegative("damping_ratio", damping_ratio);
  core::require_positive("mass_scale", mass_scale);
  core::require_nonnegative("armature", armature);
  core::require_positive("spring_resolution", spring_resolution);
  if (!(rest_time > 0)) core::throw_invalid("rest_time", fmt::format("{}", rest_time), "a number > 0, or infinity");
  contact.validate(timestep);
}

Plant::Plant(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Plant::~Plant() = default;

std::shared_ptr<const Plant> Plant::make(std::shared_ptr<const world::Model> model, const PlantOptions& options) {
  options.validate();
  auto impl = std::make_unique<Impl>();
  impl->model = std::move(model);
  impl->options = options;
  const Eigen::VectorXd& stiffness = impl->model->stiffness();
  const double period = options.timestep / options.spring_resolution;
  impl->armature = (stiffness * period * period).cwiseMax(options.armature);
  const std::span<const world::JointMotor> motors = world::joint_motors(*impl->model);
  for (std::size_t j = 0; j < motors.size(); ++j) {
    double& armature = impl->armature[static_cast<Eigen::Index>(j)];
    armature = std::max(armature, motors[j].armature);
  }
  impl->mujoco = compile_scene(*impl->model, options, impl->armature);
  weigh_surfaces(impl->mujoco.get());
  find_addresses(*impl);
  find_inertia_terms(*impl);
  const Eigen::VectorXd inertia = calc_inertia_at_neutral(*impl);
  calc_damping(*impl, inertia, impl->damping);
  damp_objects(*impl, inertia);
  return std::shared_ptr<const Plant>(new Plant(std::move(impl)));
}

const world::Model& Plant::model() const { return *impl_->model; }
const PlantOptions& Plant::options() const { return impl_->options; }
const Eigen::VectorXd& Plant::damping() const { return impl_->damping; }
const Eigen::VectorXd& Plant::armature() const { return impl_->armature; }

void calc_inertia(const Plant::Impl& plant, const mjData& data, Eigen::VectorXd& out) {
  out.setZero(plant.model->n_v());
  for (const Plant::Impl::InertiaTerm& term : plant.inertia_terms) out[term.coordinate] += term.weight * data.M[term.entry];
}

void calc_damping(const Plant::Impl& plant, const Eigen::VectorXd& inertia, Eigen::VectorXd& out) {
  const Eigen::VectorXd& stiffness = plant.model->stiffness();
  out = 2 * plant.options.damping_ratio * stiffness.cwiseProduct(inertia.tail(stiffness.size())).cwiseSqrt();
  const std::span<const world::JointMotor> motors = world::joint_motors(*plant.model);
  for (Eigen::Index j = 0; j < out.size(); ++j) out[j] = std::max(out[j], motors[static_cast<std::size_t>(j)].damping);
}

void copy_to_qpos(const Plant::Impl& plant, const VectorRef& q, mjtNum* qpos) {
  Eigen::Index from = 0;
  for (std::size_t j = 0, v = 0; j < plant.q_address.size(); ++j) {
    mjtNum* to = qpos + plant.q_address[j];
    const bool free = plant.mujoco->jnt_type[plant.mujoco->dof_jntid[plant.v_address[v]]] == mjJNT_FREE;
    if (free) {
      for (Eigen::Index k = 0; k < 3; ++k) to[k] = q[from + k];
      to[3] = q[from + 6];
      for (Eigen::Index k = 0; k < 3; ++k) to[4 + k] = q[from + 3 + k];
    } else {
      to[0] = q[from];
    }
    from += free ? 7 : 1;
    v += free ? 6 : 1;
  }
  const world::Model& model = *plant.model;
  for (std::size_t i = 0; i < plant.follower_q_address.size(); ++i) {
    const world::Follower& follower = model.followers()[i];
    qpos[plant.follower_q_address[i]] = follower.offset + follower.ratio * q[model.n_qu() + follower.dof - model.n_vu()];
  }
}

void copy_from_qpos(const Plant::Impl& plant, const mjtNum* qpos, Eigen::Ref<Eigen::VectorXd> q) {
  Eigen::Index to = 0;
  for (std::size_t j = 0, v = 0; j < plant.q_address.size(); ++j) {
    const mjtNum* from = qpos + plant.q_address[j];
    const bool free = plant.mujoco->jnt_type[plant.mujoco->dof_jntid[plant.v_address[v]]] == mjJNT_FREE;
    if (free) {
      for (Eigen::Index k = 0; k < 3; ++k) q[to + k] = from[k];
      q[to + 6] = from[3];
      for (Eigen::Index k = 0; k < 3; ++k) q[to + 3 + k] = from[4 + k];
    } else {
      q[to] = from[0];
    }
    to += free ? 7 : 1;
    v += free ? 6 : 1;
  }
}

}  // namespace stiction::simulation
