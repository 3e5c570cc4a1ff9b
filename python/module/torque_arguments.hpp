#pragma once

#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "sensor.hpp"
#include "stiction/core/invalid_input.hpp"
#include "stiction/sensing/few_rows.hpp"
#include "stiction/sensing/sense.hpp"

namespace stiction::python {

using NoiseArgument = std::variant<double, Vector, Matrix>;
using FreedomArgument = std::optional<std::variant<double, Vector>>;
using RestArgument = std::variant<Calibrated, Vector>;
using JointArgument = std::variant<int, std::string>;

/// What is known of torques, as it is given. Without a configuration a payload of the calibration is left out.
struct TorqueArguments {
  const NoiseArgument& noise;
  const FreedomArgument& freedom;
  const std::optional<RestArgument>& rest;
  int sign;
  const std::vector<JointArgument>& unmeasured;
};

inline void set_torques(const world::Model& model, const TorqueArguments& given, sensing::SenseOptions& options) {
  const int n = static_cast<int>(model.n_a());
  if (const auto* number = std::get_if<double>(&given.noise))
    options.noise = *number;
  else if (const auto* vector = std::get_if<Vector>(&given.noise))
    options.torques.covariance = sensing::make_covariance(vector->value, n, options.noise);
  else
    options.torques.covariance = sensing::make_covariance(std::get<Matrix>(given.noise).value, n, options.noise);
  if (given.rest) {
    if (const auto* vector = std::get_if<Vector>(&*given.rest))
      options.torques.rest = vector->value;
    else
      options.torques.rest = std::get<Calibrated>(*given.rest).values.rest;
  }
  if (given.freedom) {
    Eigen::VectorXd freedom = std::holds_alternative<double>(*given.freedom)
                                  ? Eigen::VectorXd::Constant(n, std::get<double>(*given.freedom))
                                  : std::get<Vector>(*given.freedom).value;
    for (const double x : freedom) core::require_positive("freedom", x);
    options.torques.deviations = freedom.unaryExpr([](double x) { return sensing::calc_student_bound(x, sensing::kDeviations); });
  }
  options.torques.sign = given.sign;
  for (const JointArgument& joint : given.unmeasured)
    options.torques.unmeasured.push_back(std::holds_alternative<int>(joint) ? std::get<int>(joint)
                                                                            : model.joint_index(std::get<std::string>(joint)));
  options.torques.validate(n);
}

}  // namespace stiction::python
