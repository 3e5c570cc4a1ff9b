#pragma once

#include <span>

#include "stiction/sensing/joint_descent.hpp"

namespace stiction::sensing {

/// Internal: scratch of SetExtension; one per thread.
struct ExtensionWorkspace {
  explicit ExtensionWorkspace(const Sensor& sensor);
  Eigen::MatrixXd span;  ///< orthonormal columns
  Eigen::MatrixX3d map;
  Eigen::Matrix3Xd J_w, J_v;
  Eigen::VectorXd tau, residuals;
  Eigen::MatrixXd scratch;
  LinkTorque torque;
  std::vector<int> order;
};

/// Internal: finds samples that extend a set of contacts, by their residual when the forces of the set may have any value (Y.10a).
class SetExtension {
 public:
  SetExtension(const JointProblem& problem, ExtensionWorkspace& work) : problem_(problem), work_(work) {}

  /// Sets the contacts that find_samples() extends until the next call.
  void hold(const ContactSet& set);

  /// The `most` samples of a link with the least residual, the best first; valid until the next call.
  std::span<const int> find_samples(int link, int most);

  ContactPoint sample_point(int link, int sample) const;

 private:
  void fill_span(const ContactSet& set);
  void project(const Eigen::Matrix3Xd& M, Eigen::Matrix3Xd& out) const;

  const JointProblem& problem_;
  ExtensionWorkspace& work_;
  Eigen::Index rank_ = 0;
};

/// Links of the contacts; −1: no contact.
std::array<int, kMostContacts> links_of(const ContactSet& set);

/// Strict order by objective, with ties broken in a repeatable way.
bool is_better(const ContactSet& a, const ContactSet& b);

/// Sorts the contacts by link, then by place, so that equal sets have equal order.
void arrange(ContactSet& set);

/// Whether every contact of an arranged set lies within `radius` sample spacings of the same contact of another set of equal size.
bool is_near(const Sensor& sensor, const ContactSet& a, const ContactSet& b, double radius);

}  // namespace stiction::sensing
