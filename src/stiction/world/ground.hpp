#pragma once

#include "stiction/world/model.hpp"

namespace stiction::world {

/// The free object of a pair whose other side does not move, by its index; −1 if there is none.
int object_on_ground(const Model& model, int pair);

}  // namespace stiction::world
