#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace stiction::world {

/// Pairs of links that an SRDF file (of MoveIt) keeps from touching: the elements <disable_collisions link1="…" link2="…"/>.
/// @throws core::InvalidInput "FILE:LINE: …"
std::vector<std::pair<std::string, std::string>> read_srdf(const std::filesystem::path& file);

}  // namespace stiction::world
