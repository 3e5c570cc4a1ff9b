#include "stiction/control/contact_filter.hpp"

#include <algorithm>

namespace stiction::control {

using Eigen::Vector3d;

int ContactFilter::update(std::span<const ContactForce> contacts, const world::Kinematics& kinematics, double dt) {
  const double gain = dt / (options_.force_time_constant + dt);
  int left_out = 0;
  for (FilteredContact& k : known) k.seen = false;
  for (const ContactForce& measured : contacts) {
    if (!(measured.force_W.norm() > 0)) continue;
    auto entry = std::find_if(known.begin(), known.end(), [&](const FilteredContact& k) { return k.contact.id == measured.id; });
    const bool is_new = entry == known.end() || entry->contact.body != measured.body;
    if (entry == known.end()) entry = make_room(measured, left_out);
    if (entry == known.end()) continue;
    see(*entry, measured, kinematics, is_new ? 1 : gain);
  }
  for (FilteredContact& k : known) {
    if (k.seen) continue;
    k.contact.force_W *= 1 - gain;
    if (k.at_rest) *k.at_rest *= 1 - gain;
    k.contact.p_WC = kinematics.X_WB[static_cast<std::size_t>(k.contact.body)] * k.p_BC;
    k.unseen_for += dt;
  }
  return left_out;
}

/// Low-passes the force, and the contact point as the mean of the measured points, weighted by their share of the force. The mean is needed
/// because an edge or face contact may rest on one corner in this tick and on another one in the next. (C.5)
void ContactFilter::see(FilteredContact& k, const ContactForce& measured, const world::Kinematics& kinematics, double gain) const {
  const world::Pose& X_WB = kinematics.X_WB[static_cast<std::size_t>(measured.body)];
  const Vector3d before = k.contact.force_W, p_BC = X_WB.inverse() * measured.p_WC;
  const double size = measured.force_W.norm(), share = gain * size / ((1 - gain) * before.norm() + gain * size);
  k.contact = measured;
  k.contact.force_W = before + gain * (measured.force_W - before);
  k.p_BC += share * (p_BC - k.p_BC);
  k.contact.p_WC = k.p_W = X_WB * k.p_BC;
  k.seen = true;
  k.unseen_for = 0;
  k.u = k.contact.force_W.normalized();
}

/// Finds a slot for a new contact. If all slots are taken, the weakest contact is replaced, provided it is weaker than the new one.
std::vector<FilteredContact>::iterator ContactFilter::make_room(const ContactForce& measured, int& left_out) {
  if (static_cast<int>(known.size()) < options_.max_contacts) return known.insert(known.end(), FilteredContact{.contact = measured});
  if (measured.force_W.norm() >= options_.force_threshold) ++left_out;
  const auto weakest = std::min_element(known.begin(), known.end(), [](const FilteredContact& a, const FilteredContact& b) {
    return a.contact.force_W.squaredNorm() < b.contact.force_W.squaredNorm();
  });
  if (weakest == known.end() || !(weakest->contact.force_W.norm() < measured.force_W.norm())) return known.end();
  *weakest = {.contact = measured};
  return weakest;
}

}  // namespace stiction::control
