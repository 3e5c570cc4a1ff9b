#include "stiction/sensing/scenario.hpp"

#include "stiction/sensing/calibrate.hpp"
#include "stiction/sensing/few_rows.hpp"
#include "stiction/sensing/series_columns.hpp"

namespace stiction::sensing {

std::vector<ContactPoint> Scenario::contacts_at(std::size_t moment) const {
  if (series.pushed.empty()) return contacts;
  std::vector<ContactPoint> out;
  for (const int push : series.pushed[moment])
    out.push_back(contacts[static_cast<std::size_t>(poke->pushes[static_cast<std::size_t>(push)].contact)]);
  return out;
}

const BaseWrench* Scenario::base_at(std::size_t moment) const {
  if (!series.base.empty()) return &series.base[moment];
  return base ? &*base : nullptr;
}

ContactSetOptions Scenario::set_options() const {
  ContactSetOptions out;
  out.sense = options;
  out.max_contacts = max_contacts;
  return out;
}

void set_rest(Scenario& scenario, std::span<const Eigen::Index> moments, bool noise) {
  const world::Model& model = scenario.sensor->model();
  const auto n = static_cast<Eigen::Index>(moments.size());
  RestRows rows{.q = Eigen::MatrixXd(model.n_a(), n), .tau = Eigen::MatrixXd(model.n_a(), n)};
  for (Eigen::Index i = 0; i < n; ++i) {
    const Eigen::Index moment = moments[static_cast<std::size_t>(i)];
    rows.q.col(i) = scenario.series.q.col(moment);
    rows.tau.col(i) = scenario.series.tau.col(moment);
    rows.times.push_back(scenario.series.times[static_cast<std::size_t>(moment)]);
  }
  TorqueModel& torques = scenario.options.torques;
  rows.measured = joints_but(model.n_a(), torques.unmeasured);
  torques.rest = rows.tau.rowwise().mean();
  if (!noise) return;
  const Calibration calibration = calibrate(model, rows);
  torques.rest = calibration.rest;
  torques.covariance = calibration.noise;
  torques.deviations = Eigen::VectorXd::Constant(model.n_a(), calc_student_bound(calibration.freedom, kDeviations));
  scenario.series.notes.insert(scenario.series.notes.end(), calibration.notes.begin(), calibration.notes.end());
}

}  // namespace stiction::sensing
