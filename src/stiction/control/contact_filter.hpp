#pragma once

#include "stiction/control/controller.hpp"

// Internal to the layer: contacts from tick to tick, with their forces after the low-pass. docs/theory/control.md (C.5).

namespace stiction::control {

/// A contact that is there, or was a moment ago.
struct FilteredContact {
  ContactForce contact{};
  Eigen::Vector3d p_BC = Eigen::Vector3d::Zero();
  bool seen = false;
  bool counts = false;              ///< it is in the model
  double unseen_for = 0;            ///< [s]
  double demand = 0;                ///< when it was last seen [N]
  std::optional<double> at_rest{};  ///< what springs at rest would press it with, after the low-pass [N]
  Eigen::Vector3d u = Eigen::Vector3d::Zero(), p_W = Eigen::Vector3d::Zero();  ///< direction and place when it was last seen
};

/// New contacts start at what is measured, those that are not seen decay; of too many the strongest are known.
class ContactFilter {
 public:
  /// @param options  those of its controller, which outlive it
  explicit ContactFilter(const ControllerOptions& options) : options_(options) {
    known.reserve(static_cast<std::size_t>(options.max_contacts));
  }

  /// @returns how many contacts above the threshold there was no room for
  int update(std::span<const ContactForce> contacts, const world::Kinematics& kinematics, double dt);

  std::vector<FilteredContact> known;  ///< whoever decides what counts forgets them

 private:
  void see(FilteredContact& k, const ContactForce& measured, const world::Kinematics& kinematics, double gain) const;
  std::vector<FilteredContact>::iterator make_room(const ContactForce& measured, int& left_out);

  const ControllerOptions& options_;
};

}  // namespace stiction::control
