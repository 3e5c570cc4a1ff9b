#include "stiction/dynamics/coulomb.hpp"

#include <cmath>

#include "stiction/world/scales.hpp"

namespace stiction::dynamics::detail {
namespace {

using core::Status;

/// Largest gap or penetration of a contact in a solution that counts as the fixed point of Coulomb's law.
constexpr double kClosed = 3e-3;  // share of L of the pair (world::Scales)

/// True if a contact in the program penetrates by more than kClosed L, or carries a force across a gap above kClosed L.
bool misses_contact(const world::Model& model, const StepOptions& options, const StepWorkspace::Impl& work) {
  const cone::Result& s = work.solution;
  Eigen::Index cone = 0;
  for (std::size_t i = 0; i < work.contacts.size(); ++i) {
    if (!work.included[i] || work.contacts[i].friction * options.friction_scale == 0) continue;
    const auto w = s.w_cone.col(cone);
    const int pair = work.contacts[i].pair;
    const double gap = w[0] - s.shift_cone[cone], closed = kClosed * model.scales().pair(pair).length;
    const bool active = is_active(model, options, pair, s.z_cone(0, cone), w[0] - std::hypot(w[1], w[2]));
    if (gap < -closed || (active && gap > closed)) return true;
    ++cone;
  }
  return false;
}

}  // namespace

bool is_coulomb(const StepOptions& options) {
  return options.friction_law == FrictionLaw::Coulomb && std::holds_alternative<Exact>(options.smoothing);
}

Status solve_by_law(const StepProgram& program, StepWorkspace::Impl& work, int& iterations) {
  if (is_coulomb(program.options)) {
    const Status status = solve_rounds(program, {.closed = true}, work, iterations);
    if (status == Status::Solved && !misses_contact(program.model, program.options, work)) return status;
  }
  return solve_rounds(program, {.closed = false}, work, iterations);
}

}  // namespace stiction::dynamics::detail
