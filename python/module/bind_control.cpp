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
  if (torque) options.torque = torque->named("torque");
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
  nb::enum_<Law>(m, "Law", "Control law of ContactController.")
      .value("ContactAware", Law::ContactAware, "tracks the reference within bounds on the contact forces (C.3)")
      .value("Unconstrained", Law::Unconstrained, "baseline: tracks the reference, without bounds on forces and without limits")
      .value("NullSpace", Law::NullSpace, "baseline: controls the contact force, and tracks in the stiffness-consistent null space")
      .value("ForceEquality", Law::ForceEquality,
             "baseline: the early published form, in which the force of one contact is an equality constraint");
  nb::enum_<TrackingCost>(m, "TrackingCost", "Quantity that the controller compares with the reference.")
      .value("Command", TrackingCost::Command, "the command (5.24); for contacts with friction")
      .value("Equilibrium", TrackingCost::Equilibrium, "the equilibrium that the command leads to (5.22); for contacts without friction");
  const ForceDampingOptions standard;
  nb::class_<ForceDampingOptions>(m, "ForceDampingOptions",
                                  R"(Damping that slows the command down if contact forces differ from their prediction (5.28), (5.29).

  largest: largest damping w_max [-], >= 0.
  force_scale: force error at which the damping is 1 - 1/e of its largest value [N], > 0.
  forget_rate: coefficient alpha of the low-pass, in (0, 1].
  period: tick for which largest and forget_rate are given [s], > 0. They are converted for other ticks, so that the damping per second is
    the same.
  printed: True: use (5.29) as printed, an average of two ticks. False: use a low-pass.)")
      .def(
          "__init__",
          [](ForceDampingOptions* self, double largest, double force_scale, double forget_rate, double period, Flag printed) {
            new (self) ForceDampingOptions{largest, force_scale, forget_rate, period, printed};
          },
          nb::kw_only(), "largest"_a = standard.largest, "force_scale"_a = standard.force_scale, "forget_rate"_a = standard.forget_rate,
          "period"_a = standard.period, "printed"_a = standard.printed)
      .def_ro("largest", &ForceDampingOptions::largest, "largest damping w_max")
      .def_ro("force_scale", &ForceDampingOptions::force_scale, "scale of the force error [N]")
      .def_ro("forget_rate", &ForceDampingOptions::forget_rate, "coefficient alpha of the low-pass")
      .def_ro("period", &ForceDampingOptions::period, "tick for which the options are given [s]")
      .def_ro("printed", &ForceDampingOptions::printed, "True: (5.29) as printed")
      .def("__repr__", [](const ForceDampingOptions& o) {
        return fmt::format("ForceDampingOptions(largest={}, force_scale={}, forget_rate={}, period={}, printed={})", o.largest,
                           o.force_scale, o.forget_rate, o.period, o.printed ? "True" : "False");
      });
}

