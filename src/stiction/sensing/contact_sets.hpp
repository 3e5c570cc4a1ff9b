#pragma once

#include "stiction/sensing/joint_descent.hpp"
#include "stiction/sensing/sense.hpp"

namespace stiction::sensing {

struct ContactSetOptions {
  SenseOptions sense;    ///< cone (polyhedral), noise, threshold, tolerance and thin count here
  int max_contacts = 2;  ///< 1 to 3
  int starts = 24;       ///< first contacts that are tried on each link, ≥ 1
  int descents = 6;      ///< joint descents for each combination of links, ≥ 1
  JointDescent descent{};
  void validate() const;  ///< @throws core::InvalidInput naming the field
};

/// Sets of contacts on the same links that explain the torques alike.
struct ContactGroup {
  int first = 0, count = 0;                    ///< its sets in ContactSetResult::sets, the best one first
  std::array<double, kMostContacts> extent{};  ///< largest distance of each contact from that of the best set [m]
};

struct ContactSetInput {
  VectorRef q;                       ///< (n_q)
  VectorRef tau;                     ///< (n_a) external torques [N·m; N]
  const BaseWrench* base = nullptr;  ///< what a force and moment sensor under the base measures, if there is one
  /// Sets of the last cycle. Where fewer contacts do not explain and one of these, led down from where it was, does, no other is looked for.
  const std::vector<ContactSet>* last = nullptr;
};

struct ContactSetResult {
  Verdict verdict = Verdict::BelowThreshold;
  /// More than one group explains the torques, or the best set is not isolated: points or forces can change together without a trace in what is measured.
  bool ambiguous = false;
  int contacts = 0;                  ///< of each set: the fewest that explain the torques; where none do the fewest that leave least
  std::vector<ContactSet> sets;      ///< that explain, by group; where none do the best one
  std::vector<ContactGroup> groups;  ///< by objective of the best set
  double explained = 0;              ///< objective (Y.9) up to which torques count as explained [(N·m)²]
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

/// One to three contacts at the same time that make the torques, with as few as will do. Greedily: to every set of the last round, and to many single points,
/// the points are added that leave least when the forces before may have any value; the best for each combination of links are then refined together (Y.10).
/// n_a torques, and six numbers more with a wrench at the base, cannot fix the 5 k unknowns of k contacts if they are fewer: each set says its `freedom`.
/// No heap use once workspace and result have met as many sets.
/// @throws core::InvalidInput: q, tau or base of the wrong size or not finite, options, a cone without rays
/// Tests: tests/sensing/contact_sets_test.cpp
void sense_contacts(const Sensor& sensor, const ContactSetInput& input, const ContactSetOptions& options, ContactSetWorkspace& work,
                    ContactSetResult& out);

}  // namespace stiction::sensing
