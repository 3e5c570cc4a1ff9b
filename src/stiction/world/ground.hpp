#pragma once

#include "stiction/world/model.hpp"

namespace stiction::world {

/// Index of the free object in a pair whose other side is fixed; −1 for any other pair.
int object_on_ground(const Model& model, int pair);

}  // namespace stiction::world