void bind_state(nb::module_& m) {
  nb::class_<ContactForce>(m, "ContactForce", R"(A measured or estimated contact force on the robot.

  body: link in contact, as robot/link.
  p_WC: contact point in W [m] (3).
  force_W: contact force on the robot in W [N] (3). Its direction is the normal of (5.4).
  id: number of the contact. Give the same contact the same number in every tick, so that the controller can predict its force.
  lambda_max: bound on this force [N], > 0. None: the bound of the controller.)")
      .def(
          "__init__",
          [](ContactForce* self, const std::string& body, const Vector& p_WC, const Vector& force_W, int id,
             std::optional<double> lambda_max) { new (self) ContactForce(make_contact(body, p_WC, force_W, id, lambda_max)); },
          nb::kw_only(), "body"_a, "p_WC"_a, "force_W"_a, "id"_a = 0, "lambda_max"_a = nb::none())
      .def_ro("body", &ContactForce::body, "link in contact, as robot/link")
      .def_prop_ro("id", of_contact(&control::ContactForce::id), "number of the contact")
      .def_prop_ro("p_WC", of_contact(&control::ContactForce::p_WC), "contact point in W [m] (3)")
      .def_prop_ro("force_W", of_contact(&control::ContactForce::force_W), "force on the robot in W [N] (3)")
      .def_prop_ro("lambda_max", of_contact(&control::ContactForce::lambda_max), "bound on this force [N], or None")
      .def("__repr__", [](const ContactForce& c) {
        const Eigen::Vector3d &p = c.values.p_WC, &f = c.values.force_W;
        return fmt::format("ContactForce(body='{}', p_WC=[{:.6g}, {:.6g}, {:.6g}], force_W=[{:.6g}, {:.6g}, {:.6g}], id={})", c.body, p.x(),
                           p.y(), p.z(), f.x(), f.y(), f.z(), c.values.id);
      });
  nb::class_<ToolReference>(m, "ToolReference", R"(Reference pose of a tool that is fixed to a link.

  body: link, as robot/link.
  X_BT: pose of the tool in the link.
  X_WT: reference pose of the tool in W.)")
      .def(
          "__init__",
          [](ToolReference* self, const std::string& body, const world::Pose& X_BT, const world::Pose& X_WT) {
            new (self) ToolReference{body, X_BT, X_WT};
          },
          nb::kw_only(), "body"_a, "X_BT"_a, "X_WT"_a)
      .def_ro("body", &ToolReference::body, "link, as robot/link")
      .def_ro("X_BT", &ToolReference::X_BT, "pose of the tool in the link")
      .def_ro("X_WT", &ToolReference::X_WT, "reference pose of the tool in W");
  nb::class_<ControllerState>(m, "ControllerState", R"(Measurement and reference of one tick of ContactController.

  time: time of the measurement [s].
  q: measured joint positions (n_a) [rad or m].
  q_ref: reference joint positions of the next tick (n_a) [rad or m]. If a tool is given, q_ref is the preferred posture.
  contacts: list of ContactForce on the robot.
  tool: ToolReference to track. None: the controller tracks q_ref.)")
      .def(
          "__init__",
          [](ControllerState* self, double time, const Vector& q, const Vector& q_ref, std::vector<ContactForce> contacts,
             std::optional<ToolReference> tool) {
            new (self) ControllerState{time, q.named("q"), q_ref.named("q_ref"), std::move(contacts), std::move(tool)};
          },
          nb::kw_only(), "time"_a, "q"_a, "q_ref"_a, "contacts"_a = std::vector<ContactForce>{}, "tool"_a = nb::none())
      .def_ro("time", &ControllerState::time, "time of the measurement [s]")
      .def_ro("q", &ControllerState::q, "measured joint positions (n_a)")
      .def_ro("q_ref", &ControllerState::q_ref, "reference joint positions of the next tick (n_a)")
      .def_ro("contacts", &ControllerState::contacts, "contact forces on the robot")
      .def_ro("tool", &ControllerState::tool, "tool reference, or None");
}

