#pragma once

#include "world/test_scenes.hpp"

namespace stiction::world::test {

/// The ball in the open palm of the Allegro hand, fingers around it.
inline Eigen::VectorXd allegro_start() {
  Eigen::VectorXd q(23);
  q << -0.081, 0.001, 0.071, 0, 0, 0, 1, 0.03501504, 0.75276565, 0.74146232, 0.83261002, -0.1438725, 0.74696812, 0.61908827, 0.70064279,
      -0.06922541, 0.78533142, 0.82942863, 0.90415436, 0.63256269, 1.02378254, 0.64089555, 0.82444782;
  return q;
}

}  // namespace stiction::world::test
