#include "pickles.hpp"
#include "sensor.hpp"
#include "stiction/sensing/observer.hpp"
#include "stiction/sensing/torque_noise.hpp"
#include "stiction/sensing/touch_onset.hpp"

namespace stiction::python {
namespace {

using sensing::JointFriction;

sensing::MotionRecord make_record(const Vector& t, const Matrix& q, const Matrix& qd, const Matrix& tau) {
  return {{t.named("t").begin(), t.named("t").end()}, q.named("q").transpose(), qd.named("qd").transpose(), tau.named("tau").transpose()};
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

/// Σ of n joints, from their standard deviations or as it is.
Eigen::MatrixXd covariance_of(const std::variant<VectorAlone, MatrixAlone>& noise, Eigen::Index n) {
  if (const auto* covariance = std::get_if<MatrixAlone>(&noise)) return covariance->value;
  double uniform = 0;
  const Eigen::MatrixXd out = sensing::make_covariance(std::get<VectorAlone>(noise).value, static_cast<int>(n), uniform);
  return out.size() > 0 ? out : Eigen::MatrixXd(uniform * uniform * Eigen::MatrixXd::Identity(n, n));
}

void bind_onset(nb::module_& m) {
  using sensing::TouchOnset;
  nb::class_<TouchOnset>(m, "TouchOnset", R"(Detects when a touch begins, and averages the torques since then.

Without contact, the detector tracks the slow offset of the torques. A change test sums up the differences from this offset. When a touch
begins, the offset is held, and the mean of the torques becomes more accurate with every row: use it as
sense(q, onset.mean, rest=onset.rest, noise=onset.noise). Only one thread may use a detector.

  rest: torques without contact (n) [N m; N].
  noise: standard deviations of one row (n), or their covariance (n, n), as Calibration.within.
  drift: drift of the offset as a random walk (n) [N m/s^0.5]. None: no drift.
  hysteresis, settle: error that a touch leaves, as in Calibration.hysteresis. For `settle` seconds after a touch [s], the offset has an
    error of this share of the torques of the touch.
  false_alarms: share of rows without contact at which a false alarm begins, in (0, 0.1).
  shift: change of the torques that is to be detected soonest, in standard deviations of the noise, > 0.
  rest_rows: number of rows whose mean is `rest`.
  quiet: number of rows within the noise that end a touch, >= 1.

Raises InvalidInput, which names the argument.)")
      .def(
          "__init__",
          [](TouchOnset* self, const Vector& rest, const std::variant<VectorAlone, MatrixAlone>& noise, const std::optional<Vector>& drift,
             double hysteresis, double settle, double false_alarms, double shift, int rest_rows, int quiet) {
            sensing::OnsetOptions options{.noise = covariance_of(noise, rest.named("rest").size()),
                                          .hysteresis = hysteresis,
                                          .settle = settle,
                                          .false_alarms = false_alarms,
                                          .shift = shift,
                                          .rest_rows = rest_rows,
                                          .quiet = quiet};
            if (drift) options.drift = drift->named("drift");
            new (self) TouchOnset(rest.named("rest"), std::move(options));
          },
          "rest"_a, "noise"_a, nb::kw_only(), "drift"_a = nb::none(), "hysteresis"_a = sensing::OnsetOptions{}.hysteresis,
          "settle"_a = sensing::OnsetOptions{}.settle, "false_alarms"_a = sensing::OnsetOptions{}.false_alarms,
          "shift"_a = sensing::OnsetOptions{}.shift, "rest_rows"_a = sensing::OnsetOptions{}.rest_rows,
          "quiet"_a = sensing::OnsetOptions{}.quiet)
      .def(
          "update", [](TouchOnset& self, const Vector& tau, double dt) { return self.update(tau.named("tau"), dt); }, "tau"_a, "dt"_a,
          "Processes one row of torques (n) [N m; N], measured dt [s] after the previous row. Returns True while something touches.")
      .def_prop_ro("touches", &TouchOnset::touches, "True: something touches")
      .def_prop_ro("rows", &TouchOnset::rows, "number of rows since the touch began")
      .def_prop_ro(
          "rest", [](const TouchOnset& o) { return Eigen::VectorXd(o.rest()); }, "offset of the torques before the touch (n) [N m; N]")
      .def_prop_ro("mean", &TouchOnset::mean, "mean of the torques since the touch began (n) [N m; N]")
      .def_prop_ro("noise", &TouchOnset::noise, "covariance of mean - rest (n, n) [(N m)^2]")
      .def_prop_ro("sum", &TouchOnset::sum, "sum of the change test")
      .def_prop_ro("bound", &TouchOnset::bound, "value of `sum` from which a touch counts as detected");
}

}  // namespace

void bind_observer(nb::module_& m) {
  nb::class_<JointFriction>(m, "JointFriction",
                            "Friction of each joint, coulomb tanh(qd/stiction_speed) + viscous qd, and the offset of its torque sensor.")
      .def_ro("coulomb", &JointFriction::coulomb, "Coulomb friction (n_a) [N m; N]")
      .def_ro("viscous", &JointFriction::viscous, "viscous friction (n_a) [N m s/rad; N s/m]")
      .def_ro("offset", &JointFriction::offset, "offset of the torque sensor (n_a) [N m; N]")
      .def_ro("stiction_speed", &JointFriction::stiction_speed, "speed below which the sign of friction is uncertain [rad/s or m/s]")
      .def_ro("left", &JointFriction::left, "standard deviation of the residual torques of the fit, noise included (n_a) [N m; N]");
  const sensing::ObserverSettings standard;
  m.def("observe", &observe, "model"_a, "t"_a, "q"_a, "qd"_a, "tau"_a, nb::kw_only(), "time_constant"_a = standard.time_constant,
        "friction"_a = nb::none(),
        R"(Estimates external torques from motion and motor torques with a momentum observer, which needs no accelerations.

Its result is the argument tau of Sensor.sense().

  model: Model with the robot.
  t: times, increasing [s] (time).
  q, qd: joint positions [rad or m] and velocities [rad/s or m/s] (time, n_a).
  tau: torques of the motors on the links [N m; N] (time, n_a), as torque sensors at the joints measure them. The model has no rotors:
    if these are torques of the motors themselves, the torques that accelerate their rotors (`armature` of an MJCF) look external.
  time_constant: lag of the estimate [s], > 0.
  friction: JointFriction of identify_friction(). None: no friction.

Returns the external torques [N m; N] (time, n_a). Raises InvalidInput: wrong sizes, numbers that are not finite, times that do not
increase, a robot without masses.)");
  m.def("identify_friction", &identify_friction, "model"_a, "t"_a, "q"_a, "qd"_a, "tau"_a, nb::kw_only(),
        "time_constant"_a = standard.time_constant, "stiction_speed"_a = JointFriction{}.stiction_speed,
        R"(Identifies the friction of each joint from a motion without contact, in which every joint moves in both directions.

  model, t, q, qd, tau, time_constant: as in observe().
  stiction_speed: speed below which the sign of friction is uncertain [rad/s or m/s], > 0.

Returns a JointFriction. Raises InvalidInput: as observe(), or a joint that does not move in both directions.)");
  bind_onset(m);
  def_no_pickle<sensing::TouchOnset>("TouchOnset", "the rest and the options that it was made from");
  def_pickle<JointFriction>();
}

}  // namespace stiction::python
