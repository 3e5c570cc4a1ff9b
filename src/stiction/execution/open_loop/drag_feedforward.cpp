#include "stiction/execution/open_loop/drag_feedforward.hpp"

#include <algorithm>

#include "stiction/world/object_space.hpp"
#include "stiction/world/scales.hpp"

namespace stiction::execution {
namespace {

using core::Status;

/// Stiffness of the stiff robot, as a multiple of the robot's stiffness.
constexpr double kStiffer = 1e3;
/// An object follows its planned step if it is off by at most this share of the step, in the norm of its damping, or by less than what counts as motion.
constexpr double kOff = 0.2;
/// Share of a motor's effort for planned torques and damping together.
constexpr double kEffortShare = 0.8;

std::shared_ptr<const world::Model> make_stiff(const world::Model& model) {
  world::Scene scene = model.scene();
  for (auto& robot : scene.robots) robot.stiffness.clear();
  for (int j = 0; j < model.n_a(); ++j) {
    const world::Dof& dof = model.dofs()[static_cast<std::size_t>(model.n_vu() + j)];
    const std::string joint = dof.name.substr(dof.name.find('/') + 1);
    scene.robots[static_cast<std::size_t>(dof.owner)].stiffness.emplace_back(joint, kStiffer * model.stiffness()[j]);
  }
  return world::Model::make(scene);
}

}  // namespace

Eigen::VectorXd calc_object_damping(const world::Model& model) {
  Eigen::VectorXd damping = Eigen::VectorXd::Zero(model.n_v());
  world::KinematicsWorkspace work(model);
  world::Kinematics kinematics;
  world::calc_kinematics(model, model.neutral(), work, kinematics);
  for (std::size_t i = 0; i < model.objects().size(); ++i) {
    if (model.scene().objects[i].joint == world::ObjectJoint::Free) continue;
    const auto& object = model.objects()[i];
    Eigen::MatrixXd M(object.n_v, object.n_v);
    world::calc_object_mass(model, kinematics, static_cast<int>(i), M);
    damping.segment(object.v_begin, object.n_v) = M.diagonal() / kRestTime;
    for (int v = object.v_begin; v < object.v_begin + object.n_v; ++v) damping[v] += model.dofs()[static_cast<std::size_t>(v)].damping;
  }
  return damping;
}

bool moves_nothing(const world::Model& model, const Eigen::VectorXd& delta) {
  const double least = world::share::kMotionless;
  return world::largest_share(model, delta.head(model.n_vu()), least * model.scales().robots().length, least) < 1;
}

DragFeedforward::DragFeedforward(std::shared_ptr<const world::Model> model)
    : model_(std::move(model)), damping_(calc_object_damping(*model_)), stiff_(acts() ? make_stiff(*model_) : model_), work_(stiff_) {}

double DragFeedforward::norm(const Eigen::VectorXd& delta) const { return delta.dot(damping_.cwiseProduct(delta)); }

bool DragFeedforward::follows(const Eigen::VectorXd& off, const Eigen::VectorXd& planned) const {
  return norm(off) <= kOff * kOff * norm(planned) || moves_nothing(*model_, off);
}

double DragFeedforward::speed_within_efforts(const Eigen::VectorXd& strain, const Eigen::VectorXd& lead) const {
  double speed = 1;
  for (int j = 0; j < model_->n_a(); ++j) {
    const double room = kEffortShare * model_->effort()[j] / model_->stiffness()[j] - std::abs(strain[j]);
    if (std::abs(lead[j]) * speed > room) speed = room / std::abs(lead[j]);
  }
  return speed;
}

DragFeedforward::Lead DragFeedforward::calc(const planning::Plan& plan, const Eigen::VectorXd& q, const Eigen::VectorXd& u,
                                            const Eigen::VectorXd& q_next, double duration, double unled) {
  Lead out{Eigen::VectorXd::Zero(model_->n_a()), 1};
  Eigen::VectorXd planned(model_->n_v());
  world::local(*model_, q, q_next, planned);
  if (moves_nothing(*model_, planned)) return out;
  const Eigen::VectorXd strain = u - q_next.tail(model_->n_a());
  const Eigen::VectorXd u_s = q_next.tail(model_->n_a()) + strain / kStiffer;
  dynamics::StepOptions options = plan.step;
  options.smoothing = dynamics::Exact{};
  options.with_A = options.with_B = options.effort_limits = false;
  // Keeps the regularisation of the plan, which the stiffness of the robot would otherwise raise.
  if (const auto* rule = std::get_if<dynamics::ByRule>(&options.regularisation))
    options.regularisation = dynamics::ByRule{rule->ratio / kStiffer};
  const auto step = [&](const Eigen::VectorXd* damping) {
    work_.forget();
    return dynamics::step(*stiff_, {q, u_s, nullptr, damping}, options, work_, result_) == Status::Solved;
  };
  // Without damping, the stiff robot may throw the object; the joints then follow from the plan.
  const Eigen::VectorXd free = step(nullptr) && follows(result_.delta - planned, planned) ? result_.delta : planned;
  for (double speed = 1; speed >= unled; speed /= 2) {
    const Eigen::VectorXd damping = speed * options.h / duration * damping_;
    if (!step(&damping) || !follows(result_.delta - planned, planned)) continue;
    out.strain = kStiffer * (free - result_.delta).tail(model_->n_a()) / speed;
    out.speed = std::clamp(speed_within_efforts(strain, out.strain), unled, speed);
    return out;
  }
  out.speed = unled;
  return out;
}

}  // namespace stiction::execution
