#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "stiction/core/invalid_input.hpp"
#include "stiction/simulation/plant_impl.hpp"
#include "stiction/world/call_mujoco.hpp"

namespace stiction::simulation {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using world::BodyInertia;
using world::ObjectJoint;
using world::Pose;

namespace {

// MuJoCo requires a mass above 0 for every moving link, even for links that have none in their file.
constexpr double kLeastMass = 1e-6;     // [kg]
constexpr double kLeastMoment = 1e-10;  // [kg m²]

/// Impedance of dry joint friction, the largest that MuJoCo allows. A sticking joint creeps at (1 − this) · load/inertia · time constant/2.
/// No friction cone couples it with other joints.
constexpr double kStiction = 0.9999;

std::size_t at(int i) { return static_cast<std::size_t>(i); }

void copy(const Vector3d& from, double* to) { std::copy_n(from.data(), 3, to); }

void set_pose(const Pose& X, double* position, double* quaternion) {
  const Eigen::Quaterniond q(X.R);
  copy(X.p, position);
  quaternion[0] = q.w(), quaternion[1] = q.x(), quaternion[2] = q.y(), quaternion[3] = q.z();
}

void set_inertia(const BodyInertia& inertia, double scale, mjsBody* body) {
  const Matrix3d I = scale * inertia.inertia;
  body->explicitinertial = 1;
  body->mass = scale * inertia.mass;
  copy(inertia.p_BCom, body->ipos);
  const double full[] = {I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2)};
  std::copy(std::begin(full), std::end(full), body->fullinertia);
}

/// Files often state wrong link inertias. An inertia that no rigid body can have is replaced by a possible one nearby. Robots are gravity
/// compensated.
BodyInertia make_possible(const BodyInertia& link) {
  const Eigen::SelfAdjointEigenSolver<Matrix3d> axes(0.5 * (link.inertia + link.inertia.transpose()));
  Vector3d moments = axes.eigenvalues().cwiseMax(kLeastMoment);
  if (moments[0] + moments[1] < moments[2]) moments.setConstant(moments.mean());
  return {std::max(link.mass, kLeastMass), link.p_BCom, axes.eigenvectors() * moments.asDiagonal() * axes.eigenvectors().transpose()};
}

/// Writes a scene into an mjSpec.
class SceneWriter {
 public:
  SceneWriter(const world::Model& model, const PlantOptions& options, mjSpec* spec) : model_(model), options_(options), spec_(spec) {
    bodies_.resize(model.bodies().size());
    const ContactOptions& c = options.contact;
    solref_[0] = c.time_constant, solref_[1] = 1;
    solref_friction_[0] = c.friction_time_constant, solref_friction_[1] = 1;
    // The same impedance at every depth, so that the formulas for penetration and creep hold at every load.
    const double solimp[] = {c.impedance, c.impedance, 1e-3, 0.5, 2};
    std::copy(std::begin(solimp), std::end(solimp), solimp_);
  }

  void write(const Eigen::VectorXd& armature) {
    write_options();
    mjsBody* world = mjs_findBody(spec_, "world");
    for (std::size_t i = 0; i < model_.objects().size(); ++i) write_object(world, static_cast<int>(i));
    for (const world::Link& link : model_.links()) write_link(world, link, armature);
    for (std::size_t i = 0; i < model_.bodies().size(); ++i) {
      if (model_.bodies()[i].kind != world::BodyKind::Fixed) continue;
      bodies_[i] = add_body(world, static_cast<int>(i));
    }
    write_fixed_poses();
    for (std::size_t i = 0; i < model_.geometries().size(); ++i) write_geometry(static_cast<int>(i));
    for (const world::Pair& pair : model_.pairs()) write_pair(pair);
    for (int j = 0; j < model_.n_a(); ++j) write_spring(j);
  }

