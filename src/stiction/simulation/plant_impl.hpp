#pragma once

#include <mujoco/mujoco.h>

#include <Eigen/Core>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "stiction/simulation/push.hpp"
#include "stiction/simulation/simulation.hpp"
#include "stiction/world/call_mujoco.hpp"

// Inside of the layer: nothing that MuJoCo defines is seen by those who use simulation.hpp.

namespace stiction::simulation {

struct DeleteMujoco {
  void operator()(mjSpec* spec) const { mj_deleteSpec(spec); }
  void operator()(mjModel* model) const { mj_deleteModel(model); }
  void operator()(mjData* data) const { mj_deleteData(data); }
};

struct Plant::Impl {
  std::shared_ptr<const world::Model> model;
  PlantOptions options;
  std::unique_ptr<mjModel, DeleteMujoco> mujoco;
  Eigen::VectorXd damping, armature;

  std::vector<int> body_id;                                 ///< per body of the model: of MuJoCo
  std::vector<int> geometry_of;                             ///< per MuJoCo geom: of the model
  std::vector<int> pair_of;                                 ///< n_geometries × n_geometries, by (A, B): pair, −1 where there is none
  std::vector<int> actuator_id;                             ///< (n_a); each has one control, of the same number
  std::vector<int> q_address;                               ///< per object and robot joint, see copy_* below
  std::vector<int> v_address;                               ///< (n_v)
  std::vector<int> follower_q_address, follower_v_address;  ///< per Model::followers()

  /// One entry of MuJoCo's mass matrix in the inertia of a coordinate and of what follows it.
  struct InertiaTerm {
    int coordinate, entry;
    double weight;
  };
  std::vector<InertiaTerm> inertia_terms;
};

/// The scene as MuJoCo's model, springs without damping. @throws core::InvalidInput with what its compiler says
std::unique_ptr<mjModel, DeleteMujoco> compile_scene(const world::Model& model, const PlantOptions& options,
                                                     const Eigen::VectorXd& armature);

/// q in the layout of the model ↔ qpos. MuJoCo keeps the scalar of a quaternion first.
void copy_to_qpos(const Plant::Impl& plant, const VectorRef& q, mjtNum* qpos);
void copy_from_qpos(const Plant::Impl& plant, const mjtNum* qpos, Eigen::Ref<Eigen::VectorXd> q);

/// Diagonal of the mass matrix, armature and followers included (n_v) [kg or kg m²]. @param data  with the mass matrix of its posture
void calc_inertia(const Plant::Impl& plant, const mjData& data, Eigen::VectorXd& out);

/// D = 2 ζ √(K_a M_jj) of the joint springs (n_a). @param inertia  (n_v)                                                                     (M.1)
void calc_damping(const Plant::Impl& plant, const Eigen::VectorXd& inertia, Eigen::VectorXd& out);

/// At rest in q, with the mass matrix of that. Cylinders that stand on a plane are tilted by 1e-8 rad: MuJoCo looks for their lowest points along the difference of axis and normal, which
/// is rounding alone where quasi-static steps left them, and then has them too high by up to the radius, so that the cylinder falls through the plane.
void start_at(const Plant::Impl& plant, const VectorRef& q, mjData* data);

/// What MuJoCo said against a step, or numbers out of range; empty: nothing.
std::string find_fault(const Plant::Impl& plant, const mjData* data, const world::MujocoReport& report, double t);

/// @throws core::InvalidInput: no body, not finite
void require_pushes(const world::Model& model, std::span<const Push> pushes);

/// The sum of these forces takes the place of what was applied before. Bodies are where `data` was last evaluated.
void apply_pushes(const Plant::Impl& plant, std::span<const Push> pushes, mjData* data);

/// Contact forces of the state that was last evaluated, by pair.
void read_forces(const Plant::Impl& plant, const mjData* data, std::vector<PairForce>& out);

/// The torques of the motors in the state that was last evaluated take the place of those in `peak` (n_a) that are smaller [N m or N].
void raise_peaks(const Plant::Impl& plant, const mjData* data, Eigen::VectorXd& peak);

}  // namespace stiction::simulation
