#include "stiction/world/model.hpp"

#include <fmt/format.h>

#include "stiction/core/invalid_input.hpp"
#include "stiction/world/model_parts.hpp"
#include "stiction/world/read.hpp"

namespace stiction::world {
namespace {

int find_name(std::string_view what, std::string_view name, const std::vector<std::string>& full) {
  int found = -1;
  for (std::size_t i = 0; i < full.size(); ++i) {
    if (full[i] == name) return static_cast<int>(i);
    const auto slash = full[i].find('/');
    if (slash == std::string::npos || full[i].substr(slash + 1) != name) continue;
    if (found >= 0)
      core::throw_invalid(what, fmt::format("'{}', which several robots have", name),
                          fmt::format("'{}' or '{}'", full[at(found)], full[i]));
    found = static_cast<int>(i);
  }
  if (found < 0)
    core::throw_invalid(what, fmt::format("unknown name '{}'", name),
                        full.empty() ? "none (there are none)" : "one of " + list_with_hint(name, full));
  return found;
}

}  // namespace

Model::Model(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Model::~Model() = default;

std::shared_ptr<const Model> Model::make(const Scene& scene) {
  std::shared_ptr<Model> model(new Model(build_model(scene)));
  model->impl_->scales.emplace(*model);
  return model;
}

const Scene& Model::scene() const { return impl_->scene; }
int Model::n_q() const { return impl_->n_q; }
int Model::n_v() const { return impl_->n_v; }
int Model::n_vu() const { return impl_->n_vu; }
int Model::n_qu() const { return impl_->n_qu; }
int Model::n_a() const { return impl_->n_a; }
std::span<const Body> Model::bodies() const { return impl_->bodies; }
std::span<const Geometry> Model::geometries() const { return impl_->geometries; }
std::span<const Pair> Model::pairs() const { return impl_->pairs; }
std::span<const Dof> Model::dofs() const { return impl_->dofs; }
std::span<const Follower> Model::followers() const { return impl_->followers; }
std::span<const ObjectInfo> Model::objects() const { return impl_->objects; }
std::span<const RobotInfo> Model::robots() const { return impl_->robots; }
std::span<const Link> Model::links() const { return impl_->links; }
std::span<const std::string> Model::notes() const { return impl_->notes; }
std::span<const BodyInertia> Model::inertias() const { return impl_->inertias; }
const std::vector<std::vector<int>>& Model::supports() const { return impl_->supports; }
std::optional<int> Model::planar_axis() const { return impl_->planar_axis; }
const Eigen::VectorXd& Model::stiffness() const { return impl_->stiffness; }
const Eigen::VectorXd& Model::effort() const { return impl_->effort; }
const Eigen::VectorXd& Model::speed_limit() const { return impl_->speed_limit; }
const Eigen::VectorXd& Model::lower() const { return impl_->lower; }
const Eigen::VectorXd& Model::upper() const { return impl_->upper; }
const Eigen::VectorXd& Model::command_lower() const { return impl_->command_lower; }
const Eigen::VectorXd& Model::command_upper() const { return impl_->command_upper; }
const Eigen::VectorXd& Model::reach() const { return impl_->reach; }
const Scales& Model::scales() const { return *impl_->scales; }
Eigen::VectorXd Model::neutral() const { return impl_->neutral; }

std::span<const JointMotor> joint_motors(const Model& model) { return model.impl().motors; }

int Model::joint_index(std::string_view name) const {
  std::vector<std::string> names;
  for (int i = impl_->n_vu; i < impl_->n_v; ++i) names.push_back(impl_->dofs[at(i)].name);
  return find_name("joint", name, names);
}

int Model::object_index(std::string_view name) const {
  std::vector<std::string> names;
  for (const auto& object : impl_->objects) names.push_back(object.name);
  return find_name("object", name, names);
}

}  // namespace stiction::world
