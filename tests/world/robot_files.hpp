#pragma once

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>

#include "stiction/world/model.hpp"
#include "stiction/world/read.hpp"
#include "support/message_of.hpp"
#include "support/temporary_folder.hpp"

namespace stiction::world::test {

/// Files of robots in a folder of its own, removed at the end.
class RobotFolder {
 public:
  const std::filesystem::path& path() const { return temporary_.path(); }

  std::filesystem::path write(const std::filesystem::path& name, const std::string& text) const {
    std::filesystem::create_directories((path() / name).parent_path());
    std::ofstream(path() / name, std::ios::binary) << text;
    return path() / name;
  }

  /// The model of a robot "r". @param keys  of its entry in the scene, as "urdf: r.urdf"
  std::shared_ptr<const Model> load(const std::string& keys) const {
    return Model::make(parse_scene("robots: [{name: r, " + keys + "}]", path()));
  }

  /// What loading it says, without the name of the folder.
  std::string message(const std::string& keys) const {
    std::string what = stiction::test::message_of([&] { (void)load(keys); });
    const std::string prefix = path().string() + "/";
    for (auto at = what.find(prefix); at != std::string::npos; at = what.find(prefix)) what.erase(at, prefix.size());
    return what;
  }

 private:
  const stiction::test::TemporaryFolder temporary_{};
};

/// One of the notes of a model contains the text.
inline bool has_note(const Model& model, const std::string& text) {
  return std::ranges::any_of(model.notes(), [&](const std::string& note) { return note.find(text) != std::string::npos; });
}

inline constexpr const char* kTetrahedron = "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nv 0 0 0.1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n";

/// A URDF of one joint "j" whose moving link "tip" has the given elements.
inline std::string one_joint(const std::string& tip, const std::string& joint = "type='revolute'",
                             const std::string& limit = "<limit lower='-1' upper='1' effort='10' velocity='1'/>") {
  return "<robot name='r'><link name='base'/><link name='tip'>" + tip + "</link><joint name='j' " + joint +
         "><parent link='base'/><child link='tip'/><axis xyz='0 0 1'/>" + limit + "</joint></robot>";
}

inline std::string collision(const std::string& shape) { return "<collision><geometry>" + shape + "</geometry></collision>"; }

}  // namespace stiction::world::test
