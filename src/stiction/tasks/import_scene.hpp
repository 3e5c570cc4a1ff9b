#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace stiction::tasks {

/// Makes the text of a task from one MJCF or URDF file. The actuators of the file tell robots, objects and fixed bodies apart. The text
/// lists these bodies, the start (a keyframe, if there is one) and a goal for the user to edit: for a free object a fixed site or body
/// named goal or target, otherwise a motion by 0.1 m, 0.5 rad, or 0.9 of the way to the farther joint limit.
/// @param folder  folder of the text; the path of the file is relative to it
/// @param object  object that the goal moves; empty: the first object
/// @throws core::InvalidInput: a file that MuJoCo rejects, a file without a robot or without an object, no object of that name
/// Tests: tests/tasks/import_scene_test.cpp
std::string import_scene(const std::filesystem::path& file, const std::filesystem::path& folder, const std::string& object = {});

/// Names of the keyframes of such a file, for `start: {keyframe: …}` in its tasks. @throws core::InvalidInput: a file that MuJoCo rejects
std::vector<std::string> list_keyframes(const std::filesystem::path& file);

}  // namespace stiction::tasks