void bind_command(nb::module_& m) {
  using control::ContactQpResult;
  using Values = control::ControllerCommand;
  const auto of = [](auto field) { return [field](const ControllerCommand& c) { return c.values.*field; }; };
  nb::class_<ControllerCommand>(m, "ControllerCommand",
                                "Command of one tick, with predicted forces. The predictions are for the contacts in `taken`, and None "
                                "unless the law is ContactAware.")
      .def_prop_ro("status", of(&Values::status), "if not Solved, q_cmd is the command of the previous tick")
      .def_prop_ro("q_cmd", of(&Values::q_cmd), "commanded joint positions (n_a) [rad or m]")
      .def_prop_ro("held", of(&Values::held), "True: the measurement is not newer than the previous one, and nothing was computed")
      .def_ro("taken", &ControllerCommand::taken, "contacts that were used, with their forces after the low-pass")
      .def_prop_ro("left_out", of(&Values::left_out), "number of contacts that were left out because of max_contacts")
      .def_prop_ro("damping", of(&Values::damping), "damping w of (5.24)")
      .def_prop_ro("q_next", of_program(&ContactQpResult::q_next), "predicted equilibrium (n_a)")
      .def_prop_ro("lambda_", of_program(&ContactQpResult::lambda), "predicted forces [N] (contacts)")
      .def_prop_ro("slack", of_program(&ContactQpResult::slack), "excess of the predicted forces over their bounds [N] (contacts)")
      .def_prop_ro("pull", of_program(&ContactQpResult::pull),
                   "amount by which a predicted force is below 0 at a contact that cannot pull [N] (contacts)")
      .def_prop_ro("torque_slack", of_program(&ContactQpResult::torque_slack),
                   "excess of the joint spring torques over `torque` [N m] (n_a)")
      .def_prop_ro("limit_slack", of_program(&ContactQpResult::limit_slack),
                   "amount by which q_cmd is outside the joint limits [rad or m] (n_a)")
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
      R"(Controller that tracks a reference with a stiffness-controlled robot and keeps contact forces within bounds (docs/theory/control.md).

Call configure() once and update() in every tick, as in a controller of ros2_control.

  model: Model with a robot whose joints have a stiffness.
  law: Law.ContactAware, or a baseline.
  cost: TrackingCost.Command (5.24) or TrackingCost.Equilibrium (5.22).
  lambda_max: bound on the force of every contact that has no bound of its own [N], > 0.
  force_threshold: contacts with a smaller force are ignored [N], >= 0, below lambda_max. None: 5 N, or a third of lambda_max if that is
    less.
  force_time_constant: time constant of the low-pass on contact forces [s], >= 0.
  release_time: when a contact is lost, its bound remains and grows by lambda_max in this time [s], > 0, until the reference asks for no more.
  max_contacts: largest number of contacts; if there are more, the controller uses those with the largest forces.
  revolute_speed, prismatic_speed: largest speed of a command [rad/s], [m/s], > 0.
  posture_time_constant: time constant with which the robot approaches the preferred posture while it tracks a tool [s], >= 0.
  torque: bounds on the torques of the joint springs (n_a) [N m], > 0. None: no bound.
  tool_length: length by which tool positions are divided when they are added to angles [m], > 0.
  damping: ForceDampingOptions().
  unilateral: True: a contact that the reference does not leave cannot pull.
  contact_compliance: compliance of a contact as a share of the arm's compliance at that point, > 0.
  least_lever: a contact with a shorter lever to the joint axes has the compliance of this lever [m], > 0.
  posture_weight: weight of |q_cmd - q_ref|^2 while a tool is tracked, > 0.
  epsilon: weight of |q_cmd - q_ref|^2 beside the equilibrium cost (5.22), > 0.
  force_priority: priority of force bounds, above unilateral_priority.
  unilateral_priority: priority of contacts that cannot pull, above tracking, > 0.

Raises InvalidInput, which names the argument, also for a robot without stiffness.

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
      .def_ro("model", &ContactController::model, "model of the robot")
      .def_prop_ro(
          "law", [](const ContactController& c) { return c.controller.options().law; }, "control law")
      .def_prop_ro(
          "lambda_max", [](const ContactController& c) { return c.controller.options().lambda_max; }, "bound on contact forces [N]")
      .def(
          "configure", [](ContactController& self, const Vector& q) { self.controller.configure(q.named("q")); }, "q"_a,
          "Resets the controller. Its first command is q, the present joint positions (n_a) [rad or m]. Raises InvalidInput: wrong size, "
          "not finite.")
      .def("update", &update, "state"_a, "dt"_a,
           R"(Computes the command of the next tick.

  state: ControllerState with the measurement and the reference.
  dt: time for which the command is in force [s], > 0.

Returns a ControllerCommand. If the state is not newer than the previous one, nothing is computed and `held` is True. Raises InvalidInput:
wrong sizes, numbers that are not finite, dt <= 0, or a link that does not belong to the robot.)");
  def_pickle<ForceDampingOptions, ContactForce, ToolReference, ControllerState, ControllerCommand>();
  def_no_pickle<ContactController>("ContactController", "the model and the options that it was made from");
}

}  // namespace stiction::python
