#pragma once

#include <Eigen/Core>

#include "stiction/core/random.hpp"
#include "stiction/sensing/contact_rows.hpp"
#include "stiction/simulation/momentum_observer.hpp"

namespace stiction::execution {

/// How well a force and moment sensor under the base of an arm measures what contacts do to the arm. Standard deviations of each component.
struct BaseSensorOptions {
  double force_noise = 1;     ///< white, as it is given [N], > 0
  double moment_noise = 0.1;  ///< the same [N·m], > 0
  double force_offset = 0;    ///< of the sensor, and of masses and accelerations that are not as thought [N], ≥ 0
  double moment_offset = 0;   ///< the same [N·m], ≥ 0
  void validate() const;      ///< @throws core::InvalidInput naming the field
};

using Vector6 = Eigen::Matrix<double, 6, 1>;

/// Such a sensor in the simulation: noise as white noise is behind the lag of a MomentumObserver, and offsets that change with posture as those of its torques do.
/// Tests: tests/execution/base_sensor_test.cpp
class BaseSensor {
 public:
  /// @param joints  n_a   @param period  h [s], > 0   @param torques  whose lag, distance over which offsets change, and seed count here, too
  BaseSensor(Eigen::Index joints, double period, const simulation::ObserverOptions& torques, const BaseSensorOptions& options);

  /// One period. @param wrench_W  DrivenPlant::base_wrench() at its end   @param q  joint positions (n_a)
  const sensing::BaseWrench& update(const Vector6& wrench_W, const Eigen::Ref<const Eigen::VectorXd>& q);

 private:
  double gain_;
  Vector6 white_, cosine_, sine_, noise_ = Vector6::Zero();  ///< deviations before the lag; of offsets; noise of now
  Eigen::MatrixXd waves_;                                    ///< (6 × n_a) [1/rad; 1/m]
  core::Random random_;
  sensing::BaseWrench measured_;
};

}  // namespace stiction::execution
