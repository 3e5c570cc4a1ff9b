#include "pickles.hpp"
#include "sensor.hpp"
#include "stiction/sensing/observer.hpp"
#include "stiction/sensing/touch_onset.hpp"

namespace stiction::python {
namespace {

using sensing::JointFriction;

sensing::MotionRecord make_record(const Vector& t, const Matrix& q, const Matrix& qd, const Matrix& tau) {
  return {{t.value.begin(), t.value.end()}, q.value.transpose(), qd.value.transpose(), tau.value.transpose()};
}

Rows observe(const ModelPtr& model, const Vector& t, const Matrix& q, const Matrix& qd, const Matrix& tau, double time_constant,
             const std::optional<JointFriction>& friction) {
  const sensing::MotionRecord record = make_record(t, q, qd, tau);
  const nb::gil_scoped_release unlocked;
  return rows(sensing::observe(*model, record, {time_constant, friction ? &*friction : nullptr}));
}

JointFriction identify_friction(const ModelPtr& model, const Vector& t, const Matrix& q, const Matrix& qd, const Matrix& tau,
                                double time_constant, double stiction_speed) {
  const sensing::MotionRecord record = make_record(t, q, qd, tau);
  const nb::gil_scoped_release unlocked;
  return sensing::identify_friction(*model, record, time_constant, stiction_speed);
}

void bind_onset(nb::module_& m) {
  using sensing::TouchOnset;
  nb::class_<TouchOnset>(m, "TouchOnset", R"(When a touch begins, and its torques since then as one measurement.

The slow offset of the torques is followed where nothing touches, and a change test adds up what differs from it. From the beginning of a touch on the offset is
held, and the mean of the torques grows sharper: sense(q, onset.mean, rest=onset.rest, noise=onset.noise). Belongs to one thread.

  rest: torques where nothing touches (n) [N m; N]. noise: standard deviations of one row (n), or their covariance (n, n): Calibration.within.
  drift: of the offset, a random walk (n) [N m/s^0.5], or None. false_alarms: share of rows at which an alarm begins where nothing touches, in (0, 0.1).
  hysteresis, settle: what a touch leaves, as Calibration.hysteresis says: for `settle` seconds the offset is off by this share of its torques.
  shift: change that is to be found soonest, in deviations of the noise, > 0. rest_rows: of which rest is the mean. quiet: rows within noise that end a touch, >= 1.

Raises InvalidInput by the name of the argument.)")
      .def(
          "__init__",
          [](TouchOnset* self, const Vector& rest, const std::variant<Vector, Matrix>& noise, const std::optional<Vector>& drift,
             double hysteresis, double settle, double false_alarms, double shift, int rest_rows, int quiet) {
            sensing::OnsetOptions options{.noise = std::holds_alternative<Vector>(noise) ? Eigen::MatrixXd(std::get<Vector>(noise).value)
                                                                                         : std::get<Matrix>(noise).value,
                                          .hysteresis = hysteresis,
                                          .settle = settle,
                                          .false_alarms = false_alarms,
                                          .shift = shift,
                                          .rest_rows = rest_rows,
                                          .quiet = quiet};
            if (drift) options.drift = drift->value;
            new (self) TouchOnset(rest.value, std::move(options));
          },
          "rest"_a, "noise"_a, nb::kw_only(), "drift"_a = nb::none(), "hysteresis"_a = sensing::OnsetOptions{}.hysteresis,
          "settle"_a = sensing::OnsetOptions{}.settle, "false_alarms"_a = sensing::OnsetOptions{}.false_alarms,
          "shift"_a = sensing::OnsetOptions{}.shift, "rest_rows"_a = sensing::OnsetOptions{}.rest_rows,
          "quiet"_a = sensing::OnsetOptions{}.quiet)
      .def(
          "update", [](TouchOnset& self, const Vector& tau, double dt) { return self.update(tau.value, dt); }, "tau"_a, "dt"_a,
          "A row of torques (n), dt after the one before [s]. Returns whether something touches.")
      .def_prop_ro("touches", &TouchOnset::touches)
      .def_prop_ro("rows", &TouchOnset::rows, "since the touch began")
      .def_prop_ro(
          "rest", [](const TouchOnset& o) { return Eigen::VectorXd(o.rest()); }, "offset before the touch (n) [N m; N]")
      .def_prop_ro("mean", &TouchOnset::mean, "of the torques since the touch began (n) [N m; N]")
      .def_prop_ro("noise", &TouchOnset::noise, "covariance of mean - rest (n, n) [(N m)^2]")
      .def_prop_ro("sum", &TouchOnset::sum, "of the change test")
      .def_prop_ro("bound", &TouchOnset::bound, "from which on something touches");
}

}  // namespace

void bind_observer(nb::module_& m) {
  nb::class_<JointFriction>(m, "JointFriction",
                            "Friction coulomb tanh(qd/stiction_speed) + viscous qd of each joint, and the offset of its torque sensor.")
      .def_ro("coulomb", &JointFriction::coulomb, "(n_a) [N m; N]")
      .def_ro("viscous", &JointFriction::viscous, "(n_a) [N m s/rad; N s/m]")
      .def_ro("offset", &JointFriction::offset, "(n_a) [N m; N]")
      .def_ro("stiction_speed", &JointFriction::stiction_speed, "below which friction has no sure sign [rad/s or m/s]")
      .def_ro("left", &JointFriction::left, "deviation of the torques that the fit leaves, their noise included (n_a) [N m; N]");
  const sensing::ObserverSettings standard;
  m.def("observe", &observe, "model"_a, "t"_a, "q"_a, "qd"_a, "tau"_a, nb::kw_only(), "time_constant"_a = standard.time_constant,
        "friction"_a = nb::none(),
        R"(External torques from motion and motor torques, by the momentum observer: no accelerations are needed (time, n_a) [N m; N].

  t: times, increasing [s] (time). q, qd, tau: joint positions, velocities and torques of the motors on the links (time, n_a).
  time_constant: lag [s], > 0. friction: of identify_friction(), or None.

Raises InvalidInput: sizes, numbers that are not finite, times that do not increase, a robot without masses.)");
  m.def("identify_friction", &identify_friction, "model"_a, "t"_a, "q"_a, "qd"_a, "tau"_a, nb::kw_only(),
        "time_constant"_a = standard.time_constant, "stiction_speed"_a = JointFriction{}.stiction_speed,
        R"(Friction of each joint, from motion in which nothing touches the robot and every joint moves in both directions.

  Arguments as of observe(). stiction_speed: below which friction has no sure sign [rad/s or m/s], > 0.

Raises InvalidInput: as observe(); a joint that does not move in both directions.)");
  bind_onset(m);
  def_no_pickle<sensing::TouchOnset>("TouchOnset", "the rest and the options that it was made from");
  def_pickle<JointFriction>();
}

}  // namespace stiction::python
