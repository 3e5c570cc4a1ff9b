#pragma once

#include <tinyxml2.h>

#include <string>

namespace stiction::world {

/// Names the attributes and elements of links and joints that the reader of URDF does not know, for example misspelt ones, and elements that a
/// link or joint states twice, of which the first counts. Visuals are not looked at.
/// @returns one note; empty if there is nothing to tell. Tests: tests/world/odd_urdf_test.cpp
std::string find_unread(const tinyxml2::XMLElement& robot);

}  // namespace stiction::world
