#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace stiction::world {

/// What an SRDF file (of MoveIt) says about the links of a robot that may touch each other.
struct Srdf {
  using LinkPair = std::pair<std::string, std::string>;
  std::vector<LinkPair> disabled;                ///< <disable_collisions link1="…" link2="…"/>
  std::vector<LinkPair> enabled;                 ///< <enable_collisions link1="…" link2="…"/>
  std::vector<std::string> disabled_by_default;  ///< <disable_default_collisions link="…"/>: with all links, but for pairs that are enabled
  std::vector<std::string> notes;                ///< what the file says beside that and what is not done, a sentence each

  /// Pairs of `links` that never touch each other: a pair that is disabled, or of which one link is disabled by default and that is not
  /// enabled. Links that the robot has not are passed over.
  std::vector<LinkPair> pairs_apart(std::span<const std::string> links) const;
};

/// @throws core::InvalidInput "FILE:LINE: …": no XML, or no SRDF. A file without any element disables nothing, and says so in a note
/// Tests: tests/world/srdf_test.cpp
Srdf read_srdf(const std::filesystem::path& file);

}  // namespace stiction::world
