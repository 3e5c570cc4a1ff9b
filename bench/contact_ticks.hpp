#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "stiction/control/contact_qp.hpp"
#include "stiction/world/model.hpp"

namespace stiction::bench {

/// One tick of an arm in contact, as its controller is asked for it.
struct ContactTick {
  Eigen::VectorXd q, q_cmd, q_ref, lambda, lambda_max;
  control::RowMatrix J_u;
  double damping = 0;

  control::ContactQpInput input() const { return {q, q_cmd, q_ref, J_u, lambda, lambda_max, damping}; }
};

/// Random postures in half of the joint limits, random points near the last four links with forces in random directions, at rest: the springs balance forces of
/// up to 1.2 λ_max. The reference lies 20 to 50 mm behind each contact, and somewhere else in the directions that move none.
/// @param model  one arm whose joints have stiffness
std::vector<ContactTick> make_contact_ticks(const world::Model& model, const control::RobotLimits& robot, int contacts, int count,
                                            std::uint64_t seed);

/// What ProxQP says of the ticks.
struct GeneralQp {
  std::vector<double> seconds;
  int unsolved = 0;  ///< among them those whose bounds contradict each other
};

/// The same program for a general solver, ProxQP's dense one, that keeps its workspace: unknowns q_cmd − q_cmd⁻ and λ, (C.4) as equations, bounds on both. What
/// gives way in ours is hard here. Residuals up to 1e-6.
/// @returns nothing where the program was built without ProxSuite
std::optional<GeneralQp> time_general_qp(const control::RobotLimits& robot, const std::vector<ContactTick>& ticks,
                                         const control::ContactQpOptions& options, int repeat);

}  // namespace stiction::bench
