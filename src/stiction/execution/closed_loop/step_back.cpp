#include "stiction/execution/closed_loop/step_back.hpp"

#include <algorithm>

#include "stiction/contact/free_path.hpp"
#include "stiction/world/ground.hpp"
#include "stiction/world/robot_chains.hpp"
#include "stiction/world/scales.hpp"

namespace stiction::execution {
namespace {

/// Distance of the step back: an object that leaned on the robot does not touch the robot when it stands again [L of the smallest object].
constexpr double kApart = 0.1;

/// True per object that a hinge or slide, or a plane without gravity in it, keeps where the robot leaves it. It may swing back, but it does not fall.
std::vector<char> find_kept(const world::Model& model, const world::Kinematics& kinematics) {
  Eigen::VectorXd gravity(model.n_vu());
  world::calc_gravity(model, kinematics, gravity);
  std::vector<char> kept(model.objects().size(), 0);
  for (std::size_t i = 0; i < kept.size(); ++i) {
    const world::ObjectInfo& object = model.objects()[i];
    kept[i] = object.n_v == 1 ? object.parent < 0 || kept[static_cast<std::size_t>(object.parent)]
                              : object.n_v == 3 && gravity.segment<3>(object.v_begin).isZero(0);
  }
  return kept;
}

void find_contacts(const world::Model& model, const Eigen::VectorXd& q, contact::GeometryWorkspace& work) {
  world::calc_kinematics(model, q, work.kinematics_work, work.kinematics);
  contact::query(model, work.kinematics, {}, work.contact_work, work.contacts);
}

/// Twice the tolerance of contacts, because an object that leans trembles.
bool is_touch(const world::Model& model, const contact::Contact& c) { return c.phi <= 2 * model.scales().contact_tolerance(c.pair); }

}  // namespace

bool touches_objects(const world::Model& model, const Eigen::VectorXd& q) {
  const world::RobotChains chains(model);
  contact::GeometryWorkspace work(model);
  find_contacts(model, q, work);
  return std::ranges::any_of(work.contacts, [&](const auto& c) {
    return chains.touches_object(c.pair) && chains.mask_of_pair(c.pair) != 0 && is_touch(model, c);
  });
}

std::vector<Eigen::VectorXd> find_step_back(const world::Model& model, Eigen::VectorXd q) {
  const world::RobotChains chains(model);
  contact::GeometryWorkspace work(model);
  find_contacts(model, q, work);
  std::vector<char> touched(model.objects().size(), 0), stands = find_kept(model, work.kinematics);
  world::ChainMask moving = 0;
  for (const auto& c : work.contacts) {
    if (!is_touch(model, c)) continue;
    if (const int object = world::object_on_ground(model, c.pair); object >= 0) stands[static_cast<std::size_t>(object)] = 1;
    if (!chains.touches_object(c.pair)) continue;
    moving |= chains.mask_of_pair(c.pair);
    const world::Pair& pair = model.pairs()[static_cast<std::size_t>(c.pair)];
    const auto& body = model.bodies()[static_cast<std::size_t>(model.geometries()[static_cast<std::size_t>(pair.geometry_a)].body)];
    touched[static_cast<std::size_t>(body.owner)] = 1;
  }
  std::vector<Eigen::VectorXd> path;
  const bool dropped = !std::ranges::equal(touched, stands, [](char robot, char ground) { return !robot || ground; });
  if (moving == 0 || dropped) return path;
  if (!contact::retreat(model, chains, moving, kApart * model.scales().robots().length, q, work, path)) path.clear();
  return path;
}

}  // namespace stiction::execution
