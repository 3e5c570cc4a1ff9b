#include "stiction/execution/touch/touch_scenario.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>

#include "stiction/contact/contact.hpp"
#include "stiction/contact/contact_sampler.hpp"
#include "stiction/core/invalid_input.hpp"
#include "stiction/core/random.hpp"
#include "stiction/world/robot_chains.hpp"

namespace stiction::execution {

namespace {

constexpr std::uint64_t kPlaceStream = 1;  ///< stream of random numbers; the observer uses stream 0 of the same seed

/// Name of the first body that the arm touches at q (n_q); empty: none.
std::string find_touched(const world::Model& model, const Eigen::VectorXd& q) {
  contact::GeometryWorkspace work(model);
  world::calc_kinematics(model, q, work.kinematics_work, work.kinematics);
  const world::RobotChains chains(model);
  chains.pairs_of(chains.all(), work.pairs);
  contact::query_pairs(model, work.kinematics, work.pairs, 0, work.contact_work, work.contacts);
  if (work.contacts.empty()) return "";
  const world::Pair& pair = model.pairs()[static_cast<std::size_t>(work.contacts.front().pair)];
  return model.geometries()[static_cast<std::size_t>(pair.geometry_b)].name;
}

}  // namespace

std::shared_ptr<const world::Model> make_world(const TouchScenario& scenario, std::uint64_t seed) {
  world::Scene scene = scenario.arm.model->scene();
  core::Random random(seed, kPlaceStream);
  for (const UnknownBody& unknown : scenario.unknown) {
    world::FixedSpec body = unknown.body;
    for (int i = 0; i < 3; ++i) body.X_WB.p[i] += unknown.position_spread[i] * random.uniform(-1, 1);
    const double yaw = unknown.yaw_spread * random.uniform(-1, 1);
    body.X_WB.R = Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix() * body.X_WB.R;
    scene.fixed.push_back(std::move(body));
  }
  for (const MisplacedBody& misplaced : scenario.misplaced)
    for (world::FixedSpec& body : scene.fixed)
      if (body.name == misplaced.name)
        for (int i = 0; i < 3; ++i) body.X_WB.p[i] += misplaced.position_spread[i] * random.uniform(-1, 1);
  auto model = world::Model::make(scene);
  Eigen::VectorXd q = calc_start(scenario.arm), q_u = q.head(model->n_qu());
  move_objects(scenario, *scenario.arm.model, *model, q_u);
  q.head(q_u.size()) = q_u;
  if (const std::string touched = find_touched(*model, q); !touched.empty())
    core::throw_invalid(scenario.arm.file.empty() ? "start" : fmt::format("{}: start", scenario.arm.file.string()),
                        fmt::format("a posture that touches '{}' (seed {})", touched, seed), "one that touches nothing");
  return model;
}

void move_objects(const TouchScenario& scenario, const world::Model& from, const world::Model& to, Eigen::VectorXd& q_u) {
  for (const MisplacedBody& misplaced : scenario.misplaced) {
    const auto place = [&](const world::Model& model) {
      return std::ranges::find(model.scene().fixed, misplaced.name, &world::FixedSpec::name)->X_WB.p;
    };
    const Eigen::Vector3d shift = place(to) - place(from);
    for (const int object : misplaced.objects) q_u.segment<3>(from.objects()[static_cast<std::size_t>(object)].q_begin) += shift;
  }
}

}  // namespace stiction::execution
