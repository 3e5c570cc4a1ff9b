#pragma once

#include <optional>

#include "stiction/contact/contact_sampler.hpp"
#include "stiction/dynamics/local_model.hpp"

namespace stiction::planning::thesis {

/// Ways to compute the local model of a node (2.4.1).
enum class Scheme {
  Exact,             ///< no smoothing: the first ablation of 3.5
  Analytic,          ///< analytic smoothing, `smoothing`
  RandomizedFirst,   ///< random samples, `randomized`: averaged derivatives (2.22)
  RandomizedZeroth,  ///< random samples, `randomized`: least squares (2.23)
};

/// A metric of Nearest that is the same at all nodes, Σ wᵢ eᵢ² with e = q_subgoal ⊖ qᵘ of the node: the ablation Global of 3.5.
struct GlobalMetric {
  double position = 1;  ///< [1/m²] > 0
  double angle = 1;     ///< [1/rad²] > 0
};

/// Settings of the published runs. The defaults are those of the planar hand.
struct Settings {
  double grasp_probability = 0.3;  ///< probability that a node gets a contact sample instead of an extension
  double length = 0.3;             ///< ‖δu‖ of every extension [rad or m], > 0
  double gamma = 1e-4;             ///< γ of the metric (3.5), > 0
  Scheme scheme = Scheme::Analytic;
  dynamics::Analytic smoothing;
  dynamics::Sampling randomized;       ///< its seed is not used: every node has its own substream of the plan's seed
  std::optional<GlobalMetric> metric;  ///< nullopt: every node has its own metric (3.5)
  double h = 0.1;                      ///< time step [s], > 0
  dynamics::Regularisation regularisation = dynamics::ByRule{};
  contact::GenericSampler sampler;
  bool stop_at_goal = true;  ///< false: make all extensions, to measure time

  /// Scheme of one node. @param seed  of the tree  @param stream  random stream of the node's samples
  dynamics::LocalModelScheme local_model_scheme(std::uint64_t seed, std::uint64_t stream) const;
  /// @throws core::InvalidInput naming the field
  void validate(const world::Model& model) const;
};

}  // namespace stiction::planning::thesis
