#include "stiction/world/ground.hpp"

namespace stiction::world {

int object_on_ground(const Model& model, int pair) {
  const Pair& sides = model.pairs()[static_cast<std::size_t>(pair)];
  const auto body = [&](int geometry) -> const Body& {
    return model.bodies()[static_cast<std::size_t>(model.geometries()[static_cast<std::size_t>(geometry)].body)];
  };
  const Body &a = body(sides.geometry_a), &b = body(sides.geometry_b);  // in a pair, an object comes before a fixed body
  const bool free = a.kind == BodyKind::Object && model.objects()[static_cast<std::size_t>(a.owner)].n_v == 6;
  return free && b.kind == BodyKind::Fixed ? a.owner : -1;
}

}  // namespace stiction::world
