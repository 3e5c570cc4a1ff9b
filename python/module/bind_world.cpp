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
  world::require_configuration(model, "q", q.named("q"));
  core::require_size("delta", delta.named("delta").size(), model.n_v());
  Eigen::VectorXd out(model.n_q());
  world::retract(model, q.named("q"), delta.named("delta"), out);
  return out;
}

Eigen::VectorXd local(const Model& model, const Vector& q0, const Vector& q1) {
  world::require_configuration(model, "q0", q0.named("q0"));
  world::require_configuration(model, "q1", q1.named("q1"));
  Eigen::VectorXd out(model.n_v());
  world::local(model, q0.named("q0"), q1.named("q1"), out);
  return out;
}

Pose object_pose(const Model& model, const Vector& q, const std::string& object) {
  world::require_configuration(model, "q", q.named("q"));
  return world::object_pose(model, q.named("q"), model.object_index(object));
}

Eigen::Vector4d quaternion_of(const Pose& X) {
  const tasks::PoseNumbers numbers = tasks::to_numbers(X);
  return Eigen::Map<const Eigen::Vector4d>(numbers.data() + 3);
}

/// (N, 7): x y z, then the quaternion w x y z.
Rows object_poses(const Model& model, const Matrix& q, const std::string& object) {
  core::require_size("q.shape[1]", q.named("q").cols(), model.n_q());
  const int index = model.object_index(object);
  Rows out(q.named("q").rows(), 7);
  for (Eigen::Index i = 0; i < q.named("q").rows(); ++i) {
    const Eigen::VectorXd one = q.named("q").row(i);
    world::require_configuration(model, fmt::format("q[{}]", i), one);
    const world::Pose X = world::object_pose(model, one, index);
    out.row(i) << X.p.transpose(), quaternion_of(X).transpose();
  }
  return out;
}

