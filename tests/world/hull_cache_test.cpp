// Hulls of mesh files that are kept between runs: the same bits as those that are computed, whatever happened to the folder.
#include "stiction/world/hull_cache.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cstring>
#include <thread>

#include "stiction/world/cache_file.hpp"
#include "stiction/world/simplify_hull.hpp"
#include "world/mesh_files.hpp"

namespace stiction::world {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;
using stiction::test::EnvironmentVariable;

const MeshOptions kOfALink{NonConvex::TakeHulls, {}, kHullTolerance};

template <class M>
bool same_bits(const M& a, const M& b) {
  return a.cols() == b.cols() && std::memcmp(a.data(), b.data(), static_cast<std::size_t>(a.size()) * sizeof(*a.data())) == 0;
}

bool same(const LoadedMesh& a, const LoadedMesh& b) {
  return a.filled == b.filled && std::memcmp(&a.error, &b.error, sizeof a.error) == 0 &&
         std::equal(a.parts.begin(), a.parts.end(), b.parts.begin(), b.parts.end(), [](const ConvexMesh& x, const ConvexMesh& y) {
           return same_bits(x.vertices, y.vertices) && same_bits(x.triangles, y.triangles) && x.source == y.source &&
                  same_bits(*x.surface, *y.surface);
         });
}

std::vector<fs::path> files_in(const fs::path& folder) {
  std::vector<fs::path> out;
  if (fs::exists(folder))
    for (const auto& entry : fs::directory_iterator(folder)) out.push_back(entry.path());
  return out;
}

class HullCache : public test::MeshFiles {
 protected:
  const EnvironmentVariable cache_{"STICTION_CACHE", (dir_ / "kept").c_str()};
  const fs::path hulls_ = dir_ / "kept/hulls";

