#include <fmt/format.h>

#include "pickles.hpp"
#include "sensor.hpp"
#include "stiction/sensing/series_columns.hpp"

namespace stiction::python {
namespace {

using sensing::Calibration;

Calibrated calibrate(const ModelPtr& model, const Matrix& q, const Matrix& tau, const std::optional<Vector>& t,
                     const std::optional<std::vector<int>>& records, const std::optional<std::vector<bool>>& touched,
                     const std::optional<std::string>& payload, double same_posture, double settle,
                     const std::vector<std::variant<int, std::string>>& unmeasured) {
  sensing::RestRows rows{.q = q.value.transpose(), .tau = tau.value.transpose()};
  std::vector<int> left_out;
  for (const auto& joint : unmeasured)
    left_out.push_back(std::holds_alternative<int>(joint) ? std::get<int>(joint) : model->joint_index(std::get<std::string>(joint)));
  rows.measured = sensing::joints_but(model->n_a(), left_out);
  if (t) rows.times.assign(t->value.begin(), t->value.end());
  if (records) rows.records = *records;
  if (touched) rows.touched = *touched;
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
  nb::class_<Hysteresis>(m, "Hysteresis", "What a touch leaves for a while in the torques of rest.")
      .def_ro("share", &Hysteresis::share,
              "of the largest torque of each joint in the touch, by which it is off right after it (standard deviation)")
      .def_ro("freedom", &Hysteresis::freedom, "independent numbers by which it is known; 0: no touch is known")
      .def_ro("settle", &Hysteresis::settle, "time after a touch from which on torques are those of rest [s]");
  nb::class_<TorqueNoise>(m, "TorqueNoise", "Noise of torques, and how well it is known: sense(noise=n.covariance, freedom=n.freedom).")
      .def_ro("covariance", &TorqueNoise::covariance, "(n_a, n_a) [(N m)^2]")
      .def_ro("freedom", &TorqueNoise::freedom, "independent numbers by which the noise of each joint is known (n_a)");
}

void bind_payload(nb::module_& m) {
  nb::class_<sensing::Payload>(m, "Payload", "A rigid body that hangs on a link, and of which the robot does not know.")
      .def_ro("mass", &sensing::Payload::mass, "[kg]; negative: the robot was told of too much, or the sign is -1")
      .def_ro("mass_deviation", &sensing::Payload::mass_deviation, "standard deviation [kg]")
      .def_ro("centre_L", &sensing::Payload::centre_L, "of mass, in the frame of the link [m] (3)");
}

}  // namespace

void bind_calibration(nb::module_& m) {
  bind_payload(m);
  bind_noise(m);
  nb::class_<Calibrated>(m, "Calibration", "What is known of torques after rows at rest: calibrate().")
      .def_prop_ro("rest", of(&Calibration::rest), "torques where nothing touches, as measured: of the last record (n_a) [N m; N]")
      .def_prop_ro("noise", of(&Calibration::noise), "covariance of a torque less rest (n_a, n_a) [(N m)^2]")
      .def_prop_ro("within", of(&Calibration::within), "covariance of a row about the mean of a long record (n_a, n_a) [(N m)^2]")
      .def_prop_ro(
          "noise_between", [](const Calibrated& c) { return unless_empty(c.values.noise_between); },
          "the same with the rest of another record of the posture (n_a, n_a); None where no posture has two records")
      .def_prop_ro(
          "deviation", [](const Calibrated& c) { return Eigen::VectorXd(c.values.noise.diagonal().cwiseSqrt()); },
          "standard deviation of each torque less rest (n_a) [N m; N]")
      .def_prop_ro(
          "drift", [](const Calibrated& c) { return unless_empty(c.values.drift); },
          "of a random walk (n_a, 1) [N m/s^0.5]; None without times that differ")
      .def_prop_ro("freedom", of(&Calibration::freedom), "independent numbers by which the noise is known: rows less records")
      .def_prop_ro("hysteresis", of(&Calibration::hysteresis), "what touches leave, where rows were touched: Hysteresis")
      .def_prop_ro("payload", of(&Calibration::payload), "Payload, or None")
      .def_prop_ro("rows", of(&Calibration::rows))
      .def_prop_ro("records", of(&Calibration::records))
      .def_prop_ro("postures", of(&Calibration::postures))
      .def_prop_ro("touched", of(&Calibration::touched), "rows that were left out: something seems to touch the robot there")
      .def_prop_ro("notes", of(&Calibration::notes), "a sentence each")
      .def(
          "calc_rest",
          [](const Calibrated& c, const Vector& q) { return c.values.calc_rest(*c.model, configuration_of(*c.model, "q", q.value)); },
          "q"_a, "rest at a posture, with the payload (n_a). q: (n_q), or joint positions (n_a).")
      .def(
          "calc_noise",
          [](const Calibrated& c, const std::optional<Vector>& touch, double seconds, int rest_rows) {
            return c.values.calc_noise(touch ? touch->value : Eigen::VectorXd::Zero(c.values.within.rows()), seconds, rest_rows);
          },
          nb::kw_only(), "touch"_a = nb::none(), "seconds"_a = 0.0, "rest_rows"_a = 1,
          R"(Noise of a torque less the mean of `rest_rows` rows, `seconds` after a touch, as TorqueNoise.

  touch: largest torque of each joint in the touch (n_a) [N m; N], or None where nothing has touched.)")
      .def("__repr__", [](const Calibrated& c) {
        return fmt::format("<stiction.Calibration: {} rows of {} records>", c.values.rows, c.values.records);
      });
  m.def(
      "calibrate", &calibrate, "model"_a, "q"_a, "tau"_a, nb::kw_only(), "t"_a = nb::none(), "records"_a = nb::none(),
      "touched"_a = nb::none(), "payload"_a = nb::none(), "same_posture"_a = sensing::CalibrationOptions{}.same_posture,
      "settle"_a = sensing::CalibrationOptions{}.settle, "unmeasured"_a = std::vector<std::variant<int, std::string>>(),
      R"(Offset, noise and drift of a robot's external torques, and a payload that it does not know of, from rows in which nothing touches it.

  q, tau: joint positions and torques as measured (rows, n_a). t: times [s] (rows). records: number of the record of each row (rows), or one record.
  touched: rows in which something touches the robot (rows), or None. They and those less than `settle` seconds after them are no rest, and say what a touch leaves.
  payload: "robot/link" that may carry one; it takes rest in three postures or more.
  same_posture: largest difference of joint positions of one posture.
  unmeasured: joints without a torque sensor, by index or name; their noise is given as 1 and their rest as 0.

Raises InvalidInput: sizes, no record with two rows, a torque that never changes, rows of which many are touched.)");
  nb::class_<sensing::SignCheck>(m, "SignCheck", "Which sign total torques have.")
      .def_ro("sign", &sensing::SignCheck::sign, "1: of the motors on the links; -1: the other one; 0: these are no total torques")
      .def_ro("factor", &sensing::SignCheck::factor, "of the torques that hold the robot against gravity")
      .def_ro("message", &sensing::SignCheck::message, "what it means, or what to do");
  m.def(
      "check_sign",
      [](const ModelPtr& model, const Matrix& q, const Matrix& tau) {
        return sensing::check_sign(*model, q.value.transpose(), tau.value.transpose());
      },
      "model"_a, "q"_a, "tau"_a, "The sign of total torques at rest, from gravity. q, tau: (rows, n_a).");
  m.def(
      "calc_holding_torques",
      [](const ModelPtr& model, const Vector& q) { return sensing::calc_holding_torques(*model, configuration_of(*model, "q", q.value)); },
      "model"_a, "q"_a, "Torques with which motors hold the robots against gravity (n_a) [N m; N]. q: (n_q), or joint positions (n_a).");
  def_pickle<sensing::Payload, sensing::Hysteresis, sensing::TorqueNoise, Calibrated, sensing::SignCheck>();
}

}  // namespace stiction::python