 private:
  void write_options() {
    mjOption& o = spec_->option;
    o.timestep = options_.timestep;
    o.integrator = mjINT_IMPLICITFAST;
    o.cone = mjCONE_ELLIPTIC;
    o.solver = mjSOL_NEWTON;
    o.tolerance = 1e-12;  // relative to the cost: gives forces to a relative accuracy of 1e-6
    o.iterations = 200;
    o.impratio = options_.contact.friction_stiffening;
    o.noslip_iterations = options_.contact.noslip_iterations;
    copy(model_.scene().gravity, o.gravity);
    o.disableflags |= mjDSBL_AUTORESET;  // a broken state is reported, not replaced
    mjsCompiler& compiler = spec_->compiler;
    compiler.degree = 0;
    compiler.inertiafromgeom = mjINERTIAFROMGEOM_FALSE;
    compiler.usethread = 0;  // messages of other threads would be lost
    compiler.alignfree = 0;
    compiler.fusestatic = 0;
    compiler.discardvisual = 0;
  }

  mjsBody* add_body(mjsBody* parent, int index) {
    mjsBody* body = mjs_addBody(parent, nullptr);
    mjs_setName(body->element, model_.bodies()[at(index)].name.c_str());
    return body;
  }

  mjsJoint* add_joint(mjsBody* body, mjtJoint type, int dof, const Vector3d& axis) {
    mjsJoint* joint = mjs_addJoint(body, nullptr);
    joint->type = type;
    joint->align = mjALIGNFREE_FALSE;
    mjs_setName(joint->element, model_.dofs()[at(dof)].name.c_str());
    copy(axis, joint->axis);
    const world::Dof& limits = model_.dofs()[at(dof)];
    if (limits.owner_kind == world::BodyKind::Object || options_.joint_friction) {
      joint->frictionloss = limits.friction;
      joint->damping[0] = limits.damping;
      joint->stiffness[0] = limits.spring;
      joint->springref = limits.spring_rest;
      std::copy_n(solref_, mjNREF, joint->solref_friction);
      joint->solimp_friction[0] = joint->solimp_friction[1] = kStiction;
    }
    const bool limited = type != mjJNT_FREE && (std::isfinite(limits.lower) || std::isfinite(limits.upper));
    joint->limited = limited ? mjLIMITED_TRUE : mjLIMITED_FALSE;
    if (limited) {  // MuJoCo refuses a range of one point, and infinite bounds
      joint->range[0] = std::max(limits.lower, -1e9);
      joint->range[1] = std::min(std::max(limits.upper, limits.lower + 1e-9), 1e9);
      std::copy_n(solref_, mjNREF, joint->solref_limit);
      std::copy_n(solimp_, mjNIMP, joint->solimp_limit);
    }
    return joint;
  }

  void write_object(mjsBody* world, int index) {
    const world::ObjectSpec& spec = model_.scene().objects[at(index)];
    const world::ObjectInfo& info = model_.objects()[at(index)];
    mjsBody* body = add_body(info.parent >= 0 ? bodies_[at(model_.objects()[at(info.parent)].body)] : world, info.body);
    bodies_[at(info.body)] = body;
    set_inertia(model_.inertias()[at(info.body)], options_.mass_scale, body);
    body->gravcomp = 1 - spec.weight_share;
    if (spec.joint != ObjectJoint::Free) set_pose(spec.X_WP, body->pos, body->quat);
    const int v = info.v_begin;
    const auto planar = [&](int first, int second) {
      add_joint(body, mjJNT_SLIDE, v, Vector3d::Unit(first));
      add_joint(body, mjJNT_SLIDE, v + 1, Vector3d::Unit(second));
      add_joint(body, mjJNT_HINGE, v + 2, Vector3d::Unit(3 - first - second));
    };
    switch (spec.joint) {
      case ObjectJoint::Free:
        add_joint(body, mjJNT_FREE, v, Vector3d::UnitZ());
        break;
      case ObjectJoint::PlanarXY:
        planar(0, 1);
        break;
      case ObjectJoint::PlanarYZ:
        planar(1, 2);
        break;
      case ObjectJoint::PlanarXZ:
        planar(0, 2);
        break;
      case ObjectJoint::Hinge:
        add_joint(body, mjJNT_HINGE, v, spec.axis);
        break;
      case ObjectJoint::Slider:
        add_joint(body, mjJNT_SLIDE, v, spec.axis);
        break;
    }
  }

