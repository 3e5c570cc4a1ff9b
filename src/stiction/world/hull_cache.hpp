#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>

#include "stiction/world/shapes.hpp"

namespace stiction::world {

inline constexpr std::uintmax_t kHullCacheLimit = 64u << 20;  ///< largest total size of all hull files [bytes]

/// Folder in which hulls of mesh files are kept between runs: `hulls` in default_cache_dir(); empty for no cache. Reads the environment.
std::filesystem::path hull_cache_dir();

/// Computes the key of cached hulls: SHA-256 of the mesh file, of the settings for making hulls, and of the code that makes them.
/// @param mesh  bytes of the file   @param how  options and versions of libraries, as text
std::string calc_hull_key(std::string_view mesh, std::string_view how);

/// Returns the hulls cached in `folder` under the key; else calls `make` and caches its hulls. Both ways give the same bits. The cache does
/// not hold sources and surfaces. If the folder cannot be written or a file is damaged, `make` is called, without a message.
/// Tests: tests/world/hull_cache_test.cpp
LoadedMesh find_or_make_hulls(const std::filesystem::path& folder, const std::string& key, const std::function<LoadedMesh()>& make);

/// Removes the oldest hull files until the others take at most `limit` [bytes].
void trim_hull_cache(const std::filesystem::path& folder, std::uintmax_t limit);

}  // namespace stiction::world
