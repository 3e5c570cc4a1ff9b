#pragma once

#include <memory>
#include <span>
#include <vector>

#include "stiction/sensing/set_extension.hpp"

namespace stiction::sensing {

struct ContactTrackerOptions {
  FrictionCone cone{1, 4};  ///< polyhedral
  int pool = 6;             ///< number of sets kept from call to call, ≥ 1
  int parents = 2;          ///< number of sets with one contact less that a call extends, ≥ 1
  int descents = 2;         ///< number of descents from new sets in a call, ≥ 1
  double merge = 3;         ///< sets whose contacts are all nearer than this many sample spacings are merged to the best one, ≥ 0
  JointDescent descent{.max_steps = 8};
  void validate() const;  ///< @throws core::InvalidInput naming the field
};

/// Inputs of ContactTracker::update(), held by reference.
struct ContactTrackerInput {
  const ContactRows& rows;
  double prior;                         ///< ρ of (Y.9) [m²]
  double noise;                         ///< σ [N·m]
  double enough;                        ///< largest objective at which rows count as explained [(N·m)²]
  std::span<const ContactSet> parents;  ///< sets of one contact less, the likeliest first
};

/// Tracks sets of simultaneous contacts in a control loop, where each call must be short. A call descends from the sets of the last call
/// (Y.10) and tries a few new sets: it extends some of the parents, in turn, by the sample with the least residual on each link (Y.10a),
/// and descends from the best of these. The search of contact_sets.hpp is thus spread over many calls, and the work of one call is bounded:
/// pool + descents descents of at most `descent.max_steps` steps, and one residual per sample and parent. Belongs to one thread.
/// Tests: tests/sensing/contact_tracker_test.cpp
class ContactTracker {
 public:
  /// @param count  contacts of each set, 2 to kMostContacts    @throws core::InvalidInput: count, options, a cone without rays
  ContactTracker(std::shared_ptr<const Sensor> sensor, int count, const ContactTrackerOptions& options);

  void update(const ContactTrackerInput& input);
  void reset();

  int count() const { return count_; }
  const std::vector<ContactSet>& sets() const { return sets_; }  ///< by objective, including sets that do not explain the torques
  int descents() const { return descents_; }                     ///< number of descents in the last call

 private:
  void grow(const JointProblem& problem, double enough, std::span<const ContactSet> parents);
  void descend_from(const JointProblem& problem, double enough, ContactSet set);
  void keep_best();

  std::shared_ptr<const Sensor> sensor_;
  int count_;
  ContactTrackerOptions options_;
  JointWorkspace joint_;
  ExtensionWorkspace extension_;
  std::vector<ContactSet> sets_, before_, grown_;
  std::size_t turn_ = 0;  ///< next parent to extend
  int descents_ = 0;
};

}  // namespace stiction::sensing
