#pragma once

#include <memory>
#include <span>
#include <vector>

#include "stiction/sensing/set_extension.hpp"

namespace stiction::sensing {

struct ContactTrackerOptions {
  FrictionCone cone{1, 4};  ///< polyhedral
  int pool = 6;             ///< sets that are kept from call to call, ≥ 1
  int parents = 2;          ///< sets of one contact less to which a call seeks a further one, ≥ 1
  int descents = 2;         ///< from new sets in a call, ≥ 1
  double merge = 3;         ///< of sets all of whose contacts are nearer than this many sample spacings the best is kept, ≥ 0
  JointDescent descent{.max_steps = 8};
  void validate() const;  ///< @throws core::InvalidInput naming the field
};

/// What a call of ContactTracker is told; refers to its parts.
struct ContactTrackerInput {
  const ContactRows& rows;
  double prior;                         ///< ρ of (Y.9) [m²]
  double noise;                         ///< σ [N·m]
  double enough;                        ///< objective up to which rows count as explained [(N·m)²]
  std::span<const ContactSet> parents;  ///< sets of one contact less, the likeliest first
};

/// Sets of contacts that act together, followed through a loop whose calls may not take long. A call leads the sets of the last one down from where they were
/// (Y.10), and tries a few new ones: to some of the parents, in turn, the samples are added that leave least (Y.10a), one on each link, and the best of these are led
/// down. So the search of contact_sets.hpp is spread over many calls, and the work of one is bounded: pool + descents descents of at most `descent.max_steps` steps,
/// and a residual of each sample for each parent. Belongs to one thread.
/// Tests: tests/sensing/contact_tracker_test.cpp
class ContactTracker {
 public:
  /// @param count  contacts of each set, 2 to kMostContacts    @throws core::InvalidInput: count, options, a cone without rays
  ContactTracker(std::shared_ptr<const Sensor> sensor, int count, const ContactTrackerOptions& options);

  void update(const ContactTrackerInput& input);
  void reset();

  int count() const { return count_; }
  const std::vector<ContactSet>& sets() const { return sets_; }  ///< by objective, whether they explain the torques or not
  int descents() const { return descents_; }                     ///< of the last call

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
  std::size_t turn_ = 0;  ///< of the parents
  int descents_ = 0;
};

}  // namespace stiction::sensing
