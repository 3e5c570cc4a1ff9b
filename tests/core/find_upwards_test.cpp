#include "stiction/core/find_upwards.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>

#include "support/temporary_folder.hpp"

namespace stiction::core {
namespace {

namespace fs = std::filesystem;

const fs::path& program() {
  static const fs::path file = fs::canonical("/proc/self/exe");
  return file;
}

/// A folder of that name for the length of a test.
struct Folder {
  explicit Folder(fs::path at) : path(std::move(at)) { fs::create_directories(path); }
  ~Folder() { fs::remove_all(path); }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  fs::path path;
};

/// Different in every process, so that tests of one program may run at the same time.
std::string unique(const std::string& name) { return name + "-" + std::to_string(::getpid()); }

TEST(FindUpwards, ProgramItself_IsFoundInItsOwnFolder) { EXPECT_EQ(find_upwards(program().filename(), 0), program()); }

TEST(FindUpwards, FolderOfTheWorkingDirectory_IsNotLookedInto) {
  const fs::path before = fs::current_path();
  const stiction::test::TemporaryFolder elsewhere;
  std::ofstream(elsewhere.path() / "only_here.txt") << "x";
  fs::current_path(elsewhere.path());
  EXPECT_TRUE(fs::exists("only_here.txt"));
  EXPECT_EQ(find_upwards("only_here.txt", 0), fs::path());
  fs::current_path(before);
}

TEST(FindUpwards, NameInAParent_IsFoundFromItsLevelOn) {
  const std::string name = unique("find-upwards");
  const Folder there(program().parent_path().parent_path() / name / "share");
  EXPECT_EQ(find_upwards(fs::path(name) / "share", 0), fs::path());
  EXPECT_EQ(find_upwards(fs::path(name) / "share", 1), there.path);
  EXPECT_EQ(find_upwards(fs::path(name) / "share", 9), there.path);
  fs::remove_all(there.path.parent_path());
}

TEST(FindUpwards, NameAtTwoLevels_NearestIsTaken) {
  const std::string name = unique("find-upwards-twice");
  const Folder far(program().parent_path().parent_path() / name);
  const Folder near(program().parent_path() / name);
  EXPECT_EQ(find_upwards(name, 3), near.path);
}

TEST(FindUpwards, NothingOfThatName_Empty) {
  EXPECT_EQ(find_upwards("no-such-file-anywhere", 100), fs::path()) << "ends at the root";
  EXPECT_EQ(find_upwards("", 3), fs::path());
}

}  // namespace
}  // namespace stiction::core
