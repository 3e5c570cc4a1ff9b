#include "stiction/tasks/check_replay.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "stiction/world/scales.hpp"

namespace stiction::tasks {
namespace {

/// Allowed rotation of an object in a regrasp [rad].
constexpr double kRegraspTurn = 0.02;

}  // namespace

using core::Status;

Replay::Replay(const Task& task, const PlanFile& plan, const CheckOptions& options)
    : plan_(plan),
      limits_(options),
      model_(*task.model),
      step_work_(task.model),
      kinematics_work_(model_),
      contact_work_(model_),
      step_options_(plan.step) {
  step_options_.smoothing = dynamics::Exact{};
  step_options_.with_B = false;
  step_options_.warm_start = false;  // every step depends on its input alone
  const world::Scale& scale = model_.scales().object(task.problem.goal.object);
  brace_force_ = world::share::kBrace * scale.force;
  stays_ = {world::share::kClearance * scale.length, kRegraspTurn};
  goal_objects_ = goal_objects(model_, plan_);
  bystanders_ = task.problem.goal.bystanders;
  find_branches();
}

Status Replay::run(const core::RunControl& control, CheckReport& out) {
  start_penetration_ = deepest(normalised(model_, plan_.q_start)).first;
  Eigen::VectorXd q = normalised(model_, plan_.q_start);
  const Eigen::VectorXd *q_before = &plan_.q_start, *u_before = &plan_.u_start;
  for (std::size_t s = 0; s < plan_.segments.size(); ++s) {
    for (std::size_t k = 0; k < plan_.segments[s].knots.size(); ++k) {
      if (control.stop()) return control.status_when_stopped();
      const StoredKnot& knot = plan_.segments[s].knots[k];
      place_ = {static_cast<int>(s), static_cast<int>(k)};
      see_effort(knot);
      see_stored_press(knot);
      check_stored(*q_before, knot);
      half_step(0.5 * (*u_before + knot.u), q);
      half_step(knot.u, q);
      compare_with_path(q, knot.q);
      q_before = &knot.q;
      u_before = &knot.u;
      ++out.knots;
    }
    if (plan_.segments[s].kind == planning::SegmentKind::Regrasp && plan_.substep) check_regrasp(s);
  }
  end_ = goal_error(model_, plan_, q);
  out.steps = steps_;
  return Status::Solved;
}

void Replay::report(CheckReport& out) const {
  const auto plain = [](double x) {
    Worst worst;
    worst.value = x;
    worst.nan = std::isnan(x);
    return worst;
  };
  out.threshold_N = std::numeric_limits<double>::infinity();
  for (int i = 0; i < static_cast<int>(model_.pairs().size()); ++i) out.threshold_N = std::min(out.threshold_N, least_force(i));
  add(out, "goal_position", plain(end_.position), plan_.tol_position, "m");
  add(out, "goal_angle", plain(end_.angle), plan_.tol_angle, "rad");
  const std::string_view tolerance = "of 1 % of the object's size";
  add(out, "penetration", penetration_, start_penetration_ + limits_.penetration, std::string(tolerance));
  add(out, "replay_limits", joint_limits_, limits_.joint_limit, "rad or m");
  add(out, "force_cone", force_cone_, limits_.cone_excess, "of the normal force");
  add(out, "force_gap", force_gap_, limits_.force_gap, std::string(tolerance));
  add(out, "regrasp_contact", regrasp_contact_, 0.0, "rad or m");
  const bool bounded = step_options_.effort_limits && model_.effort().array().isFinite().any();
  add(out, "unstable_releases", unstable_releases_, std::nullopt, "");
  add(out, "effort", effort_, bounded ? std::optional(1 + effort_allowance()) : std::nullopt, "of the motor's");
  add(out, "max_force", max_force_, 1.0, "of what the weaker side bears");
  if (bystanders_ && std::isfinite(bystanders_->may_move)) add(out, "bystander_move", bystander_move_, bystanders_->may_move, "m");
  if (bystanders_ && std::isfinite(bystanders_->may_tip)) add(out, "bystander_tip", bystander_tip_, bystanders_->may_tip, "rad");
  add(out, "brace", brace_, std::nullopt, "of the force that ends a push");
  add(out, "failed_steps", plain(static_cast<double>(failed_steps_)), 0.0, "");
  add(out, "stored_position", stored_position_, limits_.stored_position, "of 0.1 % of the object's size");
  add(out, "stored_angle", stored_angle_, limits_.stored_angle, "rad");
  add(out, "stored_force", stored_force_, tells_forces() ? std::optional(limits_.stored_force) : std::nullopt, "of the largest force");
  add(out, "stored_contact", stored_contact_, limits_.display, "m");
  add(out, "path_position", path_position_, std::nullopt, "m");
  add(out, "path_angle", path_angle_, std::nullopt, "rad");
  add(out, "slide", slide_, std::nullopt, "m");
}

std::string Replay::here() const { return fmt::format("segment {}, knot {}", place_.segment, place_.knot); }
std::string Replay::here(std::string_view what) const { return fmt::format("{} at {}", what, here()); }

std::string Replay::pair_name(int pair) const {
  const auto& p = model_.pairs()[static_cast<std::size_t>(pair)];
  return model_.geometries()[static_cast<std::size_t>(p.geometry_a)].name + " – " +
         model_.geometries()[static_cast<std::size_t>(p.geometry_b)].name;
}

/// Names a pair with a gap or a depth, given in contact tolerances.
std::string Replay::pair_name(int pair, double share) const {
  return fmt::format("{}, {:.3g} mm", pair_name(pair), 1e3 * share * model_.scales().contact_tolerance(pair));
}

double Replay::friction(int pair) const { return step_options_.friction_scale * model_.pairs()[static_cast<std::size_t>(pair)].friction; }

/// Smallest force that is checked [N].
double Replay::least_force(int pair) const { return world::share::kForce * model_.scales().pair(pair).force; }

/// A search that ends without a plan may have had no time to compute the forces of its best path. The file then has none.
bool Replay::tells_forces() const {
  if (plan_.status == Status::Solved) return true;
  return std::ranges::any_of(plan_.segments, [](const auto& segment) {
    return std::ranges::any_of(segment.knots, [](const StoredKnot& knot) { return !knot.contacts.empty(); });
  });
}

void Replay::find_branches() {
  const auto body = [&](int geometry) -> const world::Body& {
    return model_.bodies()[static_cast<std::size_t>(model_.geometries()[static_cast<std::size_t>(geometry)].body)];
  };
  for (const auto& robot : model_.robots()) {
    for (const auto& chain : robot.chains) {
      Branch& branch = branches_.emplace_back();
      for (const int v : chain) branch.joints.push_back(model_.n_q() - model_.n_v() + v);
      const auto moves = [&](int geometry) {
        const auto& dofs = body(geometry).dofs;
        return std::any_of(dofs.begin(), dofs.end(), [&](int v) { return std::find(chain.begin(), chain.end(), v) != chain.end(); });
      };
      for (std::size_t i = 0; i < model_.pairs().size(); ++i) {
        const auto& pair = model_.pairs()[i];
        if (moves(pair.geometry_a) != moves(pair.geometry_b)) branch.pairs.push_back(static_cast<int>(i));
      }
    }
  }
}

/// Checks that a branch that goes elsewhere in a regrasp touches nothing between the first and the last moment at which it is free.
void Replay::check_regrasp(std::size_t segment) {
  const double free = world::share::kContact * model_.scales().robots().length;
  const double touching = 0.1 * free;     // a body that was pushed away keeps a gap of some micrometres
  constexpr double kGoesElsewhere = 0.1;  // [rad, L]: a finger that only stops pushing stays where it is
  const int first_joint = model_.n_q() - model_.n_a();
  const auto& knots = plan_.segments[segment].knots;
  std::vector<double> clear(knots.size(), std::numeric_limits<double>::infinity());  // smallest gap of the branches that go elsewhere
  bool any = false;
  for (const Branch& branch : branches_) {
    std::vector<double> gap(knots.size()), travel(knots.size(), 0.0);
    double all = 0, excursion = 0;
    for (std::size_t k = 1; k < knots.size(); ++k) {
      for (const int j : branch.joints) {
        travel[k] = std::max(travel[k], std::abs(knots[k].q[j] - knots[k - 1].q[j]));
        excursion = std::max(excursion, std::abs(knots[k].q[j] - knots[0].q[j]) / model_.scales().joint(j - first_joint));
      }
      all += travel[k];
    }
    if (excursion < kGoesElsewhere) continue;
    for (std::size_t k = 0; k < knots.size(); ++k) {
      world::calc_kinematics(model_, normalised(model_, knots[k].q), kinematics_work_, kinematics_);
      gap[k] = contact::calc_min_distance(model_, kinematics_, branch.pairs, -std::numeric_limits<double>::infinity(), contact_work_);
      clear[k] = std::min(clear[k], gap[k]);
    }
    any = true;
    const auto is_free = [free](double x) { return x >= free; };
    const auto first = std::find_if(gap.begin(), gap.end(), is_free);
    const auto last = std::find_if(gap.rbegin(), gap.rend(), is_free).base();
    double in_contact = first == gap.end() ? all : 0.0;
    for (auto it = first; it < last; ++it) in_contact += *it <= touching ? travel[static_cast<std::size_t>(it - gap.begin())] : 0.0;
    regrasp_contact_.see(in_contact,
                         [&] { return fmt::format("{} in segment {}", joint_name(branch.joints.front() - first_joint), segment); });
  }
  if (any) see_hold(segment, knots[static_cast<std::size_t>(std::max_element(clear.begin(), clear.end()) - clear.begin())]);
}

/// Deepest penetration at q, ≥ 0, in contact tolerances of its pair, and that pair (−1: none).
std::pair<double, int> Replay::deepest(const Eigen::VectorXd& q) {
  world::calc_kinematics(model_, q, kinematics_work_, kinematics_);
  contact::query(model_, kinematics_, {.margin = 0, .cutoff = 0}, contact_work_, contacts_);
  std::pair<double, int> worst{0, -1};
  for (const auto& contact : contacts_) {
    const double share = -contact.phi / model_.scales().contact_tolerance(contact.pair);
    if (share > worst.first) worst = {share, contact.pair};
  }
  return worst;
}

bool Replay::step(const Eigen::VectorXd& q, const Eigen::VectorXd& u) {
  ++steps_;
  const Status status = dynamics::step(model_, {q, u}, step_options_, step_work_, result_);
  if (status == Status::Solved) return true;
  ++failed_steps_;
  return false;
}

/// Makes and judges one step of the re-simulation from q; q becomes the state after it.
void Replay::half_step(const Eigen::VectorXd& u, Eigen::VectorXd& q) {
  if (!step(q, u)) return;
  q = result_.q_next;
  see_press();
  see_bystanders(q);
  for (int j = 0; j < model_.n_a(); ++j) {
    const double x = q.tail(model_.n_a())[j];
    joint_limits_.see(std::max(model_.lower()[j] - x, x - model_.upper()[j]), [&] { return here(joint_name(j)); });
  }
  const auto [depth, pair] = deepest(q);  // leaves the kinematics at q
  penetration_.see(depth, [&] { return here(pair_name(pair, depth)); });
  for (const auto& c : result_.contacts) {
    const Eigen::Vector3d force = c.lambda / step_options_.h;
    const double least = least_force(c.contact.pair);
    if (!c.active || force.norm() <= least) continue;
    force_cone_.see((force.tail<2>().norm() - friction(c.contact.pair) * force[0]) / std::max(std::abs(force[0]), least),
                    [&] { return here(pair_name(c.contact.pair)); });
    const double phi = contact::pair_distance(model_, kinematics_, c.contact.pair, contact_work_).phi;
    const double gap = phi / model_.scales().contact_tolerance(c.contact.pair);
    // An object that falls to rest at the start may turn too far in a step for the linear gap to be accurate. The plan begins after that.
    if (plan_.segments[static_cast<std::size_t>(place_.segment)].kind != planning::SegmentKind::Settle)
      force_gap_.see(gap, [&] { return here(fmt::format("{} ({:.3g} N)", pair_name(c.contact.pair, gap), force.norm())); });
    slide_.see(c.displacement.tail<2>().norm(), [&] { return here(pair_name(c.contact.pair)); });
  }
}

/// Compares the normal forces of the last step, summed over the contacts of a pair, with the force that the pair bears. Forces of the robot
/// on itself or on fixed bodies are also compared with the force at which the planner ends a push.
void Replay::see_press() {
  const auto is_object = [&](int geometry) {
    return model_.bodies()[static_cast<std::size_t>(model_.geometries()[static_cast<std::size_t>(geometry)].body)].kind ==
           world::BodyKind::Object;
  };
  for (const auto& first : result_.contacts) {
    if (!first.active) continue;
    const int pair = first.contact.pair;
    const world::Pair& of = model_.pairs()[static_cast<std::size_t>(pair)];
    double force = 0;
    for (const auto& c : result_.contacts) force += c.contact.pair == pair ? c.lambda[0] / step_options_.h : 0;
    max_force_.see(force / of.max_force, [&] { return here(fmt::format("{}, {:.3g} of {:.3g} N", pair_name(pair), force, of.max_force)); });
    if (is_object(of.geometry_a) || is_object(of.geometry_b)) continue;
    brace_.see(force / brace_force_, [&] { return here(fmt::format("{}, {:.3g} of {:.3g} N", pair_name(pair), force, brace_force_)); });
  }
}

/// Does the same for the forces in the file.
void Replay::see_stored_press(const StoredKnot& knot) {
  for (int i = 0; i < static_cast<int>(model_.pairs().size()); ++i) {
    const auto& pair = model_.pairs()[static_cast<std::size_t>(i)];
    if (!std::isfinite(pair.max_force)) continue;
    double force = 0;
    for (const auto& c : knot.contacts) force += c.a == pair.geometry_a && c.b == pair.geometry_b ? c.normal_W.dot(c.force_W) : 0;
    max_force_.see(force / pair.max_force,
                   [&] { return here(fmt::format("stored {}, {:.3g} of {:.3g} N", pair_name(i), force, pair.max_force)); });
  }
}

void Replay::see_bystanders(const Eigen::VectorXd& q) {
  if (!bystanders_) return;
  const Eigen::Vector3d up = -model_.scene().gravity.normalized();  // 0 without gravity
  for (const int o : bystanders_->objects) {
    const world::Pose stood = world::object_pose(model_, plan_.q_start, o), X = world::object_pose(model_, q, o);
    const Eigen::Vector3d tipped = X.R * stood.R.transpose() * up;
    const auto name = [&] { return here(model_.objects()[static_cast<std::size_t>(o)].name); };
    bystander_move_.see((X.p - stood.p).norm(), name);
    bystander_tip_.see(std::atan2(tipped.cross(up).norm(), tipped.dot(up)), name);
  }
}

/// Compares K_a|u − q| with the effort of the motor at a stored knot.
void Replay::see_effort(const StoredKnot& knot) {
  const Eigen::VectorXd share = model_.stiffness().cwiseProduct(knot.u - knot.q.tail(model_.n_a())).cwiseQuotient(model_.effort());
  for (int j = 0; j < model_.n_a(); ++j) effort_.see(std::abs(share[j]), [&] { return here(joint_name(j)); });
}

/// Allowed error of spring torques due to the tolerance of a step. The duality gap of its rows, rows · tol · 5 L F, is at least ½K_a δq² of
/// every spring ([cone], §5), which bounds the torque error K_a δq. Returns the largest one over the joints, relative to their efforts.
double Replay::effort_allowance() const {
  double work = 0;
  for (int i = 0; i < static_cast<int>(model_.pairs().size()); ++i) {
    const world::Scale& scale = model_.scales().pair(i);
    work = std::max(work, 5 * scale.length * scale.force);
  }
  std::size_t rows = 0;
  for (const auto& segment : plan_.segments) {
    for (const auto& knot : segment.knots) rows = std::max(rows, knot.contacts.size());
  }
  const double gap = step_options_.tol_complementarity * work * static_cast<double>(rows + static_cast<std::size_t>(model_.n_a()));
  return (2 * gap * model_.stiffness().array()).sqrt().cwiseQuotient(model_.effort().array()).maxCoeff();
}

/// Compares a stored knot with one full sub-step from the knot before it.
void Replay::check_stored(const Eigen::VectorXd& q_before, const StoredKnot& knot) {
  const Eigen::VectorXd q = normalised(model_, knot.q), q_from = normalised(model_, q_before);
  const auto [depth, pair] = deepest(q);
  penetration_.see(depth, [&] { return here("stored " + pair_name(pair, depth)); });
  if (!step(q_from, knot.u)) return;
  see_press();
  compare_states(result_.q_next, q, stored_position_, stored_angle_);
  check_stored_contacts(knot);
  check_stored_forces(q_from, knot);
}

/// Checks that every stored contact is a contact of the step, with the same shapes, point, normal and gap.
void Replay::check_stored_contacts(const StoredKnot& knot) {
  for (const auto& stored : knot.contacts) {
    double nearest = std::numeric_limits<double>::infinity();
    for (const auto& c : result_.contacts) {
      const auto& pair = model_.pairs()[static_cast<std::size_t>(c.contact.pair)];
      if (pair.geometry_a != stored.a || pair.geometry_b != stored.b) continue;
      nearest = std::min(
          nearest, std::max({(c.contact.p_WB - stored.point_W).lpNorm<Eigen::Infinity>(),
                             (c.contact.nhat_BA_W - stored.normal_W).lpNorm<Eigen::Infinity>(), std::abs(c.contact.phi - stored.gap)}));
    }
    stored_contact_.see(nearest, [&] { return here(model_.geometries()[static_cast<std::size_t>(stored.a)].name); });
  }
}

void Replay::compare_states(const Eigen::VectorXd& a, const Eigen::VectorXd& b, Worst& position, Worst& angle) {
  for (int i = 0; i < static_cast<int>(model_.objects().size()); ++i) {
    const world::Pose X_a = world::object_pose(model_, a, i);
    const world::Pose X_b = world::object_pose(model_, b, i);
    const auto name = [&] { return here(model_.objects()[static_cast<std::size_t>(i)].name); };
    position.see((X_a.p - X_b.p).norm() / (world::share::kMotionless * model_.scales().object(i).length), name);
    angle.see(angle_between(X_a.R, X_b.R), name);
  }
  for (int j = 0; j < model_.n_a(); ++j) {
    const bool revolute = model_.dofs()[static_cast<std::size_t>(model_.n_vu() + j)].kind == world::DofKind::Revolute;
    const double unit = revolute ? 1 : world::share::kMotionless * model_.scales().robots().length;
    (revolute ? angle : position).see(std::abs(a.tail(model_.n_a())[j] - b.tail(model_.n_a())[j]) / unit, [&] {
      return here(joint_name(j));
    });
  }
}

/// Redundant contacts may share a load in many ways, and a hinge takes every load that does not turn it. So the check compares sums over
/// contacts, along every coordinate that an object slides along or, if a joint holds it, turns about (as a force at the longest lever).
void Replay::check_stored_forces(const Eigen::VectorXd& q_before, const StoredKnot& knot) {
  struct Force {
    int a, b;  // geometries
    Eigen::Vector3d point_W, force_W, moment_W;
  };
  std::vector<Force> stored, simulated;
  for (const auto& c : knot.contacts) stored.push_back({c.a, c.b, c.point_W, c.force_W, c.moment * c.normal_W});
  for (const auto& c : result_.contacts) {
    const auto& pair = model_.pairs()[static_cast<std::size_t>(c.contact.pair)];
    const Eigen::Matrix<double, 6, 1> wrench = dynamics::calc_wrench(c, step_options_.h);
    const Eigen::Vector3d force_W = wrench.head<3>(), moment_W = wrench.tail<3>() - c.contact.p_WA.cross(force_W);
    simulated.push_back({pair.geometry_a, pair.geometry_b, c.contact.p_WB, force_W, moment_W});
  }
  double largest = 0;
  for (const auto* forces : {&stored, &simulated}) {
    for (const Force& f : *forces) largest = std::max(largest, f.force_W.norm());
  }
  world::calc_kinematics(model_, q_before, kinematics_work_, kinematics_);
  for (int i = 0; i < static_cast<int>(model_.objects().size()); ++i) {
    const auto& object = model_.objects()[static_cast<std::size_t>(i)];
    const world::Scale& scale = model_.scales().object(i);
    for (int v = object.v_begin; v < object.v_begin + object.n_v; ++v) {
      const bool revolute = model_.dofs()[static_cast<std::size_t>(v)].kind == world::DofKind::Revolute;
      if (revolute && object.n_v == 6) continue;
      const Eigen::Vector3d axis = kinematics_.axis_W.col(v), origin = kinematics_.origin_W.col(v);
      const auto direction = [&](const Eigen::Vector3d& point) { return revolute ? Eigen::Vector3d(axis.cross(point - origin)) : axis; };
      const auto moves = [&](int geometry) {
        const auto& dofs = model_.bodies()[static_cast<std::size_t>(model_.geometries()[static_cast<std::size_t>(geometry)].body)].dofs;
        return std::find(dofs.begin(), dofs.end(), v) != dofs.end();
      };
      double lever = revolute ? world::share::kContact * scale.length : 1.0;
      const auto along = [&](const std::vector<Force>& forces) {
        double sum = 0;
        for (const Force& f : forces) {
          const double sign = static_cast<double>(moves(f.a)) - static_cast<double>(moves(f.b));
          sum += sign * (direction(f.point_W).dot(f.force_W) + (revolute ? axis.dot(f.moment_W) : 0));
          if (sign != 0) lever = std::max(lever, direction(f.point_W).norm());
        }
        return sum;
      };
      const double difference = along(stored) - along(simulated);
      stored_force_.see(std::abs(difference) / lever / std::max(largest, scale.force), [&] { return here(object.name); });
    }
  }
}

void Replay::compare_with_path(const Eigen::VectorXd& q, const Eigen::VectorXd& q_stored) {
  for (const int object : goal_objects_) {
    const world::Pose X = world::object_pose(model_, q, object);
    const world::Pose X_stored = world::object_pose(model_, normalised(model_, q_stored), object);
    path_position_.see((X.p - X_stored.p).norm(), [&] { return here(); });
    path_angle_.see(angle_between(X.R, X_stored.R), [&] { return here(); });
  }
}

}  // namespace stiction::tasks
