#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "stiction/sensing/residual.hpp"
#include "stiction/sensing/surface.hpp"

namespace stiction::sensing {

struct SensorOptions {
  std::vector<std::string>
      links{};  ///< "robot/link", '*' matches any run of characters and skips links that no joint moves; empty: all links that a joint moves and whose geometry can be touched
  int samples = 500;  ///< number on each link, ≥ 1
  Sampling sampling = Sampling::Stratified;
  Normals normals = Normals::Flat;
  std::uint64_t seed = 0;  ///< seed of samples and postures
  SurfaceOptions surface{};
  void validate() const;  ///< @throws core::InvalidInput naming the field
};

/// A link on which contacts are sought.
struct SensedLink {
  Surface surface;
  std::vector<SurfacePoint> samples;
  SampleBatch batch;   ///< the samples with their normals
  double spacing = 0;  ///< square root of the area per sample [m]
  int joints = 0;      ///< number of coordinates that move it: below 3 forces are not unique, below 5 points are not
};

/// Surfaces and samples of the links of a robot. Immutable, shared by threads.
class Sensor {
 public:
  /// @throws core::InvalidInput: options; a pattern that matches no link; a link that no joint moves or that has no surface
  static std::shared_ptr<const Sensor> make(std::shared_ptr<const world::Model> model, const SensorOptions& options = {});

  const world::Model& model() const { return *model_; }
  const std::shared_ptr<const world::Model>& model_ptr() const { return model_; }
  const SensorOptions& options() const { return options_; }
  std::span<const SensedLink> links() const { return links_; }
  std::span<const std::string> notes() const {
    return notes_;
  }  ///< notes on links and faces left out, and on links with too few joints to make contacts unique

  /// Index into links() of a body. @throws core::InvalidInput with the known names
  int link_index(std::string_view body) const;
  const std::string& link_name(int link) const;

 private:
  Sensor() = default;
  std::shared_ptr<const world::Model> model_;
  SensorOptions options_;
  std::vector<SensedLink> links_;
  std::vector<std::string> notes_;
};

}  // namespace stiction::sensing