  void write_link(mjsBody* world, const world::Link& link, const Eigen::VectorXd& armature) {
    mjsBody* body = add_body(link.parent >= 0 ? bodies_[at(link.parent)] : world, link.body);
    bodies_[at(link.body)] = body;
    set_pose(link.X_PJ, body->pos, body->quat);
    body->gravcomp = 1;
    if (!model_.bodies()[at(link.body)].dofs.empty()) set_inertia(make_possible(model_.inertias()[at(link.body)]), 1, body);
    if (link.dof < 0) return;
    if (link.follower >= 0) {
      write_follower(body, link);
      return;
    }
    const bool turns = model_.dofs()[at(link.dof)].kind == world::DofKind::Revolute;
    mjsJoint* joint = add_joint(body, turns ? mjJNT_HINGE : mjJNT_SLIDE, link.dof, link.axis);
    joint->armature = armature[link.dof - model_.n_vu()];
  }

  /// Writes a follower as a joint that an equality constraint ties to its leader: y = offset + ratio·x.
  void write_follower(mjsBody* body, const world::Link& link) {
    const world::Follower& follower = model_.followers()[at(link.follower)];
    mjsJoint* joint = mjs_addJoint(body, nullptr);
    joint->type = follower.kind == world::DofKind::Revolute ? mjJNT_HINGE : mjJNT_SLIDE;
    mjs_setName(joint->element, follower.name.c_str());
    copy(link.axis, joint->axis);
    joint->limited = mjLIMITED_FALSE;
    joint->armature = options_.armature;
    mjsEquality* tie = mjs_addEquality(spec_, nullptr);
    tie->type = mjEQ_JOINT;
    tie->objtype = mjOBJ_JOINT;
    mjs_setString(tie->name1, follower.name.c_str());
    mjs_setString(tie->name2, model_.dofs()[at(follower.dof)].name.c_str());
    tie->data[0] = follower.offset, tie->data[1] = follower.ratio;
    std::copy_n(solref_, mjNREF, tie->solref);
    std::copy_n(solimp_, mjNIMP, tie->solimp);
  }

  void write_fixed_poses() {
    std::size_t next = 0;
    for (std::size_t i = 0; i < model_.bodies().size(); ++i) {
      if (model_.bodies()[i].kind != world::BodyKind::Fixed) continue;
      set_pose(model_.scene().fixed[next++].X_WB, bodies_[i]->pos, bodies_[i]->quat);
    }
  }

  void write_geometry(int index) {
    const world::Geometry& geometry = model_.geometries()[at(index)];
    mjsGeom* geom = mjs_addGeom(bodies_[at(geometry.body)], nullptr);
    mjs_setName(geom->element, geometry.name.c_str());
    set_pose(geometry.X_BG, geom->pos, geom->quat);
    geom->contype = geom->conaffinity = 0;  // contacts only between the pairs below
    const auto size = [&](mjtGeom type, double a, double b = 0, double c = 0) {
      geom->type = type;
      geom->size[0] = a, geom->size[1] = b, geom->size[2] = c;
    };
    if (const auto* sphere = std::get_if<world::Sphere>(&geometry.shape)) {
      size(mjGEOM_SPHERE, sphere->radius);
    } else if (const auto* capsule = std::get_if<world::Capsule>(&geometry.shape)) {
      size(mjGEOM_CAPSULE, capsule->radius, capsule->half_length);
    } else if (const auto* box = std::get_if<world::Box>(&geometry.shape)) {
      size(mjGEOM_BOX, box->half_extents[0], box->half_extents[1], box->half_extents[2]);
    } else if (const auto* cylinder = std::get_if<world::Cylinder>(&geometry.shape)) {
      size(mjGEOM_CYLINDER, cylinder->radius, cylinder->half_length);
    } else if (std::holds_alternative<world::HalfSpace>(geometry.shape)) {
      size(mjGEOM_PLANE, 0, 0, 1);
    } else {
      write_mesh(geometry, *std::get<world::Mesh>(geometry.shape).mesh, geom);
    }
  }

  void write_mesh(const world::Geometry& geometry, const world::ConvexMesh& shape, mjsGeom* geom) {
    mjsMesh* mesh = mjs_addMesh(spec_, nullptr);
    mjs_setName(mesh->element, geometry.name.c_str());
    const Eigen::Matrix3Xf vertices = shape.vertices.cast<float>();
    mjs_setFloat(mesh->uservert, vertices.data(), static_cast<int>(vertices.size()));
    mjs_setInt(mesh->userface, shape.triangles.data(), static_cast<int>(shape.triangles.size()));
    geom->type = mjGEOM_MESH;
    mjs_setString(geom->meshname, geometry.name.c_str());
  }

