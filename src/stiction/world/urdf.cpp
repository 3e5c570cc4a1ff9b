#include "stiction/world/urdf.hpp"

#include <fmt/format.h>
#include <tinyxml2.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <limits>
#include <map>
#include <memory>
#include <numbers>
#include <optional>
#include <utility>

#include "stiction/core/faults.hpp"
#include "stiction/core/sha256.hpp"
#include "stiction/world/encoding.hpp"
#include "stiction/world/shapes.hpp"
#include "stiction/world/simplify_hull.hpp"
#include "stiction/world/urdf_unread.hpp"
#include "stiction/world/urdf_visuals.hpp"
#include "stiction/world/xml_reader.hpp"
#include "stiction/world/yaml.hpp"

namespace stiction::world {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

void add_once(std::vector<std::string>& names, const std::string& name) {
  if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
}

/// Folders and options for reading meshes, and the names of elements that were not read as written.
struct Source {
  std::filesystem::path file;    ///< name of the URDF in messages
  std::filesystem::path folder;  ///< folder for relative paths
  bool is_file = true;           ///< false: a text in memory
  std::span<const std::filesystem::path> package_dirs;
  MeshOptions options;
  bool whole_scene = false;
  std::vector<std::string> filled{}, impossible{}, unlimited{}, reversed{}, empty{}, soft{}, far{};
  LinkHulls hulls{};
  std::map<std::pair<std::filesystem::path, std::array<double, 3>>, LoadedMesh> meshes{};  ///< by file and scale: links share them

