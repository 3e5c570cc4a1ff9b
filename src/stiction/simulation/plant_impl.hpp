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

// Internal to the layer: simulation.hpp exposes no MuJoCo types.

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

  std::vector<int> body_id;                                 ///< MuJoCo's number of each body of the model
  std::vector<int> geometry_of;                             ///< the model's geometry of each MuJoCo geom
  std::vector<int> pair_of;                                 ///< n_geometries × n_geometries, pair index by (A, B); −1: no pair
  std::vector<int> actuator_id;                             ///< (n_a); each actuator has one control with the same number
  std::vector<int> q_address;                               ///< per object and robot joint, see copy_* below
  std::vector<int> v_address;                               ///< (n_v)
  std::vector<int> follower_q_address, follower_v_address;  ///< per Model::followers()

  /// One entry of MuJoCo's mass matrix that adds to the inertia of a coordinate and of its follower joints.
  struct InertiaTerm {
    int coordinate, entry;
    double weight;
  };
  std::vector<InertiaTerm> inertia_terms;
};

/// Compiles the scene to MuJoCo's model, with undamped springs. @throws core::InvalidInput with the message of MuJoCo's compiler
std::unique_ptr<mjModel, DeleteMujoco> compile_scene(const world::Model& model, const PlantOptions& options,
                                                     const Eigen::VectorXd& armature);

/// Convert q in the layout of the model to qpos and back. MuJoCo keeps the scalar of a quaternion first.
void copy_to_qpos(const Plant::Impl& plant, const VectorRef& q, mjtNum* qpos);
void copy_from_qpos(const Plant::Impl& plant, const mjtNum* qpos, Eigen::Ref<Eigen::VectorXd> q);

/// Computes the diagonal of the mass matrix, armature and followers included (n_v) [kg or kg m²]. @param data  has the mass matrix of its
/// posture
void calc_inertia(const Plant::Impl& plant, const mjData& data, Eigen::VectorXd& out);

/// Computes the damping D = 2 ζ √(K_a M_jj) of the joint springs (n_a), or k_v of their servos in the file if it is larger. (M.1)
/// @param inertia  (n_v)
void calc_damping(const Plant::Impl& plant, const Eigen::VectorXd& inertia, Eigen::VectorXd& out);

/// Starts `data` at rest in q and computes its mass matrix. Cylinders that stand on a plane are tilted by 1e-8 rad: MuJoCo seeks their
/// lowest points along the difference of axis and normal. For a cylinder left upright by quasi-static steps this difference is mere
/// rounding; MuJoCo then places the lowest points too high by up to the radius, and the cylinder falls through the plane.
void start_at(const Plant::Impl& plant, const VectorRef& q, mjData* data);

/// The warning of MuJoCo about a step, or a message on numbers out of range; empty: no fault.
std::string find_fault(const Plant::Impl& plant, const mjData* data, const world::MujocoReport& report, double t);

/// Checks pushes. @throws core::InvalidInput: no body, not finite
void require_pushes(const world::Model& model, std::span<const Push> pushes);

/// Replaces the applied forces by the sum of these pushes, with the body poses of the last evaluation of `data`.
void apply_pushes(const Plant::Impl& plant, std::span<const Push> pushes, mjData* data);

/// Reads the contact forces of the last evaluated state, by pair.
void read_forces(const Plant::Impl& plant, const mjData* data, std::vector<PairForce>& out);

/// Raises `peak` (n_a) to the motor torques of the last evaluated state where these are larger [N m or N].
void raise_peaks(const Plant::Impl& plant, const mjData* data, Eigen::VectorXd& peak);

}  // namespace stiction::simulation