  void write_pair(const world::Pair& entry) {
    mjsPair* pair = mjs_addPair(spec_, nullptr);
    mjs_setString(pair->geomname1, model_.geometries()[at(entry.geometry_a)].name.c_str());
    mjs_setString(pair->geomname2, model_.geometries()[at(entry.geometry_b)].name.c_str());
    // The moment about the normal is the friction of a small patch, so it vanishes with the sliding friction. Rolling friction dissipates
    // energy inside the bodies.
    const double mu = entry.friction * options_.contact.friction_scale;
    const double torsional = mu > 0 ? entry.torsional * options_.contact.friction_scale : 0, rolling = mu > 0 ? entry.rolling : 0;
    pair->condim = rolling > 0 ? 6 : torsional > 0 ? 4 : mu > 0 ? 3 : 1;
    pair->friction[0] = pair->friction[1] = mu;
    pair->friction[2] = torsional;
    pair->friction[3] = pair->friction[4] = rolling;
    std::copy_n(solref_, mjNREF, pair->solref);
    std::copy_n(solref_friction_, mjNREF, pair->solreffriction);
    std::copy_n(solimp_, mjNIMP, pair->solimp);
    if (on_ground(entry)) {
      pair->solref[0] *= options_.contact.ground_softness;
      pair->solreffriction[0] *= options_.contact.ground_softness;
    }
    pair->margin = pair->gap = pair->adhesion = 0;
  }

  /// Whether the pair is an object on fixed geometry.
  bool on_ground(const world::Pair& pair) const {
    const auto kind = [&](int geometry) { return model_.bodies()[at(model_.geometries()[at(geometry)].body)].kind; };
    return kind(pair.geometry_a) == world::BodyKind::Object && kind(pair.geometry_b) == world::BodyKind::Fixed;
  }

  /// Writes an undamped joint spring. Plant::make sets the damping, which follows from the inertia of the compiled scene.
  void write_spring(int joint) {
    const std::string& name = model_.dofs()[at(model_.n_vu() + joint)].name;
    mjsActuator* spring = mjs_addActuator(spec_, nullptr);
    mjs_setName(spring->element, name.c_str());
    spring->trntype = mjTRN_JOINT;
    mjs_setString(spring->target, name.c_str());
    spring->ctrllimited = mjLIMITED_FALSE;
    const double effort = model_.effort()[joint];
    const bool limited = options_.effort_limits && std::isfinite(effort);
    spring->forcelimited = limited ? mjLIMITED_TRUE : mjLIMITED_FALSE;
    if (limited) spring->forcerange[0] = -effort, spring->forcerange[1] = effort;
    mjs_setToPosition(spring, model_.stiffness()[joint], nullptr, nullptr, nullptr, 0);
  }

  const world::Model& model_;
  const PlantOptions& options_;
  mjSpec* spec_;
  std::vector<mjsBody*> bodies_;  ///< per body of the model
  mjtNum solref_[mjNREF] = {}, solref_friction_[mjNREF] = {};
  mjtNum solimp_[mjNIMP] = {};
};

}  // namespace

std::unique_ptr<mjModel, DeleteMujoco> compile_scene(const world::Model& model, const PlantOptions& options,
                                                     const Eigen::VectorXd& armature) {
  const std::unique_ptr<mjSpec, DeleteMujoco> spec(mj_makeSpec());
  SceneWriter(model, options, spec.get()).write(armature);
  mjModel* compiled = nullptr;
  const auto report = world::call_mujoco([&] { compiled = mj_compile(spec.get(), nullptr); });
  if (compiled == nullptr) {
    const char* error = mjs_getError(spec.get());
    core::throw_invalid("scene",
                        fmt::format("'{}'", report.failed ? report.error
                                            : error       ? error
                                                          : "no reason"),
                        "a scene that MuJoCo compiles");
  }
  return std::unique_ptr<mjModel, DeleteMujoco>(compiled);
}

}  // namespace stiction::simulation
