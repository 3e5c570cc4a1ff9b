#include <fmt/format.h>
#include <nanobind/stl/map.h>

#include <fstream>
#include <iterator>
#include <map>
#include <span>

#include "bindings.hpp"
#include "pickles.hpp"
#include "shape_dict.hpp"
#include "stiction/tasks/pose_numbers.hpp"
#include "stiction/tasks/task.hpp"
#include "stiction/world/read.hpp"
#include "yaml_text.hpp"

namespace stiction::python {

namespace {

template <class Counts>
int find_among(const world::Model& model, std::string_view field, const std::string& name, Counts counts) {
  std::vector<std::string> known;
  for (std::size_t b = 0; b < model.bodies().size(); ++b) {
    if (!counts(model.bodies()[b])) continue;
    if (model.bodies()[b].name == name) return static_cast<int>(b);
    known.push_back(model.bodies()[b].name);
  }
  core::throw_invalid(field, "'" + name + "'", "one of " + world::list_with_hint(name, known));
}

}  // namespace

int find_body(const world::Model& model, std::string_view field, const std::string& name) {
  return find_among(model, field, name, [](const world::Body&) { return true; });
}

int find_link(const world::Model& model, std::string_view field, const std::string& name) {
  return find_among(model, field, name, [](const world::Body& body) { return body.kind == world::BodyKind::Robot; });
}

namespace {

using world::Model;
using world::Pose;

Eigen::VectorXd retract(const Model& model, const Vector& q, const Vector& delta) {
  world::require_configuration(model, "q", q.value);
  core::require_size("delta", delta.value.size(), model.n_v());
  Eigen::VectorXd out(model.n_q());
  world::retract(model, q.value, delta.value, out);
  return out;
}

Eigen::VectorXd local(const Model& model, const Vector& q0, const Vector& q1) {
  world::require_configuration(model, "q0", q0.value);
  world::require_configuration(model, "q1", q1.value);
  Eigen::VectorXd out(model.n_v());
  world::local(model, q0.value, q1.value, out);
  return out;
}

Pose object_pose(const Model& model, const Vector& q, const std::string& object) {
  world::require_configuration(model, "q", q.value);
  return world::object_pose(model, q.value, model.object_index(object));
}

Eigen::Vector4d quaternion_of(const Pose& X) {
  const tasks::PoseNumbers numbers = tasks::to_numbers(X);
  return Eigen::Map<const Eigen::Vector4d>(numbers.data() + 3);
}

/// (N, 7): x y z, then the quaternion w x y z.
Rows object_poses(const Model& model, const Matrix& q, const std::string& object) {
  core::require_size("q.shape[1]", q.value.cols(), model.n_q());
  const int index = model.object_index(object);
  Rows out(q.value.rows(), 7);
  for (Eigen::Index i = 0; i < q.value.rows(); ++i) {
    const Eigen::VectorXd one = q.value.row(i);
    world::require_configuration(model, fmt::format("q[{}]", i), one);
    const world::Pose X = world::object_pose(model, one, index);
    out.row(i) << X.p.transpose(), quaternion_of(X).transpose();
  }
  return out;
}

world::Kinematics calc_kinematics(const Model& model, const Vector& q) {
  world::require_configuration(model, "q", q.value);
  world::KinematicsWorkspace work(model);
  world::Kinematics out;
  world::calc_kinematics(model, q.value, work, out);
  return out;
}

/// A link of a robot, by its name and that of the link that it hangs on.
struct RobotLink {
  std::string name;
  std::optional<std::string> parent;
  bool moves = false;
};

std::vector<RobotLink> links_of(const Model& model) {
  const auto name_of = [&](int body) { return model.bodies()[static_cast<std::size_t>(body)].name; };
  std::vector<RobotLink> out;
  for (const world::Link& link : model.links())
    out.push_back({name_of(link.body), link.parent < 0 ? std::nullopt : std::optional(name_of(link.parent)), link.dof >= 0});
  return out;
}

nb::dict body_poses(const Model& model, const Vector& q) {
  const world::Kinematics kinematics = calc_kinematics(model, q);
  nb::dict out;
  for (std::size_t i = 0; i < model.bodies().size(); ++i) out[nb::str(model.bodies()[i].name.c_str())] = nb::cast(kinematics.X_WB[i]);
  return out;
}

/// A rotation to as many digits as a file writes. @throws core::InvalidInput
Pose make_pose(const Matrix& R, const Vector& p) {
  core::require_size("R: rows", R.value.rows(), 3);
  core::require_size("R: columns", R.value.cols(), 3);
  core::require_size("p", p.value.size(), 3);
  core::require_finite("p", {p.value.data(), 3});
  const Eigen::Matrix3d rotation = R.value;
  const double off = (rotation.transpose() * rotation - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  constexpr double kOrthonormal = 1e-6;
  if (!(off <= kOrthonormal)) core::throw_invalid("R", fmt::format("RᵀR that differs from 1 by {:.3g}", off), "a rotation");
  if (rotation.determinant() < 0) core::throw_invalid("R", "a reflection", "a rotation");
  return {rotation, p.value};
}

/// By name of the robot; those of an MJCF have none.
std::map<std::string, std::string> robot_urdfs(const world::Scene& scene) {
  std::map<std::string, std::string> out;
  for (const world::RobotSpec& robot : scene.robots) {
    if (!robot.mjcf.empty()) continue;
    std::string text = robot.text;
    if (text.empty()) {
      std::ifstream in(robot.urdf, std::ios::binary);
      text.assign(std::istreambuf_iterator<char>(in), {});
    }
    if (text.find("<robot") != std::string::npos) out.emplace(robot.name, std::move(text));
  }
  return out;
}

world::Scene scene_of_file(const std::filesystem::path& file) { return world::load_scene(file, tasks::default_package_dirs()); }

world::Scene scene_of_dict(const nb::dict& scene, const std::optional<std::filesystem::path>& base) {
  return world::parse_scene(yaml_text(scene), folder_of(base), tasks::default_package_dirs());
}

template <class T>
std::vector<T> list_of(std::span<const T> items) {
  return {items.begin(), items.end()};
}

std::vector<std::string> joint_names(const Model& model) {
  std::vector<std::string> out;
  for (const auto& dof : model.dofs().subspan(static_cast<std::size_t>(model.n_vu()))) out.push_back(dof.name);
  return out;
}

std::vector<std::string> object_names(const Model& model) {
  std::vector<std::string> out;
  for (const auto& object : model.objects()) out.push_back(object.name);
  return out;
}

void bind_records(nb::module_& m) {
  nb::class_<Pose>(m, "Pose", "Rigid transform X_AB: a point p_B in B is at R p_B + p in A.")
      .def(
          "__init__", [](Pose* self, const Matrix& R, const Vector& p) { new (self) Pose(make_pose(R, p)); }, "R"_a, "p"_a,
          "R: a rotation (3, 3); p [m] (3)"
          R"(

    >>> X_WA = st.Pose([[0, -1, 0], [1, 0, 0], [0, 0, 1]], [1, 0, 0])  # a quarter turn about z
    >>> (X_WA @ st.Pose(np.eye(3), [2, 0, 0])).p
    array([1., 2., 0.]))")
      .def_ro("R", &Pose::R, "rotation (3, 3)")
      .def_ro("p", &Pose::p, "position [m] (3)")
      .def_prop_ro("quaternion_wxyz", &quaternion_of, "of R, in the order w, x, y, z with w not negative (4)")
      .def("__matmul__", [](const Pose& a, const Pose& b) { return a * b; })
      .def("inverse", &Pose::inverse, "X_BA of X_AB")
      .def("__repr__", [](const Pose& X) { return fmt::format("Pose(p=[{:.6g}, {:.6g}, {:.6g}])", X.p[0], X.p[1], X.p[2]); });
  nb::enum_<world::BodyKind>(m, "BodyKind", "What moves a body.")
      .value("Fixed", world::BodyKind::Fixed)
      .value("Object", world::BodyKind::Object)
      .value("Robot", world::BodyKind::Robot);
  nb::enum_<world::DofKind>(m, "DofKind", "How a coordinate moves.")
      .value("Prismatic", world::DofKind::Prismatic)
      .value("Revolute", world::DofKind::Revolute);
  nb::class_<world::Body>(m, "Body", "A rigid body: fixed, of an object, or a link of a robot.")
      .def_ro("name", &world::Body::name)
      .def_ro("kind", &world::Body::kind)
      .def_ro("dofs", &world::Body::dofs, "velocity indices that move it");
  nb::class_<RobotLink>(m, "RobotLink", "A link of a robot, and what it hangs on.")
      .def_ro("name", &RobotLink::name, "of its body, as robot/link")
      .def_ro("parent", &RobotLink::parent, "of the body that it hangs on; None: the link stands in the world")
      .def_ro("moves", &RobotLink::moves, "a joint moves it relative to its parent");
  nb::class_<world::Geometry>(m, "Geometry", "A shape on a body.")
      .def_ro("name", &world::Geometry::name)
      .def_ro("body", &world::Geometry::body)
      .def_ro("X_BG", &world::Geometry::X_BG)
      .def_prop_ro(
          "shape", [](const world::Geometry& g) { return std::visit(ShapeDict{}, g.shape); },
          nb::sig("def shape(self) -> dict[str, object]"),
          "its `type` and the numbers of that type, as in a plan file (docs/plan_file.md) [m]; arrays for those of a mesh")
      .def_ro("friction", &world::Geometry::friction)
      .def_ro("max_force", &world::Geometry::max_force,
              "Largest normal force that it bears from one other geometry [N], infinite where there is no limit");
  nb::class_<world::Pair>(m, "Pair", "Two geometries that may touch, as indices into Model.geometries.")
      .def_ro("geometry_a", &world::Pair::geometry_a)
      .def_ro("geometry_b", &world::Pair::geometry_b)
      .def_ro("friction", &world::Pair::friction)
      .def_ro("torsional", &world::Pair::torsional,
              "Largest moment about the normal, beside the normal force [m]; 0 where contacts do not resist turning; in simulation only")
      .def_ro("rolling", &world::Pair::rolling, "The same about the tangents [m]")
      .def_ro("max_distance", &world::Pair::max_distance, "[m]");
  nb::class_<world::Dof>(m, "Dof", "A coordinate: of an object, or a joint of a robot.")
      .def_ro("name", &world::Dof::name)
      .def_ro("kind", &world::Dof::kind)
      .def_ro("lower", &world::Dof::lower, "[m or rad]")
      .def_ro("upper", &world::Dof::upper, "[m or rad]")
      .def_ro("stiffness", &world::Dof::stiffness, "K_a [N/m or N m/rad], 0 for objects")
      .def_ro("effort", &world::Dof::effort, "Largest force or torque of the motor [N or N m], infinite where there is no limit")
      .def_ro("friction", &world::Dof::friction, "Dry friction of a hinge, slider or robot joint [N m or N]; steps know that of objects")
      .def_ro("damping", &world::Dof::damping,
              "Viscous friction of a hinge, slider or robot joint [N m s/rad or N s/m], in simulation only");
  nb::class_<world::ObjectInfo>(m, "ObjectInfo", "Where the coordinates of an object stand in q and v.")
      .def_ro("name", &world::ObjectInfo::name)
      .def_ro("body", &world::ObjectInfo::body)
      .def_ro("v_begin", &world::ObjectInfo::v_begin)
      .def_ro("n_v", &world::ObjectInfo::n_v)
      .def_ro("q_begin", &world::ObjectInfo::q_begin)
      .def_ro("n_q", &world::ObjectInfo::n_q)
      .def_ro("parent", &world::ObjectInfo::parent, "index of the object that it hangs on, or -1")
      .def_ro("mass", &world::ObjectInfo::mass, "[kg]");
  nb::class_<world::Kinematics>(m, "Kinematics", "Poses of all bodies and axes of all coordinates at one configuration.")
      .def_ro("X_WB", &world::Kinematics::X_WB)
      .def_ro("axis_W", &world::Kinematics::axis_W, "unit axes (3, n_v)")
      .def_ro("origin_W", &world::Kinematics::origin_W, "a point on each axis [m] (3, n_v)");
}

}  // namespace

void bind_world(nb::module_& m) {
  bind_records(m);
  nb::class_<world::Scene>(m, "Scene", "What there is, as a scene file says.")
      .def_ro("name", &world::Scene::name)
      .def_ro("gravity", &world::Scene::gravity, "[m/s^2], acts on objects only")
      .def_ro("contact_distance", &world::Scene::contact_distance, "[m]")
      .def_prop_ro("robot_urdfs", &robot_urdfs,
                   "robot -> its URDF as the file has it now; without what is mounted on it, and without robots of an MJCF");
  m.def("load_scene", &scene_of_file, "file"_a,
        "The scene of a file (YAML, also of a task). Raises InvalidInput: \"FILE:LINE: field: got …\".");
  m.def("load_scene", &scene_of_dict, "scene"_a, nb::kw_only(), "base"_a = nb::none(),
        "The scene of a dict, with the keys of a file. `urdf` and `mjcf` of a robot are paths, or the URDF or MJCF itself as a str. base: "
        "the "
        "folder that paths in it are relative to; None: the working folder. "
        "Raises InvalidInput: \"field: got …, expected …\".");
  m.def(
      "load_model", [](const std::filesystem::path& file) { return Model::make(scene_of_file(file)); }, "file"_a,
      nb::call_guard<nb::gil_scoped_release>(), "Model.make(load_scene(file)).");
  m.def(
      "load_model",
      [](const nb::dict& scene, const std::optional<std::filesystem::path>& base) {
        const world::Scene made = scene_of_dict(scene, base);
        const nb::gil_scoped_release unlocked;
        return Model::make(made);
      },
      "scene"_a, nb::kw_only(), "base"_a = nb::none(),
      "Model.make(load_scene(scene, base=base))."
      R"(

    >>> model = st.load_model({
    ...     "gravity": [0, 0, -9.81],
    ...     "robots": [{"name": "arm", "urdf": "package://example-robot-data/robots/ur_description/urdf/ur5_robot.urdf"}],
    ...     "objects": [{"name": "box", "joint": "free", "mass": 0.5, "shapes": [{"box": {"size": [0.1, 0.1, 0.1]}}]}],
    ...     "fixed": [{"name": "table", "shapes": [{"half_space": {}}]}],
    ...     "filters": [{"exclude": ["arm", "table"]}],
    ... })
    >>> model.n_a, model.n_q, model.object_names
    (6, 13, ['box'])
    >>> cart = """<robot name="cart"><link name="rail"/><link name="body"/>
    ...   <joint name="x" type="prismatic"><parent link="rail"/><child link="body"/></joint></robot>"""
    >>> st.load_model({"robots": [{"name": "cart", "urdf": cart}]}).joint_names
    ['cart/x'])");

  nb::class_<Model>(m, "Model", "Immutable kinematics, actuation, geometry and friction of a scene, shared by threads.")
      .def_static("make", &Model::make, "scene"_a, "The model of a scene. Raises InvalidInput.")
      .def(
          "__reduce__",
          [](const Model& model) {
            return nb::make_tuple(nb::module_::import_("stiction._pickles").attr("make_model"), nb::make_tuple(model.scene()));
          },
          nb::sig("def __reduce__(self) -> tuple"))
      .def_prop_ro("scene", &Model::scene, nb::rv_policy::reference_internal)
      .def_prop_ro("n_q", &Model::n_q)
      .def_prop_ro("n_v", &Model::n_v)
      .def_prop_ro("n_vu", &Model::n_vu, "velocity coordinates of the objects")
      .def_prop_ro("n_qu", &Model::n_qu, "configuration numbers of the objects")
      .def_prop_ro("n_a", &Model::n_a, "actuated joints, the length of u")
      .def_prop_ro("stiffness", &Model::stiffness, nb::rv_policy::copy, "K_a (n_a) [N/m or N m/rad]")
      .def_prop_ro("effort", &Model::effort, nb::rv_policy::copy,
                   "Largest forces and torques of the motors (n_a) [N or N m], infinite where there is no limit")
      .def_prop_ro("speed_limit", &Model::speed_limit, nb::rv_policy::copy,
                   "How fast the joints may be as the URDF says (n_a) [m/s or rad/s], infinite where there is no limit")
      .def_prop_ro("lower", &Model::lower, nb::rv_policy::copy, "joint limits (n_a) [m or rad]")
      .def_prop_ro("upper", &Model::upper, nb::rv_policy::copy)
      .def_prop_ro("reach", &Model::reach, nb::rv_policy::copy, "bound on the lever of each joint (n_a) [m]")
      .def_prop_ro("joint_names", &joint_names, "as robot/joint, in the order of u")
      .def_prop_ro("object_names", &object_names)
      .def_prop_ro("bodies", [](const Model& model) { return list_of(model.bodies()); })
      .def_prop_ro("links", &links_of, "of all robots, parents first")
      .def_prop_ro("geometries", [](const Model& model) { return list_of(model.geometries()); })
      .def_prop_ro("pairs", [](const Model& model) { return list_of(model.pairs()); })
      .def_prop_ro("dofs", [](const Model& model) { return list_of(model.dofs()); })
      .def_prop_ro("objects", [](const Model& model) { return list_of(model.objects()); })
      .def_prop_ro(
          "notes", [](const Model& model) { return list_of(model.notes()); },
          "what was taken otherwise than the files say, or chosen where they say nothing")
      .def_prop_ro("planar_axis", &Model::planar_axis, "axis normal to the plane in which everything moves, or None")
      .def("neutral", &Model::neutral, "every object at its placed frame, every joint as near to 0 as its limits allow (n_q)")
      .def("joint_index", &Model::joint_index, "name"_a, "of a joint in u. Raises InvalidInput: no such joint")
      .def("object_index", &Model::object_index, "name"_a, "of an object in `objects`. Raises InvalidInput: no such object")
      .def("retract", &retract, "q"_a, "delta"_a,
           "q ⊕ δ: the only way to move (n_q)"
           R"(

    >>> model = st.load_task("allegro_ball").model
    >>> q = model.neutral()
    >>> delta = np.full(model.n_v, 0.1)
    >>> bool(np.allclose(model.local(q, model.retract(q, delta)), delta))
    True)")
      .def("local", &local, "q0"_a, "q1"_a, "q1 ⊖ q0 (n_v)")
      .def("object_pose", &object_pose, "q"_a, "object"_a, "X_WB of a named object")
      .def("object_poses", &object_poses, "q"_a, "object"_a,
           "X_WB of a named object at many configurations (N, n_q), as (N, 7): x y z [m], then the quaternion w x y z with w not negative")
      .def("calc_kinematics", &calc_kinematics, "q"_a, "Poses and axes at q (n_q).")
      .def("body_poses", &body_poses, "q"_a, "X_WB by name of the body",
           nb::sig("def body_poses(self, q: numpy.typing.ArrayLike) -> dict[str, Pose]"))
      .def("__repr__", [](const Model& model) {
        return fmt::format("<stiction.Model '{}': n_q {}, n_v {}, n_a {}, {} pairs>", model.scene().name, model.n_q(), model.n_v(),
                           model.n_a(), model.pairs().size());
      });
  def_pickle<Pose, RobotLink, world::Body, world::Geometry, world::Pair, world::Dof, world::ObjectInfo, world::Kinematics, world::Scene>();
  def_shared_copy<Model>();
}

}  // namespace stiction::python
