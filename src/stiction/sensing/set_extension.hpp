#pragma once

#include <span>

#include "stiction/sensing/joint_descent.hpp"

namespace stiction::sensing {

/// Inside: scratch of SetExtension; one per thread.
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

/// Inside: what the samples of a link leave beside a set of contacts whose forces may have any value (Y.10a).
class SetExtension {
 public:
  SetExtension(const JointProblem& problem, ExtensionWorkspace& work) : problem_(problem), work_(work) {}

  /// The set beside which samples are sought until the next call.
  void hold(const ContactSet& set);

  /// The `most` samples of a link that leave least, the best first; valid until the next call.
  std::span<const int> find_samples(int link, int most);

  ContactPoint sample_point(int link, int sample) const;

 private:
  void fill_span(const ContactSet& set);
  void project(const Eigen::Matrix3Xd& M, Eigen::Matrix3Xd& out) const;

  const JointProblem& problem_;
  ExtensionWorkspace& work_;
  Eigen::Index rank_ = 0;
};

/// Links of the contacts, −1 where there is none.
std::array<int, kMostContacts> links_of(const ContactSet& set);

/// A strict order that no tie leaves to chance: by objective.
bool is_better(const ContactSet& a, const ContactSet& b);

/// By link, then by place, so that a set has one name.
void arrange(ContactSet& set);

/// Whether every contact of an arranged set lies within `radius` sample spacings of that of another one of as many.
bool is_near(const Sensor& sensor, const ContactSet& a, const ContactSet& b, double radius);

}  // namespace stiction::sensing
