#pragma once

#include <string>

#include "stiction/planning/planner.hpp"
#include "stiction/trajopt/optimize.hpp"
#include "stiction/world/yaml.hpp"

namespace stiction::tasks {

using planning::thesis::Scheme;
inline constexpr std::string_view kSchemeNames[] = {"exact", "analytic", "randomized-first", "randomized-zeroth"};
/// @throws core::InvalidInput with the known names
Scheme parse_scheme(std::string_view field, std::string_view name);

/// {std_u, std_q, samples} of a randomised scheme
void read_sampling(const world::YamlNode& node, const world::Model& model, dynamics::Sampling& out);
/// The same as one JSON object.
std::string sampling_json(const dynamics::Sampling& sampling);

/// sweep | receding
trajopt::InnerSolver parse_solver(std::string_view field, std::string_view name);

/// The `optimize` section of a task: horizon, options, and the settings of all four schemes. The options hold the chosen scheme.
struct OptimizeSetup {
  int horizon = 20;                  ///< T
  Scheme scheme = Scheme::Analytic;  ///< the scheme in options.scheme
  trajopt::OptimizeOptions options;
  dynamics::Analytic analytic;
  dynamics::RandomizedFirstOrder randomized_first;
  dynamics::RandomizedZerothOrder randomized_zeroth;
  bool use_A = true;  ///< value from the file; choose() turns A off for a zeroth-order scheme with std_q = 0, which cannot give A
  Eigen::VectorXd joints_reference;   ///< reference of qᵃ (n_a); empty: the joints of the start
  void choose(Scheme scheme);         ///< copies the settings of this scheme into options.scheme
  void set_seed(std::uint64_t seed);  ///< sets the seed of the randomised schemes
};

/// Reads the section:
///   horizon, iterations, tolerance, h, regularisation, scheme, use_A, input_bound, joints_reference, seed
///   solver: sweep | receding            forces: {max_distance, rays, friction}, the contact trust region
///   analytic: {kappa, growth, self_sharpness, limit_sharpness}
///   randomized_first, randomized_zeroth: {std_u, std_q, samples}      decay: of both
///   weights: {objects: {OBJECT: …}, objects_final: {…}, robots, robots_final, input}, each one number or one per coordinate
/// @throws core::InvalidInput with file, line and field
OptimizeSetup read_optimize_setup(const world::YamlNode& node, const world::Model& model);

/// Writes the section as one JSON object, with all values resolved.
std::string optimize_setup_json(const OptimizeSetup& setup);

}  // namespace stiction::tasks
