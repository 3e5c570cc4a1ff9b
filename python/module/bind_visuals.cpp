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
  const Eigen::VectorXd& p = std::get<Vector>(wanted).named("poses");
  core::require_size(fmt::format("poses['{}']", name), p.size(), 3);
  return {.body = found[0], .p_WB = p};
}

tasks::PlacedLinks place_links(const Model& model, const Vector& q, const std::map<std::string, Wanted>& poses, int postures,
                               bool overlap) {
  std::vector<tasks::LinkTarget> targets;
  for (const auto& [name, wanted] : poses) targets.push_back(target_of(model, name, wanted));
  const nb::gil_scoped_release unlocked;
  return tasks::place_links(model, q.named("q"), targets, {.postures = postures, .overlap = overlap});
}

}  // namespace

void bind_visuals(nb::module_& m) {
  nb::class_<world::Visual>(m, "Visual", "Visual shape or mesh of a body.")
      .def_ro("body", &world::Visual::body, "index into Model.bodies")
      .def_ro("X_BV", &world::Visual::X_BV, "pose of the visual in the body")
      .def_prop_ro(
          "shape",
          [](const world::Visual& v) -> std::optional<nb::dict> {
            const auto* shape = std::get_if<world::Shape>(&v.form);
            return shape != nullptr ? std::optional(std::visit(ShapeDict{}, *shape)) : std::nullopt;
          },
          nb::sig("def shape(self) -> dict[str, object] | None"), "shape, as in Geometry.shape; None: the visual is a mesh")
      .def_prop_ro(
          "mesh",
          [](const world::Visual& v) {
            const int* mesh = std::get_if<int>(&v.form);
            return mesh != nullptr ? std::optional(*mesh) : std::nullopt;
          },
          "index into Visuals.meshes; None: the visual is a shape")
      .def_ro("color", &world::Visual::color, "red, green, blue and opacity in [0, 1]");
  nb::class_<world::Visuals>(m, "Visuals", "Visual shapes and meshes of a scene.")
      .def_ro("visuals", &world::Visuals::visuals, "visuals of all bodies")
      .def_prop_ro(
          "meshes",
          [](const world::Visuals& v) {
            std::vector<std::pair<Points, Corners>> out;
            for (const auto& mesh : v.meshes) out.emplace_back(mesh->vertices.transpose(), mesh->triangles.transpose());
            return out;
          },
          "vertices (n, 3) [m] and triangles (m, 3) of each mesh")
      .def_ro("notes", &world::Visuals::notes, "remarks on elements that were left out, one sentence each");
  m.def(
      "read_visuals", [](const Model& model) { return world::read_visuals(model); }, "model"_a, nb::call_guard<nb::gil_scoped_release>(),
      R"(Reads the visual shapes and meshes of links and objects: <visual> elements of a URDF, and visible geoms of an MJCF.

Elements that cannot be read are left out, with a remark in `notes`. A body without visuals in its file has none; draw its geometries.)");
  nb::class_<tasks::PlacedLinks>(m, "PlacedLinks", "Result of place_links(): joint positions at which links have given poses.")
      .def_ro("status", &tasks::PlacedLinks::status,
              "Solved; MaxIterations: no posture within the joint limits has the poses; NumericalFailure: every such posture overlaps "
              "something")
      .def_ro("q", &tasks::PlacedLinks::q, "configuration that was found, or the nearest one (n_q)")
      .def_ro("position", &tasks::PlacedLinks::position, "largest position error of a link at q [m]")
      .def_ro("angle", &tasks::PlacedLinks::angle, "largest angle error of a link at q [rad]")
      .def_ro("pair", &tasks::PlacedLinks::pair, "index into Model.pairs of the pair that overlaps most, or -1")
      .def_ro("depth", &tasks::PlacedLinks::depth, "depth of this overlap [m]");
  const tasks::PlaceLinksOptions standard;
  m.def("place_links", &place_links, "model"_a, "q"_a, "poses"_a, nb::kw_only(), "postures"_a = standard.postures,
        "overlap"_a = standard.overlap,
        R"(Finds joint positions at which links have given poses (inverse kinematics), within the joint limits and without overlap.

The result is the posture nearest to q. Objects do not move.

  model: Model with the robot.
  q: configuration (n_q).
  poses: for each link, by its name ("robot/link", or "link" if one robot has it), its Pose X_WB, or its position alone (3) [m].
  postures: number of postures from which the search starts. 1: only q; this is fast, and joints do not jump while a link is dragged.
  overlap: True: accept postures in which bodies overlap.

Returns a PlacedLinks.

    >>> task = st.load_task("iiwa_bimanual_box")
    >>> hand = "left/link_7"
    >>> X = task.model.body_poses(task.q_start)[hand]
    >>> placed = st.place_links(task.model, task.q_start, {hand: st.Pose(X.R, X.p + [0, 0, 0.05])})
    >>> placed.status.name, bool(abs(task.model.body_poses(placed.q)[hand].p - X.p)[2] > 0.049)
    ('Solved', True))");
  def_pickle<world::Visual, world::Visuals, tasks::PlacedLinks>();
}

}  // namespace stiction::python
