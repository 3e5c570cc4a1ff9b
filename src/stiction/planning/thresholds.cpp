#include "stiction/planning/thresholds.hpp"

#include "stiction/world/model.hpp"

namespace stiction::planning {

SceneThresholds::SceneThresholds(const world::Model& model, int object) {
  namespace share = world::share;
  const world::Scale& scale = model.scales().object(object);
  const double robots = model.scales().robots().length;
  smoothing.kappa = model.scales().kappa(object);
  gamma = model.scales().gamma(object);
  substep.joint_travel = share::kTravel * scale.length;
  substep.slide = share::kSlide * scale.length;
  clearance = share::kClearance * scale.length;
  rest = {threshold::kRestMove * robots, threshold::kRestTurn};
  motionless = {threshold::kMotionless * robots, threshold::kMotionlessTurn};
  regrasp = {share::kClearance * scale.length, threshold::kRegraspAngle};
  release = {share::kRelease * scale.length, share::kReleaseAngle};
  preload = share::kPreload * scale.force;
  brace = share::kBrace * scale.force;
}

}  // namespace stiction::planning
