#pragma once

#include "stiction/control/controller.hpp"

// Internal to the layer: tracks contacts from tick to tick and low-passes their forces. docs/theory/control.md (C.5).

namespace stiction::control {

/// A contact that is measured now or was measured a moment ago.
struct FilteredContact {
  ContactForce contact{};
  Eigen::Vector3d p_BC = Eigen::Vector3d::Zero();
  bool seen = false;
  bool counts = false;              ///< whether the contact is in the model
  double unseen_for = 0;            ///< [s]
  double demand = 0;                ///< force that tracking alone asked for when the contact was last seen [N]
  std::optional<double> at_rest{};  ///< force of joint springs at rest on this contact, after the low-pass [N]
  Eigen::Vector3d u = Eigen::Vector3d::Zero(), p_W = Eigen::Vector3d::Zero();  ///< direction and place when it was last seen
};

/// Low-passes contact forces. A new contact starts at its measured force, the force of an unseen contact decays, and if there are too many
/// contacts the strongest are kept.
class ContactFilter {
 public:
  /// @param options  options of the controller; they must outlive the filter
  explicit ContactFilter(const ControllerOptions& options) : options_(options) {
    known.reserve(static_cast<std::size_t>(options.max_contacts));
  }

  /// @returns the number of contacts above the threshold that did not fit into max_contacts
  int update(std::span<const ContactForce> contacts, const world::Kinematics& kinematics, double dt);

  std::vector<FilteredContact> known;  ///< the controller, which decides which contacts count, removes them

 private:
  void see(FilteredContact& k, const ContactForce& measured, const world::Kinematics& kinematics, double gain) const;
  std::vector<FilteredContact>::iterator make_room(const ContactForce& measured, int& left_out);

  const ControllerOptions& options_;
};

}  // namespace stiction::control
