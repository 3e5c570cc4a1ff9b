#include "stiction/sensing/sensor.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "stiction/core/invalid_input.hpp"
#include "stiction/world/read.hpp"
#include "stiction/world/yaml.hpp"

namespace stiction::sensing {
namespace {

bool has_geometry(const world::Model& model, int body) {
  return std::any_of(model.geometries().begin(), model.geometries().end(), [&](const auto& g) { return g.body == body; });
}

bool is_wildcard(const std::string& pattern) { return pattern.find('*') != std::string::npos; }

/// Robot links that match the patterns, in the order of the model. A pattern that also matches links that no joint moves skips them with a
/// note.
std::vector<int> find_links(const world::Model& model, const std::vector<std::string>& patterns, std::vector<std::string>& notes) {
  std::vector<int> out;
  std::vector<std::string> names;
  std::vector<bool> matched(patterns.size(), false);
  for (int body = 0; body < static_cast<int>(model.bodies().size()); ++body) {
    const auto& info = model.bodies()[static_cast<std::size_t>(body)];
    if (info.kind != world::BodyKind::Robot) continue;
    names.push_back(info.name);
    bool wanted = patterns.empty() && !info.dofs.empty() && has_geometry(model, body);
    bool skipped = false;
    for (std::size_t i = 0; i < patterns.size(); ++i) {
      if (!world::matches_pattern(patterns[i], info.name)) continue;
      matched[i] = true;
      if ((!info.dofs.empty() && has_geometry(model, body)) || !is_wildcard(patterns[i]))
        wanted = true;
      else
        skipped = true;
    }
    if (wanted) out.push_back(body);
    if (skipped && !wanted)
      notes.push_back(info.name + (info.dofs.empty() ? ": no joint moves it, so that no contact on it makes a torque"
                                                     : ": it has no geometry that could be touched"));
  }
  for (std::size_t i = 0; i < patterns.size(); ++i)
    if (!matched[i]) core::throw_invalid("links", "'" + patterns[i] + "'", "one of " + world::list_with_hint(patterns[i], names));
  if (out.empty()) core::throw_invalid("links", "none", "a robot with geometry on a link that a joint moves");
  return out;
}

}  // namespace

void SensorOptions::validate() const {
  if (samples < 1) core::throw_invalid("samples", fmt::format("{}", samples), "an integer ≥ 1");
  surface.validate();
}

std::shared_ptr<const Sensor> Sensor::make(std::shared_ptr<const world::Model> model, const SensorOptions& options) {
  options.validate();
  auto out = std::shared_ptr<Sensor>(new Sensor());
  out->options_ = options;
  const std::vector<int> bodies = find_links(*model, options.links, out->notes_);
  for (const int body : bodies) {
    const auto& info = model->bodies()[static_cast<std::size_t>(body)];
    if (info.dofs.empty()) core::throw_invalid("links", "'" + info.name + "', which no joint moves", "links that a joint moves");
  }
  SurfaceOptions surface_options = options.surface;
  surface_options.seed = options.seed;
  const bool are_named =
      std::any_of(options.links.begin(), options.links.end(), [](const std::string& link) { return !is_wildcard(link); });
  Surfaces surfaces = make_surfaces(*model, bodies, surface_options, are_named ? HiddenLinks::Refuse : HiddenLinks::LeaveOut);
  out->notes_.insert(out->notes_.end(), surfaces.notes.begin(), surfaces.notes.end());
  for (Surface& surface : surfaces.links) {
    SensedLink link;
    const auto& info = model->bodies()[static_cast<std::size_t>(surface.body)];
    link.samples = sample_surface(surface, options.samples, options.sampling, options.seed);
    link.batch.resize(options.samples);
    for (int i = 0; i < options.samples; ++i) {
      const SurfacePoint& sample = link.samples[static_cast<std::size_t>(i)];
      link.batch.set(i, sample.p_L, make_contact_frame(surface.normal(sample.triangle, sample.p_L, options.normals)));
    }
    link.spacing = std::sqrt(surface.area / options.samples);
    link.joints = static_cast<int>(info.dofs.size());
    if (link.joints < 5) {
      out->notes_.push_back(
          fmt::format("{}: {} joint{} before it, so that {}", info.name, link.joints, link.joints == 1 ? "" : "s",
                      link.joints < 3 ? "neither point nor force of a contact are unique" : "points of contact lie on curves or patches"));
    }
    link.surface = std::move(surface);
    out->links_.push_back(std::move(link));
  }
  out->model_ = std::move(model);
  return out;
}

int Sensor::link_index(std::string_view body) const {
  std::vector<std::string> names;
  for (int i = 0; i < static_cast<int>(links_.size()); ++i) {
    names.push_back(link_name(i));
    if (names.back() == body) return i;
  }
  core::throw_invalid("link", fmt::format("'{}'", body), "one of " + world::list_with_hint(body, names));
}

const std::string& Sensor::link_name(int link) const {
  return model_->bodies()[static_cast<std::size_t>(links_[static_cast<std::size_t>(link)].surface.body)].name;
}

}  // namespace stiction::sensing
