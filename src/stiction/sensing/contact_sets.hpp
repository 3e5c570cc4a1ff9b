#pragma once

#include "stiction/sensing/joint_descent.hpp"
#include "stiction/sensing/sense.hpp"

namespace stiction::sensing {

struct ContactSetOptions {
  SenseOptions sense;    ///< used: cone (polyhedral), noise, threshold, tolerance and thin
  int max_contacts = 2;  ///< 1 to 3
  int starts = 24;       ///< starting points of the first contact on each link, ≥ 1
  int descents = 6;      ///< joint descents for each combination of links, ≥ 1
  JointDescent descent{};
  void validate() const;  ///< @throws core::InvalidInput naming the field
};

/// Sets of contacts on the same links that explain the torques equally well.
struct ContactGroup {
  int first = 0, count = 0;                    ///< range of its sets in ContactSetResult::sets, the best one first
  std::array<double, kMostContacts> extent{};  ///< largest distance of each contact from the same contact of the best set [m]
};

struct ContactSetInput {
  VectorRef q;                       ///< (n_q)
  VectorRef tau;                     ///< (n_a) external torques [N·m; N]
  const BaseWrench* base = nullptr;  ///< wrench of a force and moment sensor under the base; nullptr: no sensor
  /// Sets of the last cycle. If fewer contacts do not explain the torques but a descent from one of these sets does, no other set is
  /// sought.
  const std::vector<ContactSet>* last = nullptr;
};

struct ContactSetResult {
  Verdict verdict = Verdict::BelowThreshold;
  /// More than one group explains the torques, or the best set is not isolated: its points and forces can change together without a change
  /// of the measurements.
  bool ambiguous = false;
  int contacts = 0;  ///< contacts of each set: the fewest that explain the torques; if none do, the fewest with the least residual
  std::vector<ContactSet> sets;      ///< sets that explain the torques, by group; if none do, the best one
  std::vector<ContactGroup> groups;  ///< ordered by the objective of the best set
  double explained = 0;              ///< largest objective (Y.9) at which torques count as explained [(N·m)²]
  int descents = 0;
};

/// Scratch of sense_contacts(); one per thread.
class ContactSetWorkspace {
 public:
  explicit ContactSetWorkspace(std::shared_ptr<const Sensor> sensor);
  ~ContactSetWorkspace();
  ContactSetWorkspace(ContactSetWorkspace&&) noexcept;
  struct Impl;
  Impl& impl() { return *impl_; }

 private:
  std::unique_ptr<Impl> impl_;
};

/// Finds the smallest sets of one to three simultaneous contacts that explain the torques. The search is greedy: to every set of the last
/// round, and to many single points, it adds the points with the least residual when the earlier forces may have any value (Y.10a). The
/// best sets of each combination of links are then refined together (Y.10). k contacts have 5 k unknowns. Fewer measurements (n_a torques,
/// and six more with a base wrench) cannot fix them; each set states its `freedom`. No heap use once workspace and result have held as many
/// sets.
/// @throws core::InvalidInput: q, tau or base of the wrong size or not finite, options, a cone without rays
/// Tests: tests/sensing/contact_sets_test.cpp
void sense_contacts(const Sensor& sensor, const ContactSetInput& input, const ContactSetOptions& options, ContactSetWorkspace& work,
                    ContactSetResult& out);

}  // namespace stiction::sensing
