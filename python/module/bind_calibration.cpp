#include <fmt/format.h>

#include "pickles.hpp"
#include "sensor.hpp"
#include "stiction/sensing/series_columns.hpp"
#include "torque_arguments.hpp"

namespace stiction::python {
namespace {

using sensing::Calibration;

Calibrated calibrate(const ModelPtr& model, const Matrix& q, const Matrix& tau, const std::optional<Vector>& t,
                     const std::optional<std::vector<int>>& records, const std::optional<std::vector<Flag>>& touched,
                     const std::optional<std::string>& payload, double same_posture, double settle,
                     const std::vector<JointArgument>& unmeasured) {
  sensing::RestRows rows{.q = q.named("q").transpose(), .tau = tau.named("tau").transpose()};
  std::vector<int> left_out;
  for (const JointArgument& joint : unmeasured) left_out.push_back(find_unmeasured(*model, joint));
  rows.measured = sensing::joints_but(model->n_a(), left_out);
  if (t) {
    core::require_size("t", t->named("t").size(), rows.tau.cols());
    rows.times.assign(t->named("t").begin(), t->named("t").end());
  }
  if (records) rows.records = *records;
  if (touched) rows.touched.assign(touched->begin(), touched->end());
  sensing::CalibrationOptions options{.same_posture = same_posture, .settle = settle};
  if (payload) options.payload_body = find_link(*model, "payload", *payload);
  const nb::gil_scoped_release unlocked;
  return {model, sensing::calibrate(*model, rows, options)};
}

template <class F>
auto of(F field) {
  return [field](const Calibrated& c) { return c.values.*field; };
}

void bind_noise(nb::module_& m) {
  using sensing::Hysteresis, sensing::TorqueNoise;
  nb::class_<Hysteresis>(m, "Hysteresis", "Error of the rest torques that remains for a while after a touch.")
      .def_ro("share", &Hysteresis::share,
              "standard deviation of the error right after a touch, as a share of the largest torque of the joint during the touch")
      .def_ro("freedom", &Hysteresis::freedom, "degrees of freedom of this estimate; 0: no rows were touched")
      .def_ro("settle", &Hysteresis::settle, "time after a touch until the error has vanished [s]");
  nb::class_<TorqueNoise>(m, "TorqueNoise",
                          "Noise of joint torques, and how well it is known. Use it as sense(noise=n.covariance, freedom=n.freedom).")
      .def_ro("covariance", &TorqueNoise::covariance, "covariance of the torques (n_a, n_a) [(N m)^2]")
      .def_ro("freedom", &TorqueNoise::freedom, "degrees of freedom of the noise estimate of each joint (n_a)");
}

void bind_payload(nb::module_& m) {
  nb::class_<sensing::Payload>(m, "Payload", "Payload on a link that the robot's own model does not contain.")
      .def_ro("mass", &sensing::Payload::mass, "mass [kg]; negative: the robot's model has too much mass, or the sign of the torques is -1")
      .def_ro("mass_deviation", &sensing::Payload::mass_deviation, "standard deviation of the mass [kg]")
      .def_ro("centre_L", &sensing::Payload::centre_L, "centre of mass in the frame of the link [m] (3)");
}

}  // namespace

void bind_calibration(nb::module_& m) {
  bind_payload(m);
  bind_noise(m);
  nb::class_<Calibrated>(m, "Calibration", "Result of calibrate(): offset, noise and drift of the external joint torques, and the payload.")
      .def_prop_ro("rest", of(&Calibration::rest),
                   "torque offset: the measured torques without contact, from the last record (n_a) [N m; N]")
      .def_prop_ro("noise", of(&Calibration::noise), "covariance of a measured torque minus rest (n_a, n_a) [(N m)^2]")
      .def_prop_ro("within", of(&Calibration::within), "covariance of a single row about the mean of a long record (n_a, n_a) [(N m)^2]")
      .def_prop_ro(
          "noise_between", [](const Calibrated& c) { return unless_empty(c.values.noise_between); },
          "noise if rest comes from another record of the same posture (n_a, n_a) [(N m)^2]; None: no posture has two records")
      .def_prop_ro(
          "deviation", [](const Calibrated& c) { return Eigen::VectorXd(c.values.noise.diagonal().cwiseSqrt()); },
          "standard deviation of each measured torque minus rest (n_a) [N m; N]")
      .def_prop_ro(
          "drift", [](const Calibrated& c) { return unless_empty(c.values.drift); },
          "drift of the offset as a random walk (n_a, 1) [N m/s^0.5]; None: there are no times that differ")
      .def_prop_ro("freedom", of(&Calibration::freedom), "degrees of freedom of the noise: number of rows minus number of records")
      .def_prop_ro("hysteresis", of(&Calibration::hysteresis), "Hysteresis: error that remains after a touch, if rows were touched")
      .def_prop_ro("payload", of(&Calibration::payload), "Payload that was found, or None")
      .def_prop_ro("rows", of(&Calibration::rows), "number of rows")
      .def_prop_ro("records", of(&Calibration::records), "number of records")
      .def_prop_ro("postures", of(&Calibration::postures), "number of postures")
      .def_prop_ro("touched", of(&Calibration::touched), "indices of rows that were left out, since something seems to touch the robot")
      .def_prop_ro("notes", of(&Calibration::notes), "remarks, one sentence each")
      .def(
          "calc_rest",
          [](const Calibrated& c, const Vector& q) { return c.values.calc_rest(*c.model, configuration_of(*c.model, "q", q.named("q"))); },
          "q"_a,
          "Returns the torque offset at a posture, payload included (n_a) [N m; N]. q: configuration (n_q), or joint positions alone "
          "(n_a).")
      .def(
          "calc_noise",
          [](const Calibrated& c, const std::optional<Vector>& touch, double seconds, int rest_rows) {
            return c.values.calc_noise(touch ? touch->named("touch") : Eigen::VectorXd::Zero(c.values.within.rows()), seconds, rest_rows);
          },
          nb::kw_only(), "touch"_a = nb::none(), "seconds"_a = 0.0, "rest_rows"_a = 1,
          R"(Returns the TorqueNoise of a measured torque minus the torque offset.

  touch: largest torque of each joint during the last touch (n_a) [N m; N]. None: there was no touch.
  seconds: time since that touch [s], >= 0.
  rest_rows: number of rows whose mean is the offset, >= 1.)")
      .def("__repr__", [](const Calibrated& c) {
        return fmt::format("<stiction.Calibration: {} rows of {} records>", c.values.rows, c.values.records);
      });
  m.def("calibrate", &calibrate, "model"_a, "q"_a, "tau"_a, nb::kw_only(), "t"_a = nb::none(), "records"_a = nb::none(),
        "touched"_a = nb::none(), "payload"_a = nb::none(), "same_posture"_a = sensing::CalibrationOptions{}.same_posture,
        "settle"_a = sensing::CalibrationOptions{}.settle, "unmeasured"_a = std::vector<JointArgument>(),
        R"(Estimates offset, noise and drift of a robot's external joint torques from measurements at rest, and an unknown payload.

Call it before Sensor.sense(): its arguments rest, noise and freedom take the results.

  model: Model with the robot.
  q, tau: measured joint positions and torques (rows, n_a) [rad or m], [N m; N]. Each row is one measurement without contact.
  t: times of the rows [s] (rows), or None.
  records: number of the record that each row belongs to (rows). None: all rows are one record.
  touched: True for each row in which something touches the robot (rows), or None. These rows, and rows up to `settle` seconds later, do
    not count as rest. They show the error that a touch leaves (Hysteresis).
  payload: link that may carry a payload, as "robot/link". This needs rest in three postures or more. None: no payload.
  same_posture: largest difference of joint positions within one posture [rad or m].
  settle: time after a touch until the torques are at rest again [s].
  unmeasured: joints without a torque sensor, by index or name. Their noise is returned as 1, and their rest as 0.

Returns a Calibration. Raises InvalidInput: wrong sizes, no record with two rows, a torque that never changes, or many touched rows.)");
  nb::class_<sensing::SignCheck>(m, "SignCheck", "Result of check_sign(): the sign convention of the measured torques.")
      .def_ro("sign", &sensing::SignCheck::sign,
              "1: torques of the motors on the links; -1: the opposite sign; 0: these are not total torques of this model")
      .def_ro("factor", &sensing::SignCheck::factor, "measured torques as a multiple of the torques that hold the robot against gravity")
      .def_ro("message", &sensing::SignCheck::message, "explanation, or advice");
  m.def(
      "check_sign",
      [](const ModelPtr& model, const Matrix& q, const Matrix& tau) {
        return sensing::check_sign(*model, q.named("q").transpose(), tau.named("tau").transpose());
      },
      "model"_a, "q"_a, "tau"_a,
      R"(Determines the sign convention of measured total joint torques, by comparison with gravity.

  q, tau: joint positions and total torques at rest (rows, n_a).

Returns a SignCheck.)");
  m.def(
      "calc_holding_torques",
      [](const ModelPtr& model, const Vector& q) {
        return sensing::calc_holding_torques(*model, configuration_of(*model, "q", q.named("q")));
      },
      "model"_a, "q"_a,
      "Returns the motor torques that hold the robots against gravity (n_a) [N m; N]. q: configuration (n_q), or joint positions alone "
      "(n_a).");
  def_pickle<sensing::Payload, sensing::Hysteresis, sensing::TorqueNoise, Calibrated, sensing::SignCheck>();
}

}  // namespace stiction::python
