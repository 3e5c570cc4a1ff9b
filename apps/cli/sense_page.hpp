#pragma once

#include <string>

#include "page_scene.hpp"
#include "stiction/sensing/scenario.hpp"

namespace stiction::app {

/// What the page of `stiction sense` is made of: surfaces with their samples, and of every moment residuals, candidates and sets of contacts.
class SensePage {
 public:
  explicit SensePage(const sensing::Scenario& scenario);

  /// @param i  index of the moment
  void add(std::size_t i, const Eigen::VectorXd& q, const Eigen::VectorXd& tau, const sensing::SenseResult& result,
           const sensing::ContactSetResult& sets);

  /// @param force  of the contact whose detectability is drawn [N]; not positive: that of the known contact, or of the first candidate
  std::string document(double force) const;

 private:
  nlohmann::ordered_json detectability(double force) const;
  nlohmann::ordered_json truths(std::size_t i, const Eigen::VectorXd& q) const;
  nlohmann::ordered_json contact_sets(const Eigen::VectorXd& q, const sensing::ContactSetResult& result) const;

  const sensing::Scenario& scenario_;
  PageScene scene_;
  nlohmann::ordered_json moments_;
  double first_force_ = 0;  ///< of a candidate that explains [N]
};

}  // namespace stiction::app
