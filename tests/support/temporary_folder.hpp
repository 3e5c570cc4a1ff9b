// Folders for what a test writes. Tests run side by side, each in a process of its own: no two may write to one place.
#pragma once

#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <system_error>

namespace stiction::test {

/// An empty folder that no other process uses, removed at the end with all that lies in it.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "stiction-test-XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr) throw std::system_error(errno, std::generic_category(), name);
    path_ = name;
  }
  ~TemporaryFolder() {
    std::error_code ignored;  // nothing may be thrown here
    std::filesystem::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// One of them that lives as long as the program, for files that functions write and name.
inline const std::filesystem::path& folder_of_the_process() {
  static const TemporaryFolder folder;
  return folder.path();
}

}  // namespace stiction::test
