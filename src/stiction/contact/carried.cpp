#include "stiction/contact/carried.hpp"

#include <algorithm>

#include "stiction/world/robot_chains.hpp"
#include "stiction/world/scales.hpp"

namespace stiction::contact {

using world::Model;

Carried::Carried(const Model& model) : model_(model) {
  const world::RobotChains chains(model);
  world::Kinematics kinematics;
  world::KinematicsWorkspace work(model);
  world::calc_kinematics(model, model.neutral(), work, kinematics);
  Eigen::VectorXd weight(model.n_vu());
  world::calc_gravity(model, kinematics, weight);
  const auto is_of_robot = [&](int geometry) {
    return model.bodies()[static_cast<std::size_t>(model.geometries()[static_cast<std::size_t>(geometry)].body)].kind ==
           world::BodyKind::Robot;
  };
  for (std::size_t o = 0; o < model.objects().size(); ++o) {
    const world::ObjectJoint joint = model.scene().objects[o].joint;
    const world::ObjectInfo& object = model.objects()[o];
    if (joint == world::ObjectJoint::Hinge || joint == world::ObjectJoint::Slider || weight.segment(object.v_begin, object.n_v).isZero(0))
      continue;
    std::vector<int>& pairs = supports_.emplace_back();
    for (int i = 0; i < static_cast<int>(model.pairs().size()); ++i) {
      const world::Pair& pair = model.pairs()[static_cast<std::size_t>(i)];
      const auto is_of_object = [&](int geometry) { return model.geometries()[static_cast<std::size_t>(geometry)].body == object.body; };
      if (chains.mask_of_pair(i) == 0 && (is_of_object(pair.geometry_a) || is_of_object(pair.geometry_b))) pairs.push_back(i);
    }
    for (const int i : pairs) {
      const world::Pair& pair = model.pairs()[static_cast<std::size_t>(i)];
      if (is_of_robot(pair.geometry_a) || is_of_robot(pair.geometry_b)) palms_.push_back(i);
    }
  }
}

bool Carried::any(const world::Kinematics& kinematics, Workspace& work) const {
  return std::ranges::any_of(supports_, [&](const std::vector<int>& pairs) {
    return std::ranges::none_of(pairs, [&](int pair) { return near(pair, kinematics, work); });
  });
}

bool Carried::lies_in_hand(const world::Kinematics& kinematics, Workspace& work) const {
  return std::ranges::any_of(palms_, [&](int pair) { return near(pair, kinematics, work); });
}

bool Carried::near(int pair, const world::Kinematics& kinematics, Workspace& work) const {
  return any_nearer(model_, kinematics, std::span(&pair, 1), model_.scales().contact_tolerance(pair), work);
}

}  // namespace stiction::contact