  std::vector<std::string> notes() const {
    std::vector<std::string> out;
    const auto add = [&](const std::vector<std::string>& names, std::string_view what) {
      if (!names.empty()) out.push_back(fmt::format("{}: {}", what, list_some(names)));
    };
    add(filled, "collision meshes that are not convex are their convex hulls");
    hulls.add_note(out);
    add(impossible, "inertias that no body can have are those of the collision geometry with the mass of the file, of links");
    add(empty, "shapes without a volume touch nothing and are left out, of links");
    add(unlimited, "no limits in the file, so that these joints have none");
    add(reversed, "a lower limit above the upper one, so that these joints have none");
    add(far, "limits of more than three turns, which may be degrees where the format has radians, of joints");
    add(soft, "soft limits of <safety_controller> that are narrower than the limits are not read, of joints");
    return out;
  }
};

/// Returns the parts of a mesh file, which is read only once even if it is used several times. Each use has its own copy of the triangles, because
/// parts with the same copy count as one mesh in a link.
LoadedMesh find_mesh(const std::filesystem::path& file, const Eigen::Vector3d& scale, Source& source) {
  const auto key = std::pair{file, std::array{scale[0], scale[1], scale[2]}};
  const auto known = source.meshes.find(key);
  if (known == source.meshes.end()) {
    MeshOptions options = source.options;
    options.tolerance = kHullTolerance;
    return source.meshes.emplace(key, load_mesh(file, scale, options)).first->second;
  }
  LoadedMesh again = known->second;
  const auto surface = std::make_shared<const Eigen::Matrix3Xd>(*again.parts.at(0).surface);
  for (ConvexMesh& part : again.parts) part.surface = surface;
  return again;
}

std::vector<Shape> read_mesh(const XmlReader& reader, const XMLElement& element, Source& source) {
  const std::string uri = reader.required(element, "filename");
  const auto path = find_resource(uri, source.folder, source.package_dirs);
  if (path.empty())
    reader.fail(
        element, "mesh filename", fmt::format("'{}', which is nowhere", uri),
        fmt::format("a file that exists (package:// is looked for in package_dirs and above {})",
                    source.is_file ? "the URDF" : fmt::format("'{}', which paths in this text are relative to", source.folder.string())));
  const Eigen::Vector3d scale = reader.vector3(element, "scale", Eigen::Vector3d::Ones());
  if ((scale.array() == 0).any()) return {};
  std::vector<Shape> shapes;
  try {
    const LoadedMesh mesh = find_mesh(path, scale, source);
    if (mesh.filled) add_once(source.filled, path.filename().string());
    source.hulls.add(mesh.error, path.filename().string());
    for (const ConvexMesh& part : mesh.parts) shapes.emplace_back(Mesh{std::make_shared<const ConvexMesh>(part)});
  } catch (const core::InvalidInput& e) {
    throw core::InvalidInput(fmt::format("{}:{}: mesh: {}", source.file.string(), element.GetLineNum(), e.what()));
  }
  return shapes;
}

/// Reads a cylinder or a capsule. A capsule of length 0 is a sphere.
std::vector<Shape> read_round(const XmlReader& reader, const XMLElement& shape, bool capsule) {
  const double radius = reader.nonnegative(shape, "radius"), half_length = reader.nonnegative(shape, "length") / 2;
  if (radius == 0 || (half_length == 0 && !capsule)) return {};
  if (capsule && half_length == 0) return {Sphere{radius}};
  if (capsule) return {Capsule{radius, half_length}};
  return {Cylinder{radius, half_length}};
}

/// Reads one shape, the convex parts of a mesh, or nothing: exporters write a shape of size 0 for a link without a shape.
std::vector<Shape> read_geometry(const XmlReader& reader, const XMLElement& collision, Source& source) {
  const XMLElement& geometry = reader.child(collision, "geometry");
  const XMLElement* shape = geometry.FirstChildElement();
  if (shape == nullptr) reader.fail(geometry, "geometry", "nothing", "sphere, box, cylinder, capsule or mesh");
  const std::string kind = shape->Name();
  if (kind == "sphere") {
    const double radius = reader.nonnegative(*shape, "radius");
    return radius > 0 ? std::vector<Shape>{Sphere{radius}} : std::vector<Shape>{};
  }
  if (kind == "cylinder" || kind == "capsule") return read_round(reader, *shape, kind == "capsule");
  if (kind == "box") {
    const Eigen::Vector3d size = reader.vector3(*shape, "size");
    if (size.minCoeff() < 0)
      reader.fail(*shape, "box size", fmt::format("{} {} {}", size[0], size[1], size[2]), "three numbers > 0, or 0 for no shape");
    return size.minCoeff() > 0 ? std::vector<Shape>{Box{size / 2}} : std::vector<Shape>{};
  }
  if (kind == "mesh") return read_mesh(reader, *shape, source);
  reader.fail(*shape, "geometry", fmt::format("'{}'", kind), "sphere, box, cylinder, capsule or mesh");
}

/// True for moments that a body can have: ∫(y² + z²) dm ≤ ∫(z² + x²) dm + ∫(x² + y²) dm about every axis. Moments of 0 are those of points and rods.
bool is_possible(const Eigen::Matrix3d& about_com) {
  const Eigen::Vector3d moments = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(about_com, Eigen::EigenvaluesOnly).eigenvalues();
  const double rounding = 1e-6 * moments.cwiseAbs().maxCoeff();  // files keep about six digits
  return moments[0] >= -rounding && moments[2] <= moments[0] + moments[1] + rounding;
}

/// Reads the inertia of a link. A mass of 0 counts as not stated: files write it for links with unknown inertia.
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

/// Adds the shapes of a collision element to its link. @param number  number of the element in the link
void add_collision(const XmlReader& reader, const XMLElement& element, int number, Source& source, RobotLink& link) {
  const std::vector<Shape> shapes = read_geometry(reader, element, source);
  if (shapes.empty()) return add_once(source.empty, link.name);
  const char* given = element.Attribute("name");
  const std::string name = given && *given ? std::string(given) : fmt::format("{}_{}", shape_name(shapes[0]), number);
  for (std::size_t k = 0; k < shapes.size(); ++k) {
    RobotCollision collision{.name = part_name(name, k, shapes.size()), .shape = shapes[k], .X_LG = reader.origin(element)};
    // Exporters repeat names: the second "c" is "c_1", with the number of its element.
    const auto is_taken = [&] {
      return std::any_of(link.collisions.begin(), link.collisions.end(), [&](const auto& other) { return other.name == collision.name; });
    };
    for (int again = number; is_taken(); ++again) collision.name = fmt::format("{}_{}", part_name(name, k, shapes.size()), again);
    link.collisions.push_back(std::move(collision));
  }
}

RobotLink read_link(const XmlReader& reader, const XMLElement& element, Source& source) {
  RobotLink link{.name = reader.required(element, "name"), .collisions = {}, .inertia = {}};
  int number = 0;
  for (const XMLElement* c = element.FirstChildElement("collision"); c != nullptr; c = c->NextSiblingElement("collision"))
    add_collision(reader, *c, number++, source, link);
  link.only_seen = number == 0 && element.FirstChildElement("visual") != nullptr;
  read_inertia(reader, element, source, link);
  return link;
}

struct RawJoint {
  RobotJoint joint;
  std::string parent, child, leader;
};

/// Reads the attribute `velocity`; infinite if it is missing or 0.
double read_speed_limit(const XmlReader& reader, const XMLElement& joint, const XMLElement& limit) {
  const char* text = limit.Attribute("velocity");
  if (text == nullptr) return kInfinity;
  const auto speed = reader.try_number(text, true);
  if (!speed || *speed < 0)
    reader.fail(limit, reader.label(joint) + " velocity", fmt::format("'{}'", text), "a number > 0, or 0 where it is not known");
  return *speed > 0 && *speed <= core::kLargestNumber ? *speed : kInfinity;
}

/// Notes on limits that are probably not meant, or that the maker narrowed in another place.
void add_limit_notes(const XmlReader& reader, const XMLElement& element, Source& source, const RobotJoint& joint) {
  const double most = std::max(std::abs(joint.lower), std::abs(joint.upper));
  if (joint.kind == RobotJoint::Kind::Revolute && most > 6 * std::numbers::pi && most < kNoLimit) source.far.push_back(joint.name);
  const XMLElement* safety = element.FirstChildElement("safety_controller");
  if (safety == nullptr) return;
  const auto soft = [&](const char* name, double limit) {
    return safety->Attribute(name) != nullptr ? reader.number(*safety, name, true) : limit;
  };
  const double lower = soft("soft_lower_limit", joint.lower), upper = soft("soft_upper_limit", joint.upper);
  if (lower < upper && (lower > joint.lower || upper < joint.upper)) source.soft.push_back(joint.name);
}

/// Reads the limits of a joint. If the file states neither limit, the joint has none, as in MuJoCo and Drake. If one is missing, it is 0, as the
/// format defines.
void read_limits(const XmlReader& reader, const XMLElement& element, Source& source, RobotJoint& joint, bool continuous) {
  const XMLElement* limit = element.FirstChildElement("limit");
  if (limit != nullptr && limit->Attribute("effort") != nullptr) {
    const double effort = reader.number(*limit, "effort", true);
    if (effort < 0)
      reader.fail(*limit, reader.label(element) + " effort", fmt::format("{}", effort), "a number > 0, or 0 where it is not known");
    if (effort > 0 && effort <= core::kLargestNumber) joint.effort = effort;
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
  if (joint.lower <= joint.upper) return add_limit_notes(reader, element, source, joint);
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
  if (type == "floating" && source.whole_scene) {
    joint.floating = true;
    return raw;
  }
  if (type != "revolute" && type != "continuous" && type != "prismatic") {
    reader.fail(element, what, fmt::format("type '{}'", type),
                source.whole_scene ? "revolute, continuous, prismatic, floating or fixed" : "revolute, continuous, prismatic or fixed");
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
const XMLElement& read_root(const XmlReader& reader, const std::string& text, const Source& source, tinyxml2::XMLDocument& document) {
  const XMLElement* root = parse_xml(document, text, source.file, "urdf");
  if (root == nullptr) throw core::InvalidInput(fmt::format("{}: urdf: got no element, expected 'robot'", source.file.string()));
  if (const XMLElement* macro = find_macro(*root)) {
    const std::string call = source.is_file ? fmt::format(": xacro {} > robot.urdf", source.file.filename().string()) : "";
    reader.fail(*macro, "robot", fmt::format("'{}', so an xacro file", macro->Name()), "the URDF that xacro makes of it" + call);
  }
  return *root;
}

/// Reads the tree of links of one URDF. An error in one element does not hide errors in the next.
class TreeReader {
 public:
  TreeReader(const std::string& text, Source source)
      : source_(std::move(source)), reader_(source_.file), root_(read_root(reader_, text, source_, document_)) {}

  RobotTree read() {
    read_links();
    read_joints();
    faults_.raise();
    std::vector<std::string> roots;
    for (std::size_t link = 0; link < links_.size(); ++link) {
      if (joint_of_child_[link] < 0) roots.push_back(links_[link].name);
    }
    if (roots.empty()) reader_.fail(root_, "robot", "links that form a circle", "a tree");
    if (roots.size() > 1) reader_.fail(root_, "robot", fmt::format("{} links without a parent: {}", roots.size(), list_some(roots)), "one");
    RobotTree robot;
    robot.name = root_.Attribute("name") ? root_.Attribute("name") : "";
    robot.notes = source_.notes();
    if (const std::string unread = find_unread(root_); !unread.empty()) robot.notes.push_back(unread);
    const std::size_t count = links_.size();
    visit(static_cast<int>(std::find(joint_of_child_.begin(), joint_of_child_.end(), -1) - joint_of_child_.begin()), robot);
    read_urdf_visuals(reader_, root_, source_.folder, source_.package_dirs, robot);
    if (robot.links.size() != count) reader_.fail(root_, "robot", "links that form a circle", "a tree");
    find_leaders(robot);
    find_motors(robot);
    release_placeholder_limits(robot);
    try {
      resolve_followers(robot);
    } catch (const core::InvalidInput& e) {
      throw core::InvalidInput(fmt::format("{}: {}", source_.file.string(), e.what()));
    }
    return robot;
  }

 private:
  int link_index(const std::string& name) const {
    const auto found = std::find_if(links_.begin(), links_.end(), [&](const RobotLink& link) { return link.name == name; });
    return found == links_.end() ? -1 : static_cast<int>(found - links_.begin());
  }

  void read_links() {
    for (const XMLElement* e = root_.FirstChildElement("link"); e != nullptr; e = e->NextSiblingElement("link")) {
      const char* name = e->Attribute("name");
      RobotLink link{.name = name != nullptr ? name : "", .collisions = {}, .inertia = {}};
      faults_.collect([&] {
        if (link_index(link.name) >= 0) reader_.fail(*e, "link name", fmt::format("'{}' twice", link.name), "each name once");
        link = read_link(reader_, *e, source_);
      });
      links_.push_back(std::move(link));
    }
    joint_of_child_.assign(links_.size(), -1);
    if (!links_.empty()) return;
    const bool of_xacro = root_.Attribute("xmlns:xacro") != nullptr;
    reader_.fail(root_, "robot", of_xacro ? "no link, in a file of xacro" : "no link",
                 of_xacro ? "the URDF that xacro makes of it" : "at least one");
  }

  void read_joints() {
    std::vector<std::string> names;
    for (const auto& link : links_) names.push_back(link.name);
    for (const XMLElement* e = root_.FirstChildElement("joint"); e != nullptr; e = e->NextSiblingElement("joint"))
      faults_.collect([&] { add_joint(*e, names); });
  }

  void add_joint(const XMLElement& e, const std::vector<std::string>& link_names) {
    RawJoint raw = read_joint(reader_, e, source_);
    for (const auto& other : joints_) {
      if (other.name == raw.joint.name) reader_.fail(e, "joint name", fmt::format("'{}' twice", other.name), "each name once");
    }
    for (const auto& [name, index] : {std::pair{&raw.parent, &raw.joint.parent}, std::pair{&raw.child, &raw.joint.child}}) {
      *index = link_index(*name);
      if (*index < 0)
        reader_.fail(e, reader_.label(e), fmt::format("unknown link '{}'", *name), "one of " + list_with_hint(*name, link_names));
    }
    int& owner = joint_of_child_[static_cast<std::size_t>(raw.joint.child)];
    if (owner >= 0) reader_.fail(e, reader_.label(e), fmt::format("link '{}' as child of a second joint", raw.child), "a tree");
    owner = static_cast<int>(joints_.size());
    if (!raw.leader.empty()) followers_.emplace_back(&e, raw.leader);
    joints_.push_back(std::move(raw.joint));
  }

  /// Moves a link and all links that hang on it to the robot, depth first, children in the order of the file. @returns its index in the robot
  int visit(int link, RobotTree& robot) {
    const int here = static_cast<int>(robot.links.size());
    robot.links.push_back(std::move(links_[static_cast<std::size_t>(link)]));
    for (const auto& joint : joints_) {
      if (joint.parent != link) continue;
      robot.joints.push_back(joint);
      const std::size_t at = robot.joints.size() - 1;
      robot.joints[at].parent = here;
      const int child = visit(joint.child, robot);
      robot.joints[at].child = child;
    }
    return here;
  }

  void find_leaders(RobotTree& robot) const {
    const auto find = [&](std::string_view joint) {
      return std::find_if(robot.joints.begin(), robot.joints.end(), [&](const RobotJoint& j) { return j.name == joint; });
    };
    for (const auto& [element, name] : followers_) {
      const auto leader = find(name);
      if (leader == robot.joints.end())
        reader_.fail(*element, reader_.label(*element), fmt::format("unknown joint '{}' to mimic", name), "a joint");
      find(element->Attribute("name"))->leader = static_cast<int>(leader - robot.joints.begin());
    }
  }

  /// Marks the joints of transmissions and the joints with a command interface of ros2_control as actuated.
  void find_motors(RobotTree& robot) const {
    for (const char* list : {"transmission", "ros2_control"}) {
      for (const XMLElement* e = root_.FirstChildElement(list); e != nullptr; e = e->NextSiblingElement(list)) {
        for (const XMLElement* j = e->FirstChildElement("joint"); j != nullptr; j = j->NextSiblingElement("joint")) {
          const char* name = j->Attribute("name");
          const bool commanded = std::string_view(list) == "transmission" || j->FirstChildElement("command_interface") != nullptr;
          for (RobotJoint& joint : robot.joints) joint.actuated |= commanded && name != nullptr && joint.name == name;
        }
      }
    }
  }

  Source source_;
  XmlReader reader_;
  tinyxml2::XMLDocument document_{};
  const XMLElement& root_;
  core::Faults faults_{};
  std::vector<RobotLink> links_{};
  std::vector<RobotJoint> joints_{};
  std::vector<std::pair<const XMLElement*, std::string>>
      followers_{};                    ///< followers and the names of their leaders, which may come later in the file
  std::vector<int> joint_of_child_{};  ///< per link: index of its joint; −1 for the root
};

}  // namespace

RobotContents read_urdf(const std::filesystem::path& file, std::span<const std::filesystem::path> package_dirs,
                        const MeshOptions& mesh_options, bool whole_scene) {
  if (!std::filesystem::is_regular_file(file)) {
    throw core::InvalidInput(fmt::format("{}: urdf: got a file that does not exist, expected a URDF", file.string()));
  }
  RobotContents out;
  std::string bytes = read_bytes(file);
  out.sha256 = core::sha256(bytes);
  out.robot =
      TreeReader(xml_text(std::move(bytes), file, "urdf"), {file, file.parent_path(), true, package_dirs, mesh_options, whole_scene})
          .read();
  return out;
}

RobotContents read_urdf_text(const std::string& text, const std::filesystem::path& folder,
                             std::span<const std::filesystem::path> package_dirs, const MeshOptions& mesh_options, bool whole_scene) {
  RobotContents out;
  out.sha256 = core::sha256(text);
  out.robot = TreeReader(text, {kTextName, folder, false, package_dirs, mesh_options, whole_scene}).read();
  return out;
}

bool is_urdf(const std::filesystem::path& file) {
  std::ifstream text(file, std::ios::binary);
  const std::string root = find_root(text);
  return root.empty() ? file.extension() == ".urdf" : root == "robot";
}

}  // namespace stiction::world
