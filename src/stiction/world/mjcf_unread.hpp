#pragma once

#include <mujoco/mujoco.h>

#include <string>
#include <vector>

namespace stiction::world {

/// What a compiled MJCF says about motion and contacts and what is not read: the attribute, what has it, and what this changes; an entry each.
/// Attributes with their usual value are no entry. Elements that are passed over altogether are those of MjcfView::list_passed_over().
/// Tests: tests/world/mjcf_unread_test.cpp
std::vector<std::string> list_unread(const mjModel& model);

}  // namespace stiction::world
