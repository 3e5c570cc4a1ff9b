#pragma once

#include <optional>
#include <vector>

#include "stiction/sensing/sense.hpp"

namespace stiction::bench {

/// Times of RSGD as published: each residual a quadratic program of n_d variables, here by ProxQP, warm from the last one. Gradients are by the envelope theorem, which
/// is cheaper than the derivatives of the program that were published.
struct PublishedCycle {
  std::vector<double> residuals;  ///< of one residual, a mean over all samples [s]
  std::vector<double> cycles;     ///< of all samples and the descents from those accepted [s]
  int accepted = 0, unsolved = 0;
};

/// nullopt where ProxQP is not installed. @param accept  δ [(N·m)²]
std::optional<PublishedCycle> time_published_cycle(const sensing::Sensor& sensor, const Eigen::VectorXd& q, const Eigen::VectorXd& tau,
                                                   const sensing::FrictionCone& cone, double accept, int repeat);

}  // namespace stiction::bench
