#include "stiction/dynamics/nearby.hpp"

#include <algorithm>

#include "stiction/world/scales.hpp"

namespace stiction::dynamics::detail {
namespace {

using world::Model;

/// True if a pair touches or overlaps and its gap depends on no coordinate: the first row of its Jacobian is rounding error. No force can
/// act across such a contact, and an overlap that no motion can undo must not make a step infeasible.
bool has_fixed_gap(const Model& model, const StepWorkspace::Impl& work, std::size_t i) {
  constexpr double kRounding = 1e-12;
  if (work.contacts[i].phi > model.scales().contact_tolerance(work.contacts[i].pair)) return false;
  const auto support = at(model.pairs()[at(work.contacts[i].pair)].support);
  const Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, 3>> J(jacobian(work, i),
                                                                     static_cast<Eigen::Index>(model.supports()[support].size()), 3);
  return J.col(0).lpNorm<Eigen::Infinity>() <= kRounding * J.lpNorm<Eigen::Infinity>();
}

void query(const Model& model, double margin, StepWorkspace::Impl& work) {
  contact::query(model, work.kinematics, {.margin = margin, .near = work.near}, work.contact_work, work.contacts);
  contact::split_turning(model, work.contacts);
  contact::calc_jacobians(model, work.kinematics, work.contacts, work.contact_work, work.J);
  std::size_t kept = 0;
  for (std::size_t i = 0; i < work.contacts.size(); ++i) {
    if (has_fixed_gap(model, work, i)) continue;
    if (kept != i) work.contacts[kept] = work.contacts[i];
    ++kept;
  }
  if (kept == work.contacts.size()) return;
  work.contacts.resize(kept);
  contact::calc_jacobians(model, work.kinematics, work.contacts, work.contact_work, work.J);
}

}  // namespace

void calc_kinematics(const Model& model, VectorRef q, StepWorkspace::Impl& work) {
  if (work.q_seen.size() != 0 && work.q_seen == q) return;
  world::calc_kinematics(model, q, work.kinematics_work, work.kinematics);
  work.q_seen = q;
  work.margin_seen = -1;
}

void find_contacts(const Model& model, const StepInput& in, double margin, double fall, bool within_reach, StepWorkspace::Impl& work) {
  if (work.margin_seen != margin || work.fall_seen != fall) {
    work.near.resize(model.pairs().size());
    for (std::size_t i = 0; i < work.near.size(); ++i) {
      const double seen = model.pairs()[i].max_distance + margin;
      work.near[i] = within_reach ? std::min(seen, work.reach.near[i]) : seen;
    }
    query(model, margin + std::max(0.0, fall - model.scene().contact_distance), work);
    work.margin_seen = margin;
    work.fall_seen = fall;
    work.near_contacts = work.contacts.size();
  }
  if (in.friction)
    for (auto& contact : work.contacts) contact.friction *= (*in.friction)[contact.pair];
  if (in.friction || within_reach) work.margin_seen = -1;  // no other step may reuse these contacts
}

}  // namespace stiction::dynamics::detail