world::Kinematics calc_kinematics(const Model& model, const Vector& q) {
  world::require_configuration(model, "q", q.named("q"));
  world::KinematicsWorkspace work(model);
  world::Kinematics out;
  world::calc_kinematics(model, q.named("q"), work, out);
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
  core::require_size("R: rows", R.named("R").rows(), 3);
  core::require_size("R: columns", R.named("R").cols(), 3);
  core::require_size("p", p.named("p").size(), 3);
  core::require_finite("p", {p.named("p").data(), 3});
  const Eigen::Matrix3d rotation = R.named("R");
  const double off = (rotation.transpose() * rotation - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  constexpr double kOrthonormal = 1e-6;
  if (!(off <= kOrthonormal)) core::throw_invalid("R", fmt::format("RᵀR that differs from 1 by {:.3g}", off), "a rotation");
  if (rotation.determinant() < 0) core::throw_invalid("R", "a reflection", "a rotation");
  return {rotation, p.named("p")};
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
          R"(Makes a pose.

  R: rotation matrix (3, 3).
  p: position [m] (3).

    >>> X_WA = st.Pose([[0, -1, 0], [1, 0, 0], [0, 0, 1]], [1, 0, 0])  # a quarter turn about z
    >>> (X_WA @ st.Pose(np.eye(3), [2, 0, 0])).p
    array([1., 2., 0.]))")
      .def_ro("R", &Pose::R, "rotation (3, 3)")
      .def_ro("p", &Pose::p, "position [m] (3)")
      .def_prop_ro("quaternion_wxyz", &quaternion_of, "quaternion of R in the order w, x, y, z, with w >= 0 (4)")
      .def("__matmul__", [](const Pose& a, const Pose& b) { return a * b; })
      .def("inverse", &Pose::inverse, "Returns the inverse transform: X_BA for X_AB.")
      .def("__repr__", [](const Pose& X) { return fmt::format("Pose(p=[{:.6g}, {:.6g}, {:.6g}])", X.p[0], X.p[1], X.p[2]); });
  nb::enum_<world::BodyKind>(m, "BodyKind", "Kind of a body.")
      .value("Fixed", world::BodyKind::Fixed, "the body does not move")
      .value("Object", world::BodyKind::Object, "the body is an object")
      .value("Robot", world::BodyKind::Robot, "the body is a link of a robot");
  nb::enum_<world::DofKind>(m, "DofKind", "Kind of a coordinate: translation or rotation.")
      .value("Prismatic", world::DofKind::Prismatic, "translation [m]")
      .value("Revolute", world::DofKind::Revolute, "rotation [rad]");
  nb::class_<world::Body>(m, "Body", "Rigid body: a fixed body, an object, or a link of a robot.")
      .def_ro("name", &world::Body::name, "name of the body")
      .def_ro("kind", &world::Body::kind, "kind of the body")
      .def_ro("dofs", &world::Body::dofs, "indices of the velocity coordinates that move the body");
  nb::class_<RobotLink>(m, "RobotLink", "Link of a robot, with the name of its parent.")
      .def_ro("name", &RobotLink::name, "name of the link, as robot/link")
      .def_ro("parent", &RobotLink::parent, "name of the parent link; None: the link is attached to the world")
      .def_ro("moves", &RobotLink::moves, "True: a joint moves the link relative to its parent");
  nb::class_<world::Geometry>(m, "Geometry", "Collision shape on a body.")
      .def_ro("name", &world::Geometry::name, "name of the geometry")
      .def_ro("body", &world::Geometry::body, "index into Model.bodies")
      .def_ro("X_BG", &world::Geometry::X_BG, "pose of the geometry in the body")
      .def_prop_ro(
          "shape", [](const world::Geometry& g) { return std::visit(ShapeDict{}, g.shape); },
          nb::sig("def shape(self) -> dict[str, object]"),
          "dict with the `type` of the shape and its dimensions [m], as in a plan file (docs/plan_file.md); a mesh has arrays")
      .def_ro("friction", &world::Geometry::friction, "friction coefficient of the geometry")
      .def_ro("max_force", &world::Geometry::max_force,
              "largest normal force that the geometry bears from one other geometry [N]; infinite: no limit");
  nb::class_<world::Pair>(m, "Pair", "Two geometries that may touch.")
      .def_ro("geometry_a", &world::Pair::geometry_a, "index of A in Model.geometries")
      .def_ro("geometry_b", &world::Pair::geometry_b, "index of B in Model.geometries")
      .def_ro("friction", &world::Pair::friction, "friction coefficient of the pair")
      .def_ro("torsional", &world::Pair::torsional,
              "torsional friction: largest moment about the normal divided by the normal force [m]; 0: none")
      .def_ro("rolling", &world::Pair::rolling,
              "rolling friction: largest moment about the tangents divided by the normal force [m]. Only simulation uses it")
      .def_ro("max_distance", &world::Pair::max_distance, "the pair counts as a contact only if it is nearer than this [m]");
  nb::class_<world::Dof>(m, "Dof", "Velocity coordinate of an object, or joint of a robot.")
      .def_ro("name", &world::Dof::name, "name of the coordinate")
      .def_ro("kind", &world::Dof::kind, "translation or rotation")
      .def_ro("lower", &world::Dof::lower, "lower limit [m or rad]")
      .def_ro("upper", &world::Dof::upper, "upper limit [m or rad]")
      .def_ro("command_lower", &world::Dof::command_lower, "smallest command of a robot joint [m or rad]; see Model.command_lower")
      .def_ro("command_upper", &world::Dof::command_upper, "largest command of a robot joint [m or rad]; see Model.command_upper")
      .def_ro("stiffness", &world::Dof::stiffness, "stiffness K_a of the joint [N/m or N m/rad]; 0 for objects")
      .def_ro("effort", &world::Dof::effort, "largest force or torque of the motor [N or N m]; infinite: no limit")
      .def_ro("friction", &world::Dof::friction,
              "dry friction of a hinge, slider or robot joint [N m or N]; step() uses it for objects only")
      .def_ro("damping", &world::Dof::damping,
              "viscous friction of a hinge, slider or robot joint [N m s/rad or N s/m]; only simulation uses it");
  nb::class_<world::ObjectInfo>(m, "ObjectInfo", "An object, and the indices of its coordinates in q and v.")
      .def_ro("name", &world::ObjectInfo::name, "name of the object")
      .def_ro("body", &world::ObjectInfo::body, "index into Model.bodies")
      .def_ro("v_begin", &world::ObjectInfo::v_begin, "index of its first coordinate in v")
      .def_ro("n_v", &world::ObjectInfo::n_v, "number of its coordinates in v")
      .def_ro("q_begin", &world::ObjectInfo::q_begin, "index of its first number in q")
      .def_ro("n_q", &world::ObjectInfo::n_q, "number of its numbers in q")
      .def_ro("parent", &world::ObjectInfo::parent, "index of the object that carries it through a joint, or -1")
      .def_ro("mass", &world::ObjectInfo::mass, "mass [kg]");
  nb::class_<world::Kinematics>(m, "Kinematics", "Poses of all bodies and axes of all coordinates at one configuration.")
      .def_ro("X_WB", &world::Kinematics::X_WB, "pose of each body in W")
      .def_ro("axis_W", &world::Kinematics::axis_W, "unit axis of each coordinate in W (3, n_v)")
      .def_ro("origin_W", &world::Kinematics::origin_W, "a point on each axis, in W [m] (3, n_v)");
}

}  // namespace

