#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nanobind/stl/map.h>

#include <map>
#include <variant>

#include "pickles.hpp"
#include "shape_dict.hpp"
#include "stiction/tasks/place_links.hpp"
#include "stiction/world/visuals.hpp"

namespace stiction::python {
namespace {

using world::Model;
using Points = Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor>;
using Corners = Eigen::Matrix<int, Eigen::Dynamic, 3, Eigen::RowMajor>;

/// A pose, or a position alone.
using Wanted = std::variant<world::Pose, Vector>;

tasks::LinkTarget target_of(const Model& model, const std::string& name, const Wanted& wanted) {
  const std::vector<int> found = tasks::find_links(model, name);
  if (found.size() != 1) {
    std::vector<std::string> known;
    for (const auto& link : model.links()) {
      const auto& body = model.bodies()[static_cast<std::size_t>(link.body)];
      if (!body.dofs.empty()) known.push_back(body.name);
    }
    core::throw_invalid("poses", fmt::format("'{}', which {} links are", name, found.size()),
                        fmt::format("a link that moves, one of {}", fmt::join(known, ", ")));
  }
  if (const auto* pose = std::get_if<world::Pose>(&wanted)) return {.body = found[0], .p_WB = pose->p, .R_WB = pose->R};
  const Eigen::VectorXd& p = std::get<Vector>(wanted).value;
  core::require_size(fmt::format("poses['{}']", name), p.size(), 3);
  return {.body = found[0], .p_WB = p};
}

tasks::PlacedLinks place_links(const Model& model, const Vector& q, const std::map<std::string, Wanted>& poses, int postures,
                               bool overlap) {
  std::vector<tasks::LinkTarget> targets;
  for (const auto& [name, wanted] : poses) targets.push_back(target_of(model, name, wanted));
  const nb::gil_scoped_release unlocked;
  return tasks::place_links(model, q.value, targets, {.postures = postures, .overlap = overlap});
}

}  // namespace

void bind_visuals(nb::module_& m) {
  nb::class_<world::Visual>(m, "Visual", "What is seen of a body.")
      .def_ro("body", &world::Visual::body)
      .def_ro("X_BV", &world::Visual::X_BV)
      .def_prop_ro(
          "shape",
          [](const world::Visual& v) -> std::optional<nb::dict> {
            const auto* shape = std::get_if<world::Shape>(&v.form);
            return shape != nullptr ? std::optional(std::visit(ShapeDict{}, *shape)) : std::nullopt;
          },
          nb::sig("def shape(self) -> dict[str, object] | None"), "as Geometry.shape; None: a mesh")
      .def_prop_ro(
          "mesh",
          [](const world::Visual& v) {
            const int* mesh = std::get_if<int>(&v.form);
            return mesh != nullptr ? std::optional(*mesh) : std::nullopt;
          },
          "index into Visuals.meshes; None: a shape")
      .def_ro("color", &world::Visual::color, "red, green, blue, opacity in [0, 1]");
  nb::class_<world::Visuals>(m, "Visuals", "Pictures of a scene, as its files show it.")
      .def_ro("visuals", &world::Visuals::visuals)
      .def_prop_ro(
          "meshes",
          [](const world::Visuals& v) {
            std::vector<std::pair<Points, Corners>> out;
            for (const auto& mesh : v.meshes) out.emplace_back(mesh->vertices.transpose(), mesh->triangles.transpose());
            return out;
          },
          "vertices (n, 3) [m] and triangles (m, 3) of each")
      .def_ro("notes", &world::Visuals::notes, "what is left out, one sentence each");
  m.def(
      "read_visuals", [](const Model& model) { return world::read_visuals(model); }, "model"_a, nb::call_guard<nb::gil_scoped_release>(),
      "Pictures of links and objects as the files of the robots show them: <visual> elements of a URDF, visible geoms of an MJCF. What "
      "cannot "
      "be read is left out with a note. Bodies that no file shows have none: their geometries stand for them.");
  nb::class_<tasks::PlacedLinks>(m, "PlacedLinks", "Joints with which links have poses.")
      .def_ro("status", &tasks::PlacedLinks::status,
              "Solved; MaxIterations: no posture inside the limits has the poses; NumericalFailure: those that have them overlap something")
      .def_ro("q", &tasks::PlacedLinks::q, "the posture that was found, else the nearest to one (n_q)")
      .def_ro("position", &tasks::PlacedLinks::position, "how far a link is from where it is to be there, at most [m]")
      .def_ro("angle", &tasks::PlacedLinks::angle, "the same of its orientation [rad]")
      .def_ro("pair", &tasks::PlacedLinks::pair, "index into Model.pairs of what overlaps most, or -1")
      .def_ro("depth", &tasks::PlacedLinks::depth, "by how much [m]");
  const tasks::PlaceLinksOptions standard;
  m.def("place_links", &place_links, "model"_a, "q"_a, "poses"_a, nb::kw_only(), "postures"_a = standard.postures,
        "overlap"_a = standard.overlap,
        R"(Joints with which links have poses, nearest to those of q, inside their limits and without overlap. Objects stay.

  poses: by name of the link ("robot/link", or "link" where one robot has it) its Pose X_WB, or its position (3) alone.
  postures: that the search starts from; 1 starts from q alone, which is fast, and what a link wants that is dragged: no joint leaps.
  overlap: postures in which something overlaps are as good as others.

    >>> task = st.load_task("iiwa_bimanual_box")
    >>> hand = "left/link_7"
    >>> X = task.model.body_poses(task.q_start)[hand]
    >>> placed = st.place_links(task.model, task.q_start, {hand: st.Pose(X.R, X.p + [0, 0, 0.05])})
    >>> placed.status.name, bool(abs(task.model.body_poses(placed.q)[hand].p - X.p)[2] > 0.049)
    ('Solved', True))");
  def_pickle<world::Visual, world::Visuals, tasks::PlacedLinks>();
}

}  // namespace stiction::python
