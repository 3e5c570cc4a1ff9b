#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace stiction::world {

/// Contents of an SRDF file (of MoveIt): the pairs of links of a robot that may or may not touch each other.
struct Srdf {
  using LinkPair = std::pair<std::string, std::string>;
  std::vector<LinkPair> disabled;  ///< <disable_collisions link1="…" link2="…"/>
  std::vector<LinkPair> enabled;   ///< <enable_collisions link1="…" link2="…"/>
  std::vector<std::string>
      disabled_by_default;         ///< <disable_default_collisions link="…"/>: disabled with all links, except in enabled pairs
  std::vector<std::string> notes;  ///< other contents of the file that are not applied, one sentence each

  /// Pairs of `links` that never touch each other: disabled pairs, and pairs that are not enabled and of which one link is disabled by default.
  /// Links of the file that are not in `links` are ignored.
  std::vector<LinkPair> pairs_apart(std::span<const std::string> links) const;
};

/// Reads an SRDF file. A file without any element disables nothing and gives a note.
/// @throws core::InvalidInput "FILE:LINE: …": not XML, or not an SRDF
/// Tests: tests/world/srdf_test.cpp
Srdf read_srdf(const std::filesystem::path& file);

}  // namespace stiction::world