void bind_world(nb::module_& m) {
  bind_records(m);
  nb::class_<world::Scene>(m, "Scene", "Description of robots, objects and fixed bodies, as in a scene file.")
      .def_ro("name", &world::Scene::name, "name of the scene")
      .def_ro("gravity", &world::Scene::gravity, "gravity [m/s^2] (3); it acts on objects only")
      .def_ro("contact_distance", &world::Scene::contact_distance, "pairs closer than this count as contacts [m]")
      .def_prop_ro(
          "robot_urdfs", &robot_urdfs,
          "text of each robot's URDF file: {robot: text}; without tools that are mounted on the robot, and without robots from MJCF files");
  m.def("load_scene", &scene_of_file, "file"_a,
        "Loads a scene from a YAML file, which may be a task file. Raises InvalidInput: \"FILE:LINE: field: got …\".");
  m.def("load_scene", &scene_of_dict, "scene"_a, nb::kw_only(), "base"_a = nb::none(),
        R"(Makes a scene from a dict with the keys of a scene file.

  scene: dict. The keys `urdf` and `mjcf` of a robot are paths, or the text of the URDF or MJCF itself.
  base: folder to which paths in the dict are relative. None: the working folder.

Raises InvalidInput with the text "field: got …, expected …".)");
  m.def(
      "load_model", [](const std::filesystem::path& file) { return Model::make(scene_of_file(file)); }, "file"_a,
      nb::call_guard<nb::gil_scoped_release>(), "Loads the model of a scene file: Model.make(load_scene(file)).");
  m.def(
      "load_model",
      [](const nb::dict& scene, const std::optional<std::filesystem::path>& base) {
        const world::Scene made = scene_of_dict(scene, base);
        const nb::gil_scoped_release unlocked;
        return Model::make(made);
      },
      "scene"_a, nb::kw_only(), "base"_a = nb::none(),
      "Makes the model of a scene that is a dict: Model.make(load_scene(scene, base=base))."
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

  nb::class_<Model>(m, "Model", "Kinematics, actuation, geometry and friction of a scene. A model is immutable, and threads may share it.")
      .def_static("make", &Model::make, "scene"_a, "Makes the model of a scene. Raises InvalidInput.")
      .def(
          "__reduce__",
          [](const Model& model) {
            return nb::make_tuple(nb::module_::import_("stiction._pickles").attr("make_model"), nb::make_tuple(model.scene()));
          },
          nb::sig("def __reduce__(self) -> tuple"))
      .def_prop_ro("scene", &Model::scene, nb::rv_policy::reference_internal, "scene of the model")
      .def_prop_ro("n_q", &Model::n_q, "length of a configuration q")
      .def_prop_ro("n_v", &Model::n_v, "number of velocity coordinates")
      .def_prop_ro("n_vu", &Model::n_vu, "number of velocity coordinates of the objects")
      .def_prop_ro("n_qu", &Model::n_qu, "length of the objects' part of q")
      .def_prop_ro("n_a", &Model::n_a, "number of actuated joints, the length of a command u")
      .def_prop_ro("stiffness", &Model::stiffness, nb::rv_policy::copy, "stiffness K_a of the joints (n_a) [N/m or N m/rad]")
      .def_prop_ro("effort", &Model::effort, nb::rv_policy::copy,
                   "largest forces and torques of the motors (n_a) [N or N m]; infinite: no limit")
      .def_prop_ro("speed_limit", &Model::speed_limit, nb::rv_policy::copy,
                   "speed limits of the joints from the URDF (n_a) [m/s or rad/s]; infinite: no limit")
      .def_prop_ro("lower", &Model::lower, nb::rv_policy::copy, "lower joint limits (n_a) [m or rad]")
      .def_prop_ro("upper", &Model::upper, nb::rv_policy::copy, "upper joint limits (n_a) [m or rad]")
      .def_prop_ro("command_lower", &Model::command_lower, nb::rv_policy::copy,
                   "smallest commands (n_a) [m or rad]: the lower joint limits, or less where ctrlrange in an MJCF goes further")
      .def_prop_ro("command_upper", &Model::command_upper, nb::rv_policy::copy,
                   "largest commands (n_a) [m or rad]: the upper joint limits, or more where ctrlrange in an MJCF goes further")
      .def_prop_ro("reach", &Model::reach, nb::rv_policy::copy, "bound on the lever arm of each joint (n_a) [m]")
      .def_prop_ro("joint_names", &joint_names, "names of the joints as robot/joint, in the order of u")
      .def_prop_ro("object_names", &object_names, "names of the objects")
      .def_prop_ro(
          "bodies", [](const Model& model) { return list_of(model.bodies()); }, "all bodies")
      .def_prop_ro("links", &links_of, "links of all robots, parents first")
      .def_prop_ro(
          "geometries", [](const Model& model) { return list_of(model.geometries()); }, "all collision shapes")
      .def_prop_ro(
          "pairs", [](const Model& model) { return list_of(model.pairs()); }, "pairs of geometries that may touch")
      .def_prop_ro(
          "dofs", [](const Model& model) { return list_of(model.dofs()); }, "all velocity coordinates, objects first")
      .def_prop_ro(
          "objects", [](const Model& model) { return list_of(model.objects()); }, "all objects")
      .def_prop_ro(
          "notes", [](const Model& model) { return list_of(model.notes()); },
          "remarks, one sentence each: values that differ from the files, or that were chosen because the files do not give them")
      .def_prop_ro("planar_axis", &Model::planar_axis, "index of the axis normal to the plane in which everything moves, or None")
      .def("neutral", &Model::neutral,
           "Returns a configuration (n_q): every object at its placed frame, every joint as near to 0 as its limits allow.")
      .def("joint_index", &Model::joint_index, "name"_a, "Returns the index of a joint in u. Raises InvalidInput: no such joint.")
      .def("object_index", &Model::object_index, "name"_a,
           "Returns the index of an object in `objects`. Raises InvalidInput: no such object.")
      .def("retract", &retract, "q"_a, "delta"_a,
           R"(Moves a configuration: returns q ⊕ δ (n_q). Use it instead of q + δ, since q contains quaternions.

  q: configuration (n_q).
  delta: displacement δ in tangent coordinates (n_v) [m, rad].

    >>> model = st.load_task("allegro_ball").model
    >>> q = model.neutral()
    >>> delta = np.full(model.n_v, 0.1)
    >>> bool(np.allclose(model.local(q, model.retract(q, delta)), delta))
    True)")
      .def("local", &local, "q0"_a, "q1"_a, "Returns the displacement q1 ⊖ q0 from q0 to q1 in tangent coordinates (n_v) [m, rad].")
      .def("object_pose", &object_pose, "q"_a, "object"_a, "Returns the pose X_WB of a named object at q (n_q).")
      .def("object_poses", &object_poses, "q"_a, "object"_a,
           "Returns the poses X_WB of a named object at many configurations (N, n_q), as (N, 7): x y z [m], then the quaternion w x y z "
           "with "
           "w >= 0.")
      .def("calc_kinematics", &calc_kinematics, "q"_a,
           "Returns the Kinematics at q (n_q): poses of all bodies and axes of all coordinates.")
      .def("body_poses", &body_poses, "q"_a, "Returns the poses X_WB of all bodies at q (n_q): {body: pose}.",
           nb::sig("def body_poses(self, q: numpy.typing.ArrayLike) -> dict[str, Pose]"))
      .def("__repr__", [](const Model& model) {
        return fmt::format("<stiction.Model '{}': n_q {}, n_v {}, n_a {}, {} pairs>", model.scene().name, model.n_q(), model.n_v(),
                           model.n_a(), model.pairs().size());
      });
  def_pickle<Pose, RobotLink, world::Body, world::Geometry, world::Pair, world::Dof, world::ObjectInfo, world::Kinematics, world::Scene>();
  def_shared_copy<Model>();
}

}  // namespace stiction::python
