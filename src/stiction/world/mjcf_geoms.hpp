#pragma once

#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "stiction/world/mjcf_view.hpp"
#include "stiction/world/robot_tree.hpp"
#include "stiction/world/simplify_hull.hpp"

namespace stiction::world {

/// Reads the geoms of a compiled MJCF that collide.
class MjcfGeoms : private MjcfView {
 public:
  explicit MjcfGeoms(const MjcfView& view);

  /// The geom with its pose in its body. @param holder  link, object or fixed body that gets it
  /// @param simpler  true: the hull of a mesh gets fewer corners
  RobotCollision read(int geom, const std::string& holder, bool simpler);
  /// "HOLDER/GEOM" of a geom that was read; else empty
  std::string full_name(int geom) const;
  void add_note(std::vector<std::string>& notes) const { hulls_.add_note(notes); }

 private:
  std::string make_name(int geom, const std::string& holder, const Shape& shape);
  Shape read_shape(int geom) const;

  std::set<std::string> given_{};  ///< names of the file that are used as they are
  std::set<std::string> taken_{};  ///< "HOLDER/GEOM" of all geoms that were read
  std::map<int, std::string> full_name_{};
  LinkHulls hulls_{};
};

}  // namespace stiction::world
