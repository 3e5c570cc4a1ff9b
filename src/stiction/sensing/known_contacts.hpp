#pragma once

#include <span>
#include <vector>

#include "stiction/sensing/contact_sets.hpp"

namespace stiction::sensing {

// Known contacts: only link, p_L and f_L are used.

/// A configuration with the torques of a known contact.
struct KnownCase {
  Eigen::VectorXd q, tau;
  ContactPoint contact;
};

/// The same for several contacts, with the wrench at the base.
struct KnownCases {
  Eigen::VectorXd q, tau;
  std::vector<ContactPoint> contacts;  ///< by link
  BaseWrench base;
};

/// Computes the torques (n_a) and the base wrench of known contacts at q.
void calc_known_rows(const Sensor& sensor, VectorRef q, std::span<const ContactPoint> contacts, Eigen::VectorXd& tau, BaseWrench& base);

/// Makes a random case: a force of `force` [N] with a direction uniform in the cone, at a point uniform by area on one of the links
/// (indices into Sensor::links()), at joint positions uniform in 90 % of their limits (or of a full turn without limits).
KnownCase make_random_case(const Sensor& sensor, std::span<const int> links, const FrictionCone& cone, double force, core::Random& random);

/// Makes `count` such forces on different links. @throws core::InvalidInput: fewer links
KnownCases make_random_cases(const Sensor& sensor, std::span<const int> links, const FrictionCone& cone, double force, int count,
                             core::Random& random);

/// A set of known contacts with their forces.
ContactSet make_set(const Sensor& sensor, std::span<const ContactPoint> contacts);

/// Freedom (Y.11) at known contacts; 0: the measurements isolate them. @param base  whether the wrench at the base is measured
int calc_freedom(const Sensor& sensor, const KnownCases& known, bool base, double noise);

/// Configuration (n_q) with the joints of the robots at the given positions and objects at their placed frames.
Eigen::VectorXd place_robots(const world::Model& model, VectorRef joints);

/// Distance of a known contact from the nearest point of a candidate that explains the torques as well [m]; infinite on another link.
double calc_distance(const SenseResult& result, const Candidate& candidate, const ContactPoint& contact);

/// Largest distance between the contacts of a set and as many known ones, for the best assignment [m]; infinite if links differ.
double calc_distance(const ContactSet& set, std::span<const ContactPoint> contacts);

}  // namespace stiction::sensing
