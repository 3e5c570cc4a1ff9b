#pragma once

#include <filesystem>
#include <fstream>
#include <string>

#include "dynamics/systems.hpp"
#include "support/temporary_folder.hpp"

namespace stiction::dynamics::test {

/// A hand that carries a shape on three sliders and three hinges.
inline world::RobotSpec wrist(const std::string& name, const world::Shape& shape) {
  const std::filesystem::path& folder = stiction::test::folder_of_the_process();
  std::string geometry;
  const auto number = [](double x) { return std::to_string(x); };
  if (const auto* p = std::get_if<world::Sphere>(&shape)) geometry = "<sphere radius='" + number(p->radius) + "'/>";
  if (const auto* p = std::get_if<world::Box>(&shape)) {
    geometry = "<box size='" + number(2 * p->half_extents.x()) + " " + number(2 * p->half_extents.y()) + " " +
               number(2 * p->half_extents.z()) + "'/>";
  }
  const auto round = [&](const std::string& kind, double radius, double half) {
    geometry = "<" + kind + " radius='" + number(radius) + "' length='" + number(2 * half) + "'/>";
  };
  if (const auto* p = std::get_if<world::Capsule>(&shape)) round("capsule", p->radius, p->half_length);
  if (const auto* p = std::get_if<world::Cylinder>(&shape)) round("cylinder", p->radius, p->half_length);
  if (const auto* p = std::get_if<world::Mesh>(&shape)) {
    std::ofstream obj(folder / (name + ".obj"));
    for (Eigen::Index i = 0; i < p->mesh->vertices.cols(); ++i) obj << "v " << p->mesh->vertices.col(i).transpose() << "\n";
    for (Eigen::Index i = 0; i < p->mesh->triangles.cols(); ++i) obj << "f " << (p->mesh->triangles.col(i).array() + 1).transpose() << "\n";
    geometry = "<mesh filename='" + (folder / (name + ".obj")).string() + "'/>";
  }
  world::RobotSpec robot;
  robot.name = name;
  robot.urdf = folder / ("stiction_" + name + ".urdf");
  std::ofstream out(robot.urdf);
  out << "<robot name='" << name << "'><link name='l0'/>";
  const char* axes[] = {"1 0 0", "0 1 0", "0 0 1"};
  for (int j = 0; j < 6; ++j) {
    const std::string joint = "j" + std::to_string(j);
    out << "<link name='l" << j + 1 << "'>" << (j == 5 ? "<collision><geometry>" + geometry + "</geometry></collision>" : "") << "</link>"
        << "<joint name='" << joint << "' type='" << (j < 3 ? "prismatic" : "revolute") << "'><parent link='l" << j << "'/><child link='l"
        << j + 1 << "'/><axis xyz='" << axes[j % 3] << "'/><limit lower='-3' upper='3' effort='1' velocity='1'/></joint>";
    robot.stiffness.emplace_back(joint, j < 3 ? 200.0 : 5.0);
  }
  out << "</robot>";
  return robot;
}

inline world::ObjectSpec free_object(const world::Shape& shape) {
  world::ObjectSpec o;
  o.name = "object";
  o.mass = 0.5;
  o.inertia = Eigen::Vector3d(4e-4, 5e-4, 6e-4).asDiagonal();
  o.geometries = {{"g", shape, {}, 0.6}};
  return o;
}

}  // namespace stiction::dynamics::test
