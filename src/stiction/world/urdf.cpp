#include "stiction/world/urdf.hpp"

#include <fmt/format.h>
#include <tinyxml2.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <optional>

#include "stiction/core/faults.hpp"
#include "stiction/core/sha256.hpp"
#include "stiction/world/encoding.hpp"
#include "stiction/world/shapes.hpp"
#include "stiction/world/simplify_hull.hpp"
#include "stiction/world/xml_reader.hpp"
#include "stiction/world/yaml.hpp"

namespace stiction::world {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

void add_once(std::vector<std::string>& names, const std::string& name) {
  if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
}

/// Where meshes are looked for and how they are taken, and the names of what was not taken as it is written.
struct Source {
  std::filesystem::path file;    ///< the URDF, as messages name it
  std::filesystem::path folder;  ///< that paths in it are relative to
  bool is_file = true;           ///< and no text in memory
  std::span<const std::filesystem::path> package_dirs;
  MeshOptions options;
  std::vector<std::string> filled{}, impossible{}, unlimited{}, reversed{};
  LinkHulls hulls{};

  std::vector<std::string> notes() const {
    std::vector<std::string> out;
    const auto add = [&](const std::vector<std::string>& names, std::string_view what) {
      if (!names.empty()) out.push_back(fmt::format("{}: {}", what, list_some(names)));
    };
    add(filled, "collision meshes that are not convex are their convex hulls");
    hulls.add_note(out);
    add(impossible, "inertias that no body can have are those of the collision geometry with the mass of the file, of links");
    add(unlimited, "no limits in the file, so that these joints have none");
    add(reversed, "a lower limit above the upper one, so that these joints have none");
    return out;
  }
};

std::vector<Shape> read_mesh(const XmlReader& reader, const XMLElement& element, Source& source) {
  const std::string uri = reader.required(element, "filename");
  const auto path = find_resource(uri, source.folder, source.package_dirs);
  if (path.empty())
    reader.fail(
        element, "mesh filename", fmt::format("'{}', which is nowhere", uri),
        fmt::format("a file that exists (package:// is looked for in package_dirs and above {})",
                    source.is_file ? "the URDF" : fmt::format("'{}', which paths in this text are relative to", source.folder.string())));
  const Eigen::Vector3d scale = reader.vector3(element, "scale", Eigen::Vector3d::Ones());
  std::vector<Shape> shapes;
  try {
    LoadedMesh mesh = load_mesh(path, scale, source.options);
    if (mesh.filled) add_once(source.filled, path.filename().string());
    for (const ConvexMesh& part : mesh.parts) shapes.emplace_back(Mesh{source.hulls.add(part, path.filename().string())});
  } catch (const core::InvalidInput& e) {
    throw core::InvalidInput(fmt::format("{}:{}: mesh: {}", source.file.string(), element.GetLineNum(), e.what()));
  }
  return shapes;
}

/// One shape, or the convex parts of a mesh.
std::vector<Shape> read_geometry(const XmlReader& reader, const XMLElement& collision, Source& source) {
  const XMLElement& geometry = reader.child(collision, "geometry");
  const XMLElement* shape = geometry.FirstChildElement();
  if (shape == nullptr) reader.fail(geometry, "geometry", "nothing", "sphere, box, cylinder, capsule or mesh");
  const std::string kind = shape->Name();
  if (kind == "sphere") return {Sphere{reader.positive(*shape, "radius")}};
  if (kind == "cylinder") return {Cylinder{reader.positive(*shape, "radius"), reader.positive(*shape, "length") / 2}};
  if (kind == "capsule") return {Capsule{reader.positive(*shape, "radius"), reader.positive(*shape, "length") / 2}};
  if (kind == "box") {
    const Eigen::Vector3d size = reader.vector3(*shape, "size");
    if (!(size.minCoeff() > 0)) reader.fail(*shape, "box size", fmt::format("{} {} {}", size[0], size[1], size[2]), "three numbers > 0");
    return {Box{size / 2}};
  }
  if (kind == "mesh") return read_mesh(reader, *shape, source);
  reader.fail(*shape, "geometry", fmt::format("'{}'", kind), "sphere, box, cylinder, capsule or mesh");
}

/// Moments that a body can have: ∫(y² + z²) dm ≤ ∫(z² + x²) dm + ∫(x² + y²) dm about every axis. Points and rods have moments of 0.
bool is_possible(const Eigen::Matrix3d& about_com) {
  const Eigen::Vector3d moments = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(about_com, Eigen::EigenvaluesOnly).eigenvalues();
  const double rounding = 1e-6 * moments.cwiseAbs().maxCoeff();  // files keep about six digits
  return moments[0] >= -rounding && moments[2] <= moments[0] + moments[1] + rounding;
}

/// Mass 0 states nothing: files write it for links that they have no figures for.
void read_inertia(const XmlReader& reader, const XMLElement& element, Source& source, RobotLink& link) {
  const XMLElement* inertial = element.FirstChildElement("inertial");
  if (inertial == nullptr) return;
  const XMLElement* mass = inertial->FirstChildElement("mass");
  const XMLElement* moments = inertial->FirstChildElement("inertia");
  if (mass == nullptr) return;
  const Pose X_LI = reader.origin(*inertial);
  BodyInertia out{.mass = reader.number(*mass, "value"), .p_BCom = X_LI.p};
  if (out.mass == 0) return;
  Eigen::Matrix3d about_com = Eigen::Matrix3d::Zero();
  if (moments != nullptr) {
    const double xx = reader.number(*moments, "ixx"), yy = reader.number(*moments, "iyy"), zz = reader.number(*moments, "izz");
    const double xy = reader.number(*moments, "ixy"), xz = reader.number(*moments, "ixz"), yz = reader.number(*moments, "iyz");
    about_com << xx, xy, xz, xy, yy, yz, xz, yz, zz;
  }
  if (out.mass < 0 || !is_possible(about_com)) {
    source.impossible.push_back(link.name);
    const BodyInertia shape = calc_inertia(link);
    if (!(out.mass > 0)) {
      link.inertia = shape;
      return;
    }
    link.inertia = shape.mass > 0 ? BodyInertia{out.mass, out.p_BCom, out.mass / shape.mass * shape.inertia}
                                  : BodyInertia{out.mass, out.p_BCom, Eigen::Matrix3d::Zero()};
    return;
  }
  out.inertia = X_LI.R * about_com * X_LI.R.transpose();
  link.inertia = out;
}

RobotLink read_link(const XmlReader& reader, const XMLElement& element, Source& source) {
  RobotLink link{.name = reader.required(element, "name"), .collisions = {}, .inertia = {}};
  int number = 0;
  for (const XMLElement* c = element.FirstChildElement("collision"); c != nullptr; c = c->NextSiblingElement("collision")) {
    const std::vector<Shape> shapes = read_geometry(reader, *c, source);
    const char* given = c->Attribute("name");
    const std::string name = given && *given ? std::string(given) : fmt::format("{}_{}", shape_name(shapes[0]), number);
    for (std::size_t k = 0; k < shapes.size(); ++k) {
      RobotCollision collision{.name = part_name(name, k, shapes.size()), .shape = shapes[k], .X_LG = reader.origin(*c)};
      // Exporters repeat names: the second "c" is "c_1", with the number of its element.
      const auto is_taken = [&] {
        return std::any_of(link.collisions.begin(), link.collisions.end(), [&](const auto& other) { return other.name == collision.name; });
      };
      for (int again = number; is_taken(); ++again) collision.name = fmt::format("{}_{}", part_name(name, k, shapes.size()), again);
      link.collisions.push_back(std::move(collision));
    }
    ++number;
  }
  read_inertia(reader, element, source, link);
  return link;
}

struct RawJoint {
  RobotJoint joint;
  std::string parent, child, leader;
};

/// The attribute `velocity`; infinite where there is none, or where it is 0.
double read_speed_limit(const XmlReader& reader, const XMLElement& joint, const XMLElement& limit) {
  const char* text = limit.Attribute("velocity");
  if (text == nullptr) return kInfinity;
  const auto speed = reader.try_number(text, true);
  if (!speed || *speed < 0)
    reader.fail(limit, reader.label(joint) + " velocity", fmt::format("'{}'", text), "a number > 0, or 0 where it is not known");
  return *speed > 0 ? *speed : kInfinity;
}

/// A joint whose file says neither end has none, as MuJoCo and Drake have it; of two ends the one that is left out is 0, as the format says.
void read_limits(const XmlReader& reader, const XMLElement& element, Source& source, RobotJoint& joint, bool continuous) {
  const XMLElement* limit = element.FirstChildElement("limit");
  if (limit != nullptr && limit->Attribute("effort") != nullptr) {
    const double effort = reader.number(*limit, "effort", true);
    if (effort < 0)
      reader.fail(*limit, reader.label(element) + " effort", fmt::format("{}", effort), "a number > 0, or 0 where it is not known");
    if (effort > 0 && std::isfinite(effort)) joint.effort = effort;
  }
  if (limit != nullptr) joint.speed_limit = read_speed_limit(reader, element, *limit);
  if (continuous || limit == nullptr || (limit->Attribute("lower") == nullptr && limit->Attribute("upper") == nullptr)) {
    if (!continuous) source.unlimited.push_back(joint.name);
    joint.lower = -kInfinity;
    joint.upper = kInfinity;
    return;
  }
  if (limit->Attribute("lower") != nullptr) joint.lower = reader.number(*limit, "lower", true);
  if (limit->Attribute("upper") != nullptr) joint.upper = reader.number(*limit, "upper", true);
  if (joint.lower <= joint.upper) return;
  source.reversed.push_back(joint.name);
  joint.lower = -kInfinity;
  joint.upper = kInfinity;
}

void read_dynamics(const XmlReader& reader, const XMLElement& element, RobotJoint& joint) {
  const XMLElement* dynamics = element.FirstChildElement("dynamics");
  if (dynamics == nullptr) return;
  const auto read = [&](const char* name, double& value) {
    if (dynamics->Attribute(name) == nullptr) return;
    value = reader.number(*dynamics, name);
    if (value < 0) reader.fail(*dynamics, fmt::format("{} {}", reader.label(element), name), fmt::format("{}", value), "a number ≥ 0");
  };
  read("friction", joint.friction);
  read("damping", joint.damping);
}

/// The first element of xacro; a URDF that xacro made has none, though it may still name its namespace.
const XMLElement* find_macro(const XMLElement& element) {
  if (std::string_view(element.Name()).starts_with("xacro:")) return &element;
  for (const XMLElement* child = element.FirstChildElement(); child != nullptr; child = child->NextSiblingElement()) {
    if (const XMLElement* found = find_macro(*child)) return found;
  }
  return nullptr;
}

RawJoint read_joint(const XmlReader& reader, const XMLElement& element, Source& source) {
  RawJoint raw;
  RobotJoint& joint = raw.joint;
  joint.name = reader.required(element, "name");
  const std::string what = reader.label(element);
  const std::string type = reader.required(element, "type");
  raw.parent = reader.required(reader.child(element, "parent"), "link");
  raw.child = reader.required(reader.child(element, "child"), "link");
  joint.X_PJ = reader.origin(element);
  if (type == "fixed") return raw;
  if (type != "revolute" && type != "continuous" && type != "prismatic") {
    reader.fail(element, what, fmt::format("type '{}'", type), "revolute, continuous, prismatic or fixed");
  }
  if (const XMLElement* mimic = element.FirstChildElement("mimic")) {
    raw.leader = reader.required(*mimic, "joint");
    if (mimic->Attribute("multiplier") != nullptr) joint.ratio = reader.number(*mimic, "multiplier");
    if (mimic->Attribute("offset") != nullptr) joint.offset = reader.number(*mimic, "offset");
  }
  joint.kind = type == "prismatic" ? RobotJoint::Kind::Prismatic : RobotJoint::Kind::Revolute;
  if (const XMLElement* axis = element.FirstChildElement("axis")) {
    joint.axis = reader.vector3(*axis, "xyz");
    if (!(joint.axis.norm() > 1e-6)) reader.fail(*axis, what, "axis 0 0 0", "an axis other than 0");
    joint.axis.normalize();
  }
  read_limits(reader, element, source, joint, type == "continuous");
  read_dynamics(reader, element, joint);
  return raw;
}

/// The element `robot` of a document. @throws core::InvalidInput: none, or an xacro file
const XMLElement& read_root(const XmlReader& reader, const tinyxml2::XMLDocument& document, const Source& source) {
  if (document.Error()) {
    throw core::InvalidInput(fmt::format("{}:{}: urdf: got malformed XML ({}), expected a URDF", source.file.string(),
                                         document.ErrorLineNum(), document.ErrorName()));
  }
  const XMLElement* root = document.RootElement();
  if (root == nullptr) throw core::InvalidInput(fmt::format("{}: urdf: got no element, expected 'robot'", source.file.string()));
  if (std::string_view(root->Name()) != "robot") reader.fail(*root, "root element", fmt::format("'{}'", root->Name()), "'robot'");
  if (const XMLElement* macro = find_macro(*root)) {
    const std::string call = source.is_file ? fmt::format(": xacro {} > robot.urdf", source.file.filename().string()) : "";
    reader.fail(*macro, "robot", fmt::format("'{}', so an xacro file", macro->Name()), "the URDF that xacro makes of it" + call);
  }
  return *root;
}

RobotTree read_tree(const std::string& text, Source source) {
  tinyxml2::XMLDocument document;
  document.Parse(text.data(), text.size());
  const XmlReader reader(source.file);
  const XMLElement* root = &read_root(reader, document, source);

  std::vector<RobotLink> links;
  const auto link_index = [&](const std::string& name) {
    const auto found = std::find_if(links.begin(), links.end(), [&](const RobotLink& link) { return link.name == name; });
    return found == links.end() ? -1 : static_cast<int>(found - links.begin());
  };
  core::Faults faults;
  for (const XMLElement* e = root->FirstChildElement("link"); e != nullptr; e = e->NextSiblingElement("link")) {
    const char* name = e->Attribute("name");
    RobotLink link{.name = name != nullptr ? name : "", .collisions = {}, .inertia = {}};
    faults.collect([&] {
      if (link_index(link.name) >= 0) reader.fail(*e, "link name", fmt::format("'{}' twice", link.name), "each name once");
      link = read_link(reader, *e, source);
    });
    links.push_back(std::move(link));
  }
  if (links.empty()) {
    const bool of_xacro = root->Attribute("xmlns:xacro") != nullptr;
    reader.fail(*root, "robot", of_xacro ? "no link, in a file of xacro" : "no link",
                of_xacro ? "the URDF that xacro makes of it" : "at least one");
  }
  std::vector<std::string> link_names;
  for (const auto& link : links) link_names.push_back(link.name);

  std::vector<RobotJoint> joints;
  std::vector<std::pair<const XMLElement*, std::string>> followers;  ///< and their leaders, which may stand below them
  std::vector<int> joint_of_child(links.size(), -1);
  const auto add_joint = [&](const XMLElement* e) {
    RawJoint raw = read_joint(reader, *e, source);
    for (const auto& other : joints) {
      if (other.name == raw.joint.name) reader.fail(*e, "joint name", fmt::format("'{}' twice", other.name), "each name once");
    }
    for (const auto& [name, index] : {std::pair{&raw.parent, &raw.joint.parent}, std::pair{&raw.child, &raw.joint.child}}) {
      *index = link_index(*name);
      if (*index < 0)
        reader.fail(*e, reader.label(*e), fmt::format("unknown link '{}'", *name), "one of " + list_with_hint(*name, link_names));
    }
    int& owner = joint_of_child[static_cast<std::size_t>(raw.joint.child)];
    if (owner >= 0) reader.fail(*e, reader.label(*e), fmt::format("link '{}' as child of a second joint", raw.child), "a tree");
    owner = static_cast<int>(joints.size());
    if (!raw.leader.empty()) followers.emplace_back(e, raw.leader);
    joints.push_back(std::move(raw.joint));
  };
  for (const XMLElement* e = root->FirstChildElement("joint"); e != nullptr; e = e->NextSiblingElement("joint"))
    faults.collect([&] { add_joint(e); });
  faults.raise();
  const auto roots = std::count(joint_of_child.begin(), joint_of_child.end(), -1);
  if (roots != 1) reader.fail(*root, "robot", fmt::format("{} links without a parent", roots), "one");

  RobotTree robot;
  robot.name = root->Attribute("name") ? root->Attribute("name") : "";
  robot.notes = source.notes();
  const std::function<int(int)> visit = [&](int link) {  // depth first, children in file order
    const int here = static_cast<int>(robot.links.size());
    robot.links.push_back(std::move(links[static_cast<std::size_t>(link)]));
    for (const auto& joint : joints) {
      if (joint.parent != link) continue;
      robot.joints.push_back(joint);
      const std::size_t at = robot.joints.size() - 1;
      robot.joints[at].parent = here;
      const int child = visit(joint.child);
      robot.joints[at].child = child;
    }
    return here;
  };
  visit(static_cast<int>(std::find(joint_of_child.begin(), joint_of_child.end(), -1) - joint_of_child.begin()));
  if (robot.links.size() != links.size()) reader.fail(*root, "robot", "links that form a circle", "a tree");
  for (const auto& [element, name] : followers) {
    const auto find = [&](std::string_view joint) {
      return std::find_if(robot.joints.begin(), robot.joints.end(), [&](const RobotJoint& j) { return j.name == joint; });
    };
    const auto leader = find(name);
    if (leader == robot.joints.end())
      reader.fail(*element, reader.label(*element), fmt::format("unknown joint '{}' to mimic", name), "a joint");
    find(element->Attribute("name"))->leader = static_cast<int>(leader - robot.joints.begin());
  }
  try {
    resolve_followers(robot);
  } catch (const core::InvalidInput& e) {
    throw core::InvalidInput(fmt::format("{}: {}", source.file.string(), e.what()));
  }
  return robot;
}

}  // namespace

RobotContents read_urdf(const std::filesystem::path& file, std::span<const std::filesystem::path> package_dirs,
                        const MeshOptions& mesh_options) {
  if (!std::filesystem::is_regular_file(file)) {
    throw core::InvalidInput(fmt::format("{}: urdf: got a file that does not exist, expected a URDF", file.string()));
  }
  RobotContents out;
  std::string bytes = read_bytes(file);
  out.sha256 = core::sha256(bytes);
  out.robot = read_tree(xml_text(std::move(bytes), file, "urdf"), {file, file.parent_path(), true, package_dirs, mesh_options});
  return out;
}

RobotContents read_urdf_text(const std::string& text, const std::filesystem::path& folder,
                             std::span<const std::filesystem::path> package_dirs, const MeshOptions& mesh_options) {
  RobotContents out;
  out.sha256 = core::sha256(text);
  out.robot = read_tree(text, {kTextName, folder, false, package_dirs, mesh_options});
  return out;
}

}  // namespace stiction::world