  LoadedMesh load(const fs::path& file) const { return load_mesh(file, Vector3d(1, 0.5, 0.1), kOfALink); }
  LoadedMesh load_without(const fs::path& file) const {
    cache_.set("");
    LoadedMesh out = load(file);
    cache_.set((dir_ / "kept").c_str());
    return out;
  }
};

TEST_F(HullCache, KeptHulls_AreThoseThatAreComputed) {
  test::ObjMesh blocks = test::make_block({0, 0, 0}, {1, 1, 1});
  blocks.append(test::make_block({2, 0, 0}, {3, 1, 1}));
  for (const auto& [name, mesh] : {std::pair{"ring.obj", test::make_ring(40, 30)}, {"blocks.obj", blocks}}) {
    const auto file = write(name, mesh.text());
    const LoadedMesh computed = load_without(file);
    fs::remove_all(hulls_);
    EXPECT_TRUE(same(load(file), computed)) << name;
    const auto kept = files_in(hulls_);
    ASSERT_EQ(kept.size(), 1u) << "and nothing under a temporary name";
    const auto long_ago = fs::file_time_type::clock::now() - std::chrono::hours(1000);
    fs::last_write_time(kept[0], long_ago);
    EXPECT_TRUE(same(load(file), computed)) << name;
    EXPECT_EQ(fs::last_write_time(kept[0]), long_ago) << "it was read, and not made again";
  }
  EXPECT_TRUE(load(dir_ / "ring.obj").filled);
  EXPECT_GT(load(dir_ / "ring.obj").error, 0);
  EXPECT_EQ(load(dir_ / "blocks.obj").parts.size(), 2u);
}

TEST_F(HullCache, KeptHulls_AreMadeOnce) {
  int calls = 0;
  const auto file = write("ring.obj", test::make_ring(20, 10).text());
  const LoadedMesh ring = load_without(file);
  const auto find = [&](const std::string& key) {
    find_or_make_hulls(hulls_, key, [&] { return ++calls, ring; });
    return calls;
  };
  EXPECT_EQ(find(calc_hull_key("mesh", "how")), 1);
  EXPECT_EQ(find(calc_hull_key("mesh", "how")), 1);
  EXPECT_EQ(find(calc_hull_key("mesh", "otherwise")), 2);
  EXPECT_EQ(find(calc_hull_key("other mesh", "how")), 3);
}

TEST_F(HullCache, WhateverHullsDependOn_GivesAFileOfItsOwn) {
  const std::string text = test::make_ring(20, 10).text();
  const auto file = write("a.obj", text);
  std::size_t expected = 0;
  const auto count = [&](const fs::path& mesh, const Vector3d& scale, const MeshOptions& options) {
    load_mesh(mesh, scale, options);
    return files_in(hulls_).size();
  };
  EXPECT_EQ(count(file, Vector3d::Ones(), kOfALink), ++expected);
  EXPECT_EQ(count(file, Vector3d(1, 1, -1), kOfALink), ++expected) << "scale";
  EXPECT_EQ(count(file, Vector3d::Ones(), {NonConvex::TakeHull, {}, kHullTolerance}), ++expected) << "choice of hulls";
  EXPECT_EQ(count(file, Vector3d::Ones(), {NonConvex::TakeHulls, {}, 0}), ++expected) << "tolerance";
  EXPECT_EQ(count(write("b.obj", text), Vector3d::Ones(), kOfALink), expected) << "the same mesh under another name";
  EXPECT_EQ(count(write("a.obj", "v 9 9 9\n" + text), Vector3d::Ones(), kOfALink), ++expected) << "an edited mesh under the same name";
}

TEST_F(HullCache, DamagedAndForeignFiles_AreReplaced) {
  const auto file = write("ring.obj", test::make_ring(20, 10).text());
  const LoadedMesh computed = load(file);
  const fs::path kept = files_in(hulls_).at(0);
  const std::string good = read(kept);
  std::string contents = good, title = good, checksum = good, key = good;
  contents[good.size() - 3] ^= 1;
  title[10] ^= 1;
  key[good.find('\n') + 1] ^= 1;
  checksum[good.find('\n') + 70] ^= 1;
  for (const std::string& bad : {std::string(), std::string("rubbish"), std::string(100'000, 'x'), good.substr(0, 30), good.substr(0, 200),
                                 good.substr(0, good.size() - 8), good + "x", contents, title, key, checksum,
                                 seal("stiction hulls 1\n", kept.stem().string(), "sealed, but no hulls")}) {
    std::ofstream(kept, std::ios::binary) << bad;
    EXPECT_TRUE(same(load(file), computed));
    EXPECT_EQ(read(kept), good);
  }
  fs::remove(kept);
  fs::create_directories(kept / "in the way");
  EXPECT_TRUE(same(load(file), computed)) << "a folder in the place of the file";
}

TEST_F(HullCache, FolderThatCannotBeWritten_DoesNoHarm) {
  const auto file = write("ring.obj", test::make_ring(20, 10).text());
  const LoadedMesh computed = load_without(file);
  const auto regular = write("regular", "no folder");
  for (const char* below : {"", "below", "below/and/deeper"}) {
    cache_.set((regular / below).c_str());
    EXPECT_TRUE(same(load(file), computed)) << below;
    EXPECT_TRUE(same(load(file), computed)) << below;
  }
  EXPECT_EQ(read(regular), "no folder");
}

TEST_F(HullCache, SwitchedOff_WritesNothing) {
  cache_.set("");
  EXPECT_EQ(default_cache_dir(), fs::path());
  EXPECT_EQ(hull_cache_dir(), fs::path());
  load(write("ring.obj", test::make_ring(20, 10).text()));
  EXPECT_FALSE(fs::exists(dir_ / "kept"));
  EXPECT_FALSE(fs::exists(dir_ / "cache"));
}

TEST_F(HullCache, Folder_FollowsTheEnvironment) {
  EXPECT_EQ(hull_cache_dir(), dir_ / "kept/hulls");
  cache_.set(nullptr);
  EXPECT_EQ(hull_cache_dir(), dir_ / "cache/stiction/hulls");
}

TEST_F(HullCache, WritersAtTheSameTime_LeaveOneGoodFileEach) {
  std::vector<fs::path> files;
  std::vector<LoadedMesh> computed;
  for (int i = 0; i < 3; ++i) {
    files.push_back(write("ring" + std::to_string(i) + ".obj", test::make_ring(12 + i, 8).text()));
    computed.push_back(load_without(files.back()));
  }
  std::atomic<int> different = 0;
  std::vector<std::thread> threads;
  for (int t = 0; t < 4; ++t) {
    threads.emplace_back([&] {
      for (int round = 0; round < 10; ++round) {
        for (std::size_t i = 0; i < files.size(); ++i) {
          if (!same(load(files[i]), computed[i])) ++different;
          std::error_code ignored;
          if (round % 3 == 2) fs::remove_all(hulls_, ignored);  // so that they are written again, and the folder with them
        }
      }
    });
  }
  for (auto& thread : threads) thread.join();
  EXPECT_EQ(different, 0);
  for (std::size_t i = 0; i < files.size(); ++i) EXPECT_TRUE(same(load(files[i]), computed[i]));
  EXPECT_EQ(files_in(hulls_).size(), files.size()) << "and nothing under a temporary name";
}

TEST_F(HullCache, BeyondTheLimit_TheOldestGo) {
  fs::create_directories(hulls_);
  const auto now = fs::file_time_type::clock::now();
  const auto add = [&](const std::string& name, std::size_t size, int hours_ago) {
    std::ofstream(hulls_ / name) << std::string(size, 'x');
    fs::last_write_time(hulls_ / name, now - std::chrono::hours(hours_ago));
  };
  add("a.hulls", 100, 3);
  add("b.hulls", 100, 4);
  add("c.hulls", 100, 1);
  add("d.hulls.Xy12Zz", 100, 5);  // of a program that was stopped while it wrote
  add("notes.txt", 1000, 9);
  trim_hull_cache(hulls_, 400);
  EXPECT_EQ(files_in(hulls_).size(), 5u);
  trim_hull_cache(hulls_, 250);
  EXPECT_FALSE(fs::exists(hulls_ / "d.hulls.Xy12Zz"));
  EXPECT_FALSE(fs::exists(hulls_ / "b.hulls"));
  EXPECT_TRUE(fs::exists(hulls_ / "a.hulls"));
  EXPECT_TRUE(fs::exists(hulls_ / "c.hulls"));
  EXPECT_TRUE(fs::exists(hulls_ / "notes.txt")) << "none of ours";
  trim_hull_cache(hulls_, 0);
  EXPECT_EQ(files_in(hulls_).size(), 1u);
  trim_hull_cache(dir_ / "nowhere", 0);
}

TEST_F(HullCache, Storing_TrimsFromTimeToTime) {
  const auto file = write("ring.obj", test::make_ring(20, 10).text());
  const LoadedMesh ring = load_without(file);
  fs::create_directories(hulls_);
  for (const char* name : {"old.hulls", "older.hulls"}) {
    std::ofstream(hulls_ / name) << "x";
    fs::resize_file(hulls_ / name, kHullCacheLimit / 2 + 1);  // without blocks on the disk
    fs::last_write_time(hulls_ / name, fs::file_time_type::clock::now() - std::chrono::hours(name[3] == '.' ? 1 : 2));
  }
  for (int i = 0; i < 200; ++i) find_or_make_hulls(hulls_, calc_hull_key(std::to_string(i), ""), [&] { return ring; });
  EXPECT_FALSE(fs::exists(hulls_ / "older.hulls"));
  EXPECT_TRUE(fs::exists(hulls_ / "old.hulls"));
}

}  // namespace
}  // namespace stiction::world
