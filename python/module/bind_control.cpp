#include <fmt/format.h>

#include "bindings.hpp"
#include "pickles.hpp"
#include "stiction/control/controller.hpp"

namespace stiction::python {
namespace {

using control::ControllerOptions;
using control::ForceDampingOptions;
using control::Law;
using control::TrackingCost;

/// As in C++, with the link by its name.
struct ContactForce {
  std::string body;
  control::ContactForce values;
};

struct ToolReference {
  std::string body;
  world::Pose X_BT, X_WT;
};

struct ControllerState {
  double time = 0;
  Eigen::VectorXd q, q_ref;
  std::vector<ContactForce> contacts;
  std::optional<ToolReference> tool;
};

struct ControllerCommand {
  control::ControllerCommand values;
  std::vector<ContactForce> taken;
  bool has_forces = false;  ///< predicted
};

struct ContactController {
  ModelPtr model;
  control::ContactController controller;
};

std::shared_ptr<ContactController> make_controller(const ModelPtr& model, Law law, TrackingCost cost, double lambda_max,
                                                   std::optional<double> force_threshold, double force_time_constant, double release_time,
                                                   int max_contacts, double revolute_speed, double prismatic_speed,
                                                   const std::optional<Vector>& torque, double posture_time_constant, double tool_length,
                                                   const ForceDampingOptions& damping, Flag unilateral, double contact_compliance,
                                                   double posture_weight, double epsilon, double least_lever, double force_priority,
                                                   double unilateral_priority) {
  core::require_positive("lambda_max", lambda_max);
  ControllerOptions options;
  options.law = law;
  options.qp.cost = cost;
  options.qp.epsilon = epsilon;
  options.qp.posture_weight = posture_weight;
  options.qp.contact_compliance = contact_compliance;
  options.qp.least_lever = least_lever;
  options.qp.unilateral = unilateral;
  options.qp.force_priority = force_priority;
  options.qp.unilateral_priority = unilateral_priority;
  options.damping = damping;
  options.lambda_max = lambda_max;
  options.force_threshold = force_threshold.value_or(std::min(options.force_threshold, lambda_max / 3));
  options.force_time_constant = force_time_constant;
  options.release_time = release_time;
  options.posture_time_constant = posture_time_constant;
  options.max_contacts = max_contacts;
  options.revolute_speed = revolute_speed;
  options.prismatic_speed = prismatic_speed;
  if (torque) options.torque = torque->value;
  options.tool_length = tool_length;
  return std::make_shared<ContactController>(ContactController{model, control::ContactController(model, options)});
}

ContactForce make_contact(const std::string& body, const Vector& p_WC, const Vector& force_W, int id, std::optional<double> lambda_max) {
  if (lambda_max) core::require_positive("lambda_max", *lambda_max);
  return {body,
          {.id = id,
           .body = -1,
           .p_WC = require_vector3("p_WC", p_WC),
           .force_W = require_vector3("force_W", force_W),
           .lambda_max = lambda_max}};
}

ControllerCommand update(ContactController& self, const ControllerState& state, double dt) {
  const world::Model& model = *self.model;
  std::vector<control::ContactForce> contacts;
  for (const ContactForce& contact : state.contacts) {
    contacts.push_back(contact.values);
    contacts.back().body = find_link(model, "contact.body", contact.body);
  }
  control::ToolReference tool;
  if (state.tool) tool = {find_link(model, "tool.body", state.tool->body), state.tool->X_BT, state.tool->X_WT};
  ControllerCommand out;
  out.values = self.controller.update(
      {.time = state.time, .q = state.q, .q_ref = state.q_ref, .contacts = contacts, .tool = state.tool ? &tool : nullptr}, dt);
  for (const control::ContactForce& taken : out.values.taken)
    out.taken.push_back({model.bodies()[static_cast<std::size_t>(taken.body)].name, taken});
  out.has_forces = self.controller.options().law == Law::ContactAware && out.values.qp.q_cmd.size() > 0;
  return out;
}

/// A vector of the program that was solved, or None.
template <class F>
auto of_program(F field) {
  return [field](const ControllerCommand& c) -> std::optional<Eigen::VectorXd> {
    if (!c.has_forces) return std::nullopt;
    return Eigen::VectorXd(c.values.qp.*field);
  };
}

template <class F>
auto of_contact(F field) {
  return [field](const ContactForce& c) { return c.values.*field; };
}

void bind_options(nb::module_& m) {
  nb::enum_<Law>(m, "Law", "What computes the command of a tick.")
      .value("ContactAware", Law::ContactAware, "tracking with bounded forces (C.3)")
      .value("Unconstrained", Law::Unconstrained, "baseline: tracking alone, without forces and limits")
      .value("NullSpace", Law::NullSpace, "baseline: stiffness-consistent null space with the force as an equality")
      .value("ForceEquality", Law::ForceEquality, "baseline: the early published form, the force of one contact as an equality");
  nb::enum_<TrackingCost>(m, "TrackingCost", "What of a command is compared with the reference.")
      .value("Command", TrackingCost::Command, "the command (5.24): for contacts with friction")
      .value("Equilibrium", TrackingCost::Equilibrium, "the equilibrium that it leads to (5.22): for contacts without");
  const ForceDampingOptions standard;
  nb::class_<ForceDampingOptions>(m, "ForceDampingOptions",
                                  R"(How far forces that are not as predicted slow the command down (5.28), (5.29).

  largest: w_max [-], >= 0. force_scale: an error of this makes 1 - 1/e of it [N], > 0.
  forget_rate: alpha, in (0, 1]. Both are stated for ticks of `period` [s], > 0; other ticks slow down as much per second. printed: (5.29) as printed, an average of two ticks; else a low-pass.)")
      .def(
          "__init__",
          [](ForceDampingOptions* self, double largest, double force_scale, double forget_rate, double period, Flag printed) {
            new (self) ForceDampingOptions{largest, force_scale, forget_rate, period, printed};
          },
          nb::kw_only(), "largest"_a = standard.largest, "force_scale"_a = standard.force_scale, "forget_rate"_a = standard.forget_rate,
          "period"_a = standard.period, "printed"_a = standard.printed)
      .def_ro("largest", &ForceDampingOptions::largest)
      .def_ro("force_scale", &ForceDampingOptions::force_scale)
      .def_ro("forget_rate", &ForceDampingOptions::forget_rate)
      .def_ro("period", &ForceDampingOptions::period, "[s]")
      .def_ro("printed", &ForceDampingOptions::printed)
      .def("__repr__", [](const ForceDampingOptions& o) {
        return fmt::format("ForceDampingOptions(largest={}, force_scale={}, forget_rate={}, period={}, printed={})", o.largest,
                           o.force_scale, o.forget_rate, o.period, o.printed ? "True" : "False");
      });
}

void bind_state(nb::module_& m) {
  nb::class_<ContactForce>(m, "ContactForce", R"(A force on the robot, measured or estimated.

  body: link that is touched, as robot/link.
  p_WC: where [m] (3). force_W: on the robot; its direction is the normal of (5.4) [N] (3).
  id: the same contact has the same number in the next tick, so that its force can be predicted.
  lambda_max: own bound [N], > 0; None: that of the controller.)")
      .def(
          "__init__",
          [](ContactForce* self, const std::string& body, const Vector& p_WC, const Vector& force_W, int id,
             std::optional<double> lambda_max) { new (self) ContactForce(make_contact(body, p_WC, force_W, id, lambda_max)); },
          nb::kw_only(), "body"_a, "p_WC"_a, "force_W"_a, "id"_a = 0, "lambda_max"_a = nb::none())
      .def_ro("body", &ContactForce::body)
      .def_prop_ro("id", of_contact(&control::ContactForce::id))
      .def_prop_ro("p_WC", of_contact(&control::ContactForce::p_WC), "[m] (3)")
      .def_prop_ro("force_W", of_contact(&control::ContactForce::force_W), "on the robot [N] (3)")
      .def_prop_ro("lambda_max", of_contact(&control::ContactForce::lambda_max), "[N], or None")
      .def("__repr__", [](const ContactForce& c) {
        const Eigen::Vector3d &p = c.values.p_WC, &f = c.values.force_W;
        return fmt::format("ContactForce(body='{}', p_WC=[{:.6g}, {:.6g}, {:.6g}], force_W=[{:.6g}, {:.6g}, {:.6g}], id={})", c.body, p.x(),
                           p.y(), p.z(), f.x(), f.y(), f.z(), c.values.id);
      });
  nb::class_<ToolReference>(m, "ToolReference", R"(Where a point fixed in a link is to be.

  body: link, as robot/link. X_BT: the tool in it. X_WT: where it is to be in the world.)")
      .def(
          "__init__",
          [](ToolReference* self, const std::string& body, const world::Pose& X_BT, const world::Pose& X_WT) {
            new (self) ToolReference{body, X_BT, X_WT};
          },
          nb::kw_only(), "body"_a, "X_BT"_a, "X_WT"_a)
      .def_ro("body", &ToolReference::body)
      .def_ro("X_BT", &ToolReference::X_BT)
      .def_ro("X_WT", &ToolReference::X_WT);
  nb::class_<ControllerState>(m, "ControllerState", R"(What is measured and wanted in one tick.

  time: of the measurement [s].
  q: joint positions (n_a) [rad or m].
  q_ref: of the next tick (n_a); beside a tool: the posture that is preferred.
  contacts: forces on the robot. tool: where a tool is to be; None: joints are tracked.)")
      .def(
          "__init__",
          [](ControllerState* self, double time, const Vector& q, const Vector& q_ref, std::vector<ContactForce> contacts,
             std::optional<ToolReference> tool) {
            new (self) ControllerState{time, q.value, q_ref.value, std::move(contacts), std::move(tool)};
          },
          nb::kw_only(), "time"_a, "q"_a, "q_ref"_a, "contacts"_a = std::vector<ContactForce>{}, "tool"_a = nb::none())
      .def_ro("time", &ControllerState::time, "[s]")
      .def_ro("q", &ControllerState::q, "(n_a)")
      .def_ro("q_ref", &ControllerState::q_ref, "(n_a)")
      .def_ro("contacts", &ControllerState::contacts)
      .def_ro("tool", &ControllerState::tool);
}

void bind_command(nb::module_& m) {
  using control::ContactQpResult;
  using Values = control::ControllerCommand;
  const auto of = [](auto field) { return [field](const ControllerCommand& c) { return c.values.*field; }; };
  nb::class_<ControllerCommand>(
      m, "ControllerCommand",
      "The command of a tick and what it rests on. Forces are those of `taken`; None unless the law is ContactAware.")
      .def_prop_ro("status", of(&Values::status), "not Solved: q_cmd is that of the tick before")
      .def_prop_ro("q_cmd", of(&Values::q_cmd), "(n_a) [rad or m]")
      .def_prop_ro("held", of(&Values::held), "the measurement is not younger than the last one: nothing was computed")
      .def_ro("taken", &ControllerCommand::taken, "contacts that count, with their forces after the low-pass")
      .def_prop_ro("left_out", of(&Values::left_out), "contacts for which there was no room")
      .def_prop_ro("damping", of(&Values::damping), "w of (5.24)")
      .def_prop_ro("q_next", of_program(&ContactQpResult::q_next), "predicted equilibrium (n_a)")
      .def_prop_ro("lambda_", of_program(&ContactQpResult::lambda), "predicted forces [N] (contacts)")
      .def_prop_ro("slack", of_program(&ContactQpResult::slack), "by which they exceed their bounds [N] (contacts)")
      .def_prop_ro("pull", of_program(&ContactQpResult::pull), "by which they are below 0 where contacts do not pull [N] (contacts)")
      .def_prop_ro("torque_slack", of_program(&ContactQpResult::torque_slack), "by which joint springs exceed `torque` [N m] (n_a)")
      .def_prop_ro("limit_slack", of_program(&ContactQpResult::limit_slack), "by which q_cmd is outside the joint limits [rad or m] (n_a)")
      .def("__repr__", [](const ControllerCommand& c) {
        return fmt::format("<stiction.ControllerCommand: {}, {} contacts>", core::to_string(c.values.status), c.taken.size());
      });
}

}  // namespace

void bind_control(nb::module_& m) {
  bind_options(m);
  bind_state(m);
  bind_command(m);
  const ControllerOptions standard;
  nb::class_<ContactController>(
      m, "ContactController",
      R"(Commands of a stiffness-controlled robot with bounded contact forces, as ros2_control shapes one: configured once, then one
update a tick. docs/theory/control.md

  model: with a robot whose joints have a stiffness.
  law: Law.ContactAware, or a baseline. cost: TrackingCost.Command (5.24) or Equilibrium (5.22).
  lambda_max: bound of every contact that brings none of its own [N], > 0.
  force_threshold: contacts with less force are left out [N], >= 0, below lambda_max; None: 5 N, or a third of lambda_max if that is less.
  force_time_constant: low-pass on the force of a contact [s], >= 0.
  release_time: in which the bound of a contact that is lost grows by lambda_max, until it holds nothing back [s], > 0.
  max_contacts: of more than these those with the largest forces are taken.
  revolute_speed [rad/s], prismatic_speed [m/s]: of commands, > 0.
  posture_time_constant: in which the posture beside a tool is got nearer [s], >= 0.
  torque: of the joint springs (n_a) [N m], > 0; None: not bounded.
  tool_length: a metre of the tool counts as 1/this radians [m], > 0.
  damping: ForceDampingOptions().
  unilateral: contacts that the reference does not leave do not pull.
  contact_compliance: softness of a contact as a share of the arm's own, > 0; least_lever: shortest lever by which it is judged [m], > 0.
  posture_weight: of |q_cmd - q_ref|^2 beside a tool; epsilon: of it beside the equilibrium (5.22), > 0.
  force_priority, unilateral_priority: of bounded forces before contacts that do not pull, and of these before tracking.

Raises InvalidInput by the name of the argument; of a robot without stiffness.

    >>> model = st.load_control_scenario("box_in_the_way").model
    >>> controller = st.ContactController(model, lambda_max=15.0)
    >>> controller.configure(np.zeros(model.n_a))
    >>> command = controller.update(st.ControllerState(time=0.0, q=np.zeros(model.n_a), q_ref=np.full(model.n_a, 1e-4)), 0.005)
    >>> command.status, command.q_cmd.shape
    (Status.Solved, (7,)))")
      .def(nb::new_(&make_controller), "model"_a, nb::kw_only(), "law"_a = standard.law, "cost"_a = standard.qp.cost,
           "lambda_max"_a = standard.lambda_max, "force_threshold"_a = nb::none(), "force_time_constant"_a = standard.force_time_constant,
           "release_time"_a = standard.release_time, "max_contacts"_a = standard.max_contacts, "revolute_speed"_a = standard.revolute_speed,
           "prismatic_speed"_a = standard.prismatic_speed, "torque"_a = nb::none(),
           "posture_time_constant"_a = standard.posture_time_constant, "tool_length"_a = standard.tool_length,
           "damping"_a = standard.damping, "unilateral"_a = standard.qp.unilateral, "contact_compliance"_a = standard.qp.contact_compliance,
           "posture_weight"_a = standard.qp.posture_weight, "epsilon"_a = standard.qp.epsilon, "least_lever"_a = standard.qp.least_lever,
           "force_priority"_a = standard.qp.force_priority, "unilateral_priority"_a = standard.qp.unilateral_priority)
      .def_ro("model", &ContactController::model)
      .def_prop_ro("law", [](const ContactController& c) { return c.controller.options().law; })
      .def_prop_ro(
          "lambda_max", [](const ContactController& c) { return c.controller.options().lambda_max; }, "[N]")
      .def(
          "configure", [](ContactController& self, const Vector& q) { self.controller.configure(q.value); }, "q"_a,
          "Starts anew with the present joint positions (n_a) as command. Raises InvalidInput: size, not finite.")
      .def("update", &update, "state"_a, "dt"_a,
           R"(The next command, from a ControllerState. dt: for which it holds [s], > 0.

A state that is not younger than the last one changes nothing: `held`. Raises InvalidInput: sizes, numbers that are not finite, dt <= 0,
a link that is not the robot's.)");
  def_pickle<ForceDampingOptions, ContactForce, ToolReference, ControllerState, ControllerCommand>();
  def_no_pickle<ContactController>("ContactController", "the model and the options that it was made from");
}

}  // namespace stiction::python
