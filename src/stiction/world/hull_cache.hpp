#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>

#include "stiction/world/shapes.hpp"

namespace stiction::world {

inline constexpr std::uintmax_t kHullCacheLimit = 64u << 20;  ///< of all files of hulls together [bytes]

/// Where hulls of mesh files are kept between runs: `hulls` in default_cache_dir(); empty for nowhere. Reads the environment.
std::filesystem::path hull_cache_dir();

/// The name that hulls are kept under: SHA-256 of the mesh file, of all that says how hulls are made of it, and of the code that makes them.
/// @param mesh  bytes of the file   @param how  options and versions of libraries, as text
std::string calc_hull_key(std::string_view mesh, std::string_view how);

/// The hulls that `folder` keeps under the key, else those that `make` makes, which are kept. Both are the same to the bit; sources and
/// surfaces are not kept. A folder that cannot be written and files that are damaged do no harm: `make` is called, and nothing is said.
/// Tests: tests/world/hull_cache_test.cpp
LoadedMesh find_or_make_hulls(const std::filesystem::path& folder, const std::string& key, const std::function<LoadedMesh()>& make);

/// Removes the files of hulls that were written first until the others take `limit` [bytes] at most.
void trim_hull_cache(const std::filesystem::path& folder, std::uintmax_t limit);

}  // namespace stiction::world
