#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace stiction::tasks {

/// A task, as text, that is in one MJCF or URDF file: which bodies are robots, objects and fixed follows from its actuators, and the text says what
/// was found, where things start (a keyframe, if there is one) and a goal to be edited: a site or body that stands still and is called goal
/// or target for an object that is free, else a motion of an object of about a tenth of a metre or of its range.
/// @param folder  where the text will stand: the file is named relative to it
/// @param object  that the goal moves; empty: the first one
/// @throws core::InvalidInput: what MuJoCo refuses, a file without a robot or without an object, no object of that name
/// Tests: tests/tasks/import_scene_test.cpp
std::string import_scene(const std::filesystem::path& file, const std::filesystem::path& folder, const std::string& object = {});

/// Names of the keyframes of such a file, for `start: {keyframe: …}` of its tasks. @throws core::InvalidInput: what MuJoCo refuses
std::vector<std::string> list_keyframes(const std::filesystem::path& file);

}  // namespace stiction::tasks
