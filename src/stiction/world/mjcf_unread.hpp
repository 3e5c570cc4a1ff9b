#pragma once

#include <mujoco/mujoco.h>

#include <functional>
#include <string>
#include <vector>

namespace stiction::world {

/// Lists attributes of a compiled MJCF that affect motion or contacts but are not read. Each entry names the attribute, the elements that have
/// it, and the effect of ignoring it. Attributes at their default value have no entry. MjcfView::list_passed_over() lists whole elements that
/// are ignored.
/// @param is_robot  whether a joint belongs to a robot
/// Tests: tests/world/mjcf_unread_test.cpp
std::vector<std::string> list_unread(const mjModel& model, const std::function<bool(int joint)>& is_robot);

}  // namespace stiction::world
