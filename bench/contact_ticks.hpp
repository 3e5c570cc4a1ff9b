#pragma once

#include <memory>
#include <string>
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

/// What a general solver says of the ticks.
struct GeneralQp {
  std::string name;  ///< proxqp, highs
  std::vector<double> seconds;
  int unsolved = 0;  ///< among them those whose bounds contradict each other
};

/// The same program for general solvers: unknowns q_cmd − q_cmd⁻ and λ, (C.4) as equations, bounds on both. What gives way in ours is hard here. Residuals up to
/// 1e-6. ProxQP's dense solver and the active-set method of HiGHS, as far as the program was built beside them.
std::vector<GeneralQp> time_general_qps(const control::RobotLimits& robot, const std::vector<ContactTick>& ticks,
                                        const control::ContactQpOptions& options, int repeat);

}  // namespace stiction::bench
