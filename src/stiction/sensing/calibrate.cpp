#include "stiction/sensing/calibrate.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <map>

#include "stiction/core/invalid_input.hpp"
#include "stiction/core/quantile.hpp"
#include "stiction/sensing/few_rows.hpp"
#include "stiction/sensing/known_contacts.hpp"
#include "stiction/sensing/series_columns.hpp"
#include "stiction/sensing/torque_noise.hpp"

namespace stiction::sensing {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

constexpr double kTouched = 8;  // robust deviations from the median of the record above which a row counts as touched

void require_rows(const world::Model& model, const RestRows& rows) {
  const Index n = rows.tau.cols();
  if (n == 0) core::throw_invalid("tau", "no row at rest", "at least two rows of one record in which nothing touches the robot");
  if (rows.tau.rows() != model.n_a() || rows.q.rows() != model.n_a() || rows.q.cols() != n)
    core::throw_invalid("tau",
                        fmt::format("q of shape ({}, {}) and tau of shape ({}, {})", rows.q.cols(), rows.q.rows(), n, rows.tau.rows()),
                        fmt::format("(rows, {}) both", model.n_a()));
  core::require_finite("q", {rows.q.data(), static_cast<std::size_t>(rows.q.size())});
  core::require_finite("tau", {rows.tau.data(), static_cast<std::size_t>(rows.tau.size())});
  const auto count = static_cast<std::size_t>(n);
  if (!rows.times.empty() && rows.times.size() != count)
    core::throw_invalid("times", fmt::format("{} numbers", rows.times.size()), fmt::format("one for each row, {}", n));
  core::require_finite("times", rows.times);
  if (!rows.records.empty() && rows.records.size() != count)
    core::throw_invalid("records", fmt::format("{} numbers", rows.records.size()), fmt::format("one for each row, {}", n));
  if (rows.touched.empty()) return;
  if (rows.touched.size() != count)
    core::throw_invalid("touched", fmt::format("{} values", rows.touched.size()), fmt::format("one for each row, {}", n));
  if (rows.times.empty())
    core::throw_invalid("touched", "rows without times", "the times of all rows as well: they tell which rows follow a touch");
}

MatrixXd select_rows(const MatrixXd& all, const std::vector<int>& joints) {
  MatrixXd out(static_cast<Index>(joints.size()), all.cols());
  for (std::size_t i = 0; i < joints.size(); ++i) out.row(static_cast<Index>(i)) = all.row(joints[i]);
  return out;
}

using Records = std::vector<std::vector<int>>;  ///< rows of each record, in the order in which they come

struct FoundRecords {
  Records rest;                     ///< records without touched rows and rows not yet settled after a touch; none is empty
  std::vector<AfterTouch> touches;  ///< touches of each record that has any
};

FoundRecords find_records(const RestRows& rows, double settle) {
  Records rest, touched;
  std::map<int, std::size_t> number;
  for (int i = 0; i < static_cast<int>(rows.tau.cols()); ++i) {
    const auto row = static_cast<std::size_t>(i);
    const auto [at, is_new] = number.try_emplace(rows.records.empty() ? 0 : rows.records[row], rest.size());
    if (is_new) rest.emplace_back(), touched.emplace_back();
    (!rows.touched.empty() && rows.touched[row] ? touched : rest)[at->second].push_back(i);
  }
  FoundRecords out;
  for (std::size_t r = 0; r < rest.size(); ++r) {
    if (!touched[r].empty()) {
      out.touches.push_back(find_after_touch(rows.tau, rows.times, rest[r], touched[r], settle));
      rest[r] = out.touches.back().settled;
    }
    if (!rest[r].empty()) out.rest.push_back(std::move(rest[r]));
  }
  if (out.rest.empty())
    core::throw_invalid("touched", fmt::format("no row that is {} s or more after a touch", settle),
                        "rows at rest, before touches or long after them");
  return out;
}

VectorXd median_of(const MatrixXd& tau, const std::vector<int>& record) {
  VectorXd out(tau.rows());
  for (Index j = 0; j < tau.rows(); ++j) {
    std::vector<double> values;
    for (const int i : record) values.push_back(tau(j, i));
    out[j] = core::quantile(values, 0.5);
  }
  return out;
}

VectorXd mean_of(const MatrixXd& tau, const std::vector<int>& record) {
  VectorXd out = VectorXd::Zero(tau.rows());
  for (const int i : record) out += tau.col(i);
  return out / static_cast<double>(record.size());
}

/// Removes rows with a torque far from the others of their record, in records of at least five rows.
void leave_out_touched(const RestRows& rows, Records& records, Calibration& out) {
  constexpr std::size_t kFew = 5;
  constexpr double kNormal = 1.4826, kShare = 0.25;
  const Index n = rows.tau.rows();
  std::vector<std::vector<double>> deviations(static_cast<std::size_t>(n));
  std::vector<VectorXd> medians;
  for (const auto& record : records) {
    medians.push_back(median_of(rows.tau, record));
    if (record.size() < kFew) continue;
    for (const int i : record)
      for (Index j = 0; j < n; ++j) deviations[static_cast<std::size_t>(j)].push_back(std::abs(rows.tau(j, i) - medians.back()[j]));
  }
  if (deviations[0].empty()) return;
  VectorXd most(n);
  for (Index j = 0; j < n; ++j) most[j] = kTouched * kNormal * core::quantile(deviations[static_cast<std::size_t>(j)], 0.5);
  std::size_t looked_at = 0;
  for (std::size_t r = 0; r < records.size(); ++r) {
    if (records[r].size() < kFew) continue;
    looked_at += records[r].size();
    std::erase_if(records[r], [&](int i) {
      const Eigen::ArrayXd deviation = (rows.tau.col(i) - medians[r]).cwiseAbs();
      const bool touched = (most.array() > 0 && deviation > most.array()).any();
      if (touched) out.touched.push_back(i);
      return touched;
    });
  }
  if (static_cast<double>(out.touched.size()) > kShare * static_cast<double>(looked_at))
    core::throw_invalid("tau",
                        fmt::format("{} of {} rows whose torques are far from the others of their record, the first is row {}",
                                    out.touched.size(), looked_at, out.touched.front()),
                        "rows in which nothing touches the robot and it stands still");
  if (!out.touched.empty())
    out.notes.push_back(fmt::format("rows {} are left out: something seems to touch the robot there", fmt::join(out.touched, ", ")));
}

/// Correlations, shrunk by the share that the errors of few rows explain.
MatrixXd shrink(const MatrixXd& correlation, double freedom) {
  const Index n = correlation.rows();
  double error = 0, square = 0;
  for (Index i = 0; i < n; ++i)
    for (Index j = 0; j < i; ++j) {
      const double r = correlation(i, j);
      error += std::pow(1 - r * r, 2) / std::max(1.0, freedom - 1);
      square += r * r;
    }
  // Fewer rows than joints always correlate; so many keep no more of it than this.
  const double keep = square > 0 ? std::clamp(1 - error / square, 0.0, freedom / (1 + freedom)) : 0;
  MatrixXd out = keep * correlation;
  out.diagonal().setOnes();
  return out;
}

/// Σ of vectors about their means, from their sum of squares.
MatrixXd make_noise(const MatrixXd& squares, double freedom) {
  const VectorXd deviations = (squares.diagonal() / freedom).cwiseSqrt();
  const MatrixXd scale = deviations.cwiseInverse().asDiagonal();
  return calc_student_variance(freedom) *
         (deviations.asDiagonal() * shrink(scale * squares * scale / freedom, freedom) * deviations.asDiagonal());
}

void find_within(const world::Model& model, const RestRows& rows, const std::vector<int>& joints, const Records& records,
                 Calibration& out) {
  const Index n = rows.tau.rows();
  MatrixXd squares = MatrixXd::Zero(n, n);
  for (const auto& record : records) {
    if (record.empty()) continue;
    const VectorXd mean = mean_of(rows.tau, record);
    for (const int i : record) squares += (rows.tau.col(i) - mean) * (rows.tau.col(i) - mean).transpose();
    out.freedom += static_cast<int>(record.size()) - 1;
  }
  if (out.freedom < 1)
    core::throw_invalid("tau", fmt::format("{} row{} at rest, one of each record", out.rows, out.rows == 1 ? "" : "s"),
                        "two rows or more of one record; one row alone gives a rest, and says nothing of noise: pass noise= yourself");
  for (Index j = 0; j < n; ++j)
    if (!(squares(j, j) > 0))
      core::throw_invalid("tau",
                          fmt::format("the same torque of joint '{}' in all rows of each record",
                                      model.dofs()[static_cast<std::size_t>(model.n_vu() + joints[static_cast<std::size_t>(j)])].name),
                          "rows that were measured at different times; a joint without a torque sensor is `unmeasured`");
  if (out.freedom < n)
    out.notes.push_back(fmt::format(
        "noise is known from {} differences only, fewer than there are joints: record longer at rest. So little shows a contact from "
        "{:.3g} deviations on",
        out.freedom, calc_student_bound(out.freedom, kDeviations)));
  out.within = make_noise(squares, out.freedom);
}

bool is_same_posture(const RestRows& rows, const std::vector<int>& a, const std::vector<int>& b, double most) {
  return (rows.q.col(a.front()) - rows.q.col(b.front())).cwiseAbs().maxCoeff() <= most;
}

/// Groups records by posture, and computes the noise if the rest comes from another record of the posture.
void find_between(const RestRows& rows, const Records& records, double same, Calibration& out) {
  std::vector<std::vector<std::size_t>> postures;
  for (std::size_t r = 0; r < records.size(); ++r) {
    const auto found = std::find_if(postures.begin(), postures.end(),
                                    [&](const auto& p) { return is_same_posture(rows, records[p.front()], records[r], same); });
    if (found == postures.end())
      postures.push_back({r});
    else
      found->push_back(r);
  }
  out.postures = static_cast<int>(postures.size());
  const Index n = rows.tau.rows();
  MatrixXd squares = MatrixXd::Zero(n, n);
  int freedom = 0;
  for (const auto& posture : postures) {
    VectorXd mean = VectorXd::Zero(n);
    for (const std::size_t r : posture) mean += mean_of(rows.tau, records[r]) / static_cast<double>(posture.size());
    for (const std::size_t r : posture) {
      const VectorXd d = mean_of(rows.tau, records[r]) - mean;
      squares += d * d.transpose();
    }
    freedom += static_cast<int>(posture.size()) - 1;
  }
  if (freedom < 1) return;
  squares.diagonal() = squares.diagonal().cwiseMax(freedom * 1e-12);
  out.noise_between = out.within + 2 * make_noise(squares, freedom);
}

/// ½ (Δτ)² = σ₀² + ½ D Δt over pairs of rows of a record, by least squares.
void find_drift(const RestRows& rows, const Records& records, Calibration& out) {
  if (rows.times.empty()) return;
  const Index n = rows.tau.rows();
  double sum_t = 0, sum_tt = 0, count = 0, longest = 0;
  VectorXd sum_y = VectorXd::Zero(n), sum_ty = VectorXd::Zero(n);
  for (const auto& record : records)
    for (std::size_t a = 0; a < record.size(); ++a)
      for (std::size_t b = 0; b < a; b += 1 + record.size() / 64) {
        const double dt = std::abs(rows.times[static_cast<std::size_t>(record[a])] - rows.times[static_cast<std::size_t>(record[b])]);
        const VectorXd y = (rows.tau.col(record[a]) - rows.tau.col(record[b])).array().square();
        longest = std::max(longest, dt);
        sum_t += dt;
        sum_tt += dt * dt;
        sum_y += y;
        sum_ty += dt * y;
        ++count;
      }
  const double spread = count * sum_tt - sum_t * sum_t;
  if (!(spread > 1e-9 * count * sum_tt)) return;
  // A drift that stays below the noise even over the longest time cannot be detected.
  const VectorXd slope = (count * sum_ty - sum_t * sum_y) / spread, variance = 0.5 * (sum_y - slope * sum_t) / count;
  out.drift = (longest * slope.array() > variance.array()).select(slope, 0).cwiseMax(0).cwiseSqrt();
}

Eigen::Matrix<double, Eigen::Dynamic, 4> gravity_columns(const world::Model& model, VectorRef q, int body) {
  world::KinematicsWorkspace work(model);
  world::Kinematics kinematics;
  world::calc_kinematics(model, q, work, kinematics);
  Eigen::Matrix3Xd J_w, J_v;
  calc_link_jacobian(model, kinematics, body, J_w, J_v);
  const Vector3d g_L = kinematics.X_WB[static_cast<std::size_t>(body)].R.transpose() * model.scene().gravity;
  Eigen::Matrix<double, Eigen::Dynamic, 4> out(model.n_a(), 4);
  out.col(0) = J_v.transpose() * g_L;
  for (int k = 0; k < 3; ++k) out.col(1 + k) = J_w.transpose() * Vector3d::Unit(k).cross(g_L);
  return out;
}

/// Fits the offsets of all records by one offset per joint and a rigid body on a link, in units of the noise between records.
void find_payload(const world::Model& model, const RestRows& rows, const std::vector<int>& joints, const Records& records, int body,
                  Calibration& out) {
  constexpr int kPostures = 3;
  if (out.postures < kPostures) {
    out.notes.push_back(fmt::format("a payload takes rest in {} postures or more, these rows have {}", kPostures, out.postures));
    return;
  }
  const Index n = rows.tau.rows(), count = static_cast<Index>(records.size());
  const VectorXd scale = (out.noise_between.size() != 0 ? out.noise_between : out.within).diagonal().cwiseSqrt().cwiseInverse();
  MatrixXd A = MatrixXd::Zero(n * count, n + 4);
  VectorXd y(n * count);
  for (Index r = 0; r < count; ++r) {
    const auto& record = records[static_cast<std::size_t>(r)];
    const VectorXd q = place_robots(model, rows.q.col(record.front()));
    A.block(n * r, 0, n, n) = scale.asDiagonal();
    A.block(n * r, n, n, 4) = scale.asDiagonal() * select_rows(gravity_columns(model, q, body), joints);
    y.segment(n * r, n) = scale.asDiagonal() * mean_of(rows.tau, record);
  }
  const VectorXd lengths = A.colwise().norm().cwiseMax(1e-12);
  const Eigen::ColPivHouseholderQR<MatrixXd> qr(A * lengths.cwiseInverse().asDiagonal());
  constexpr double kRank = 1e-6;
  if (std::abs(qr.matrixR()(n + 3, n + 3)) < kRank) {
    out.notes.push_back(
        "these postures do not tell a payload from offsets of the sensors: record the rest in others, with the last links turned");
    return;
  }
  const VectorXd x = lengths.cwiseInverse().asDiagonal() * qr.solve(y);
  const double left = (A * x - y).squaredNorm() / static_cast<double>(std::max<Index>(1, n * count - n - 4));
  const MatrixXd covariance = (A.transpose() * A).ldlt().solve(MatrixXd::Identity(n + 4, n + 4)) * std::max(1.0, left);
  Payload payload{body, x[n], std::sqrt(covariance(n, n)), x.segment<3>(n + 1) / x[n]};
  constexpr double kDeviations = 3;
  if (std::abs(payload.mass) < kDeviations * payload.mass_deviation) {
    out.notes.push_back(fmt::format("no payload is seen: {:.3f} ± {:.3f} kg on '{}'", payload.mass, payload.mass_deviation,
                                    model.bodies()[static_cast<std::size_t>(body)].name));
    return;
  }
  out.payload = payload;
  out.rest = x.head(n);
  out.notes.push_back(fmt::format(
      "'{}' carries {:.3f} ± {:.3f} kg that the robot does not know of, at ({:.3f}, {:.3f}, {:.3f}) m{}",
      model.bodies()[static_cast<std::size_t>(body)].name, payload.mass, payload.mass_deviation, payload.centre_L.x(), payload.centre_L.y(),
      payload.centre_L.z(), payload.mass < 0 ? "; a negative mass means that the robot was told of too much, or that the sign is -1" : ""));
}

}  // namespace

VectorXd Calibration::calc_rest(const world::Model& model, VectorRef q) const {
  world::require_configuration(model, "q", q);
  if (!payload) return rest;
  const Eigen::Vector4d body(payload->mass, payload->mass * payload->centre_L.x(), payload->mass * payload->centre_L.y(),
                             payload->mass * payload->centre_L.z());
  return rest + gravity_columns(model, q, payload->body) * body;
}

TorqueNoise Calibration::calc_noise(VectorRef touch, double seconds, int rest_rows) const {
  core::require_size("touch", touch.size(), within.rows());
  core::require_finite("touch", {touch.data(), static_cast<std::size_t>(touch.size())});
  core::require_nonnegative("seconds", seconds);
  if (rest_rows < 1) core::throw_invalid("rest_rows", fmt::format("{}", rest_rows), "an integer ≥ 1");
  TorqueNoise out{(1 + 1 / static_cast<double>(rest_rows)) * within, VectorXd::Constant(within.rows(), freedom)};
  if (seconds >= hysteresis.settle || !(hysteresis.share > 0)) return out;
  for (Index j = 0; j < touch.size(); ++j) {
    const double white = out.covariance(j, j) / calc_student_variance(freedom), left = std::pow(hysteresis.share * touch[j], 2);
    out.freedom[j] = std::pow(white + left, 2) / (white * white / freedom + left * left / hysteresis.freedom);
    out.covariance(j, j) += calc_student_variance(hysteresis.freedom) * left;
  }
  return out;
}

namespace {

/// Expands Σ of the measured joints to all joints, with 1 for the others.
MatrixXd spread(const MatrixXd& some, const std::vector<int>& joints, Index n) {
  if (some.size() == 0) return some;
  MatrixXd out = MatrixXd::Identity(n, n);
  for (std::size_t i = 0; i < joints.size(); ++i)
    for (std::size_t j = 0; j < joints.size(); ++j) out(joints[i], joints[j]) = some(static_cast<Index>(i), static_cast<Index>(j));
  return out;
}

}  // namespace

Calibration calibrate(const world::Model& model, const RestRows& given, const CalibrationOptions& options) {
  require_rows(model, given);
  core::require_positive("same_posture", options.same_posture);
  core::require_positive("settle", options.settle);
  std::vector<int> joints = given.measured;
  if (joints.empty()) joints = joints_but(model.n_a(), {});
  RestRows rows = given;
  rows.tau = select_rows(given.tau, joints);
  Calibration out;
  out.rows = static_cast<int>(rows.tau.cols());
  auto [records, touches] = find_records(rows, options.settle);
  leave_out_touched(rows, records, out);
  for (AfterTouch& record : touches)
    std::erase_if(record.settled, [&](int i) { return std::find(out.touched.begin(), out.touched.end(), i) != out.touched.end(); });
  out.records = static_cast<int>(records.size());
  find_within(model, rows, joints, records, out);
  out.hysteresis = fit_hysteresis(rows.tau, touches, out.within.diagonal() / calc_student_variance(out.freedom), options.settle);
  out.rest = mean_of(rows.tau, records.back());
  out.noise = (1 + 1 / static_cast<double>(records.back().size())) * out.within;
  find_between(rows, records, options.same_posture, out);
  find_drift(rows, records, out);
  if (options.payload_body) find_payload(model, rows, joints, records, *options.payload_body, out);
  const Index n = model.n_a();
  const auto spread_vector = [&](const VectorXd& some) {
    VectorXd all = VectorXd::Zero(n);
    for (std::size_t i = 0; i < joints.size(); ++i) all[joints[i]] = some[static_cast<Index>(i)];
    return all;
  };
  out.rest = spread_vector(out.rest);
  if (out.drift.size() != 0) out.drift = spread_vector(out.drift);
  out.within = spread(out.within, joints, n);
  out.noise = spread(out.noise, joints, n);
  out.noise_between = spread(out.noise_between, joints, n);
  return out;
}

VectorXd calc_holding_torques(const world::Model& model, VectorRef q) {
  world::require_configuration(model, "q", q);
  world::KinematicsWorkspace work(model);
  world::Kinematics kinematics;
  world::calc_kinematics(model, q, work, kinematics);
  VectorXd out = VectorXd::Zero(model.n_a());
  Eigen::Matrix3Xd J_w, J_v;
  for (const world::Link& link : model.links()) {
    const auto& inertia = model.inertias()[static_cast<std::size_t>(link.body)];
    if (!(inertia.mass > 0)) continue;
    calc_link_jacobian(model, kinematics, link.body, J_w, J_v);
    const Vector3d force_L = -inertia.mass * (kinematics.X_WB[static_cast<std::size_t>(link.body)].R.transpose() * model.scene().gravity);
    out += J_v.transpose() * force_L + J_w.transpose() * inertia.p_BCom.cross(force_L);
  }
  return out;
}

SignCheck check_sign(const world::Model& model, const MatrixXd& q, const MatrixXd& tau) {
  require_rows(model, {.q = q, .tau = tau});
  double product = 0, square = 0, left = 0;
  for (Index i = 0; i < tau.cols(); ++i) {
    const VectorXd held = calc_holding_torques(model, place_robots(model, q.col(i)));
    product += held.dot(tau.col(i));
    square += held.squaredNorm();
  }
  SignCheck out;
  out.factor = square > 0 ? product / square : 0;
  for (Index i = 0; i < tau.cols(); ++i)
    left += (tau.col(i) - out.factor * calc_holding_torques(model, place_robots(model, q.col(i)))).squaredNorm();
  const double share = tau.squaredNorm() > 0 ? 1 - left / tau.squaredNorm() : 0;
  constexpr double kFactor = 0.5, kShare = 0.5;
  if (std::abs(out.factor) < kFactor || share < kShare) {
    out.message = fmt::format(
        "these torques are {:.2f} of those that hold the robot against gravity, so they are external ones, whose sign rest does not tell: "
        "push a joint by "
        "hand in the direction of its angle; its torque must grow",
        out.factor);
    return out;
  }
  out.sign = out.factor > 0 ? 1 : -1;
  out.message =
      out.sign > 0 ? "these are the torques of the motors on the links: external torques are those of gravity and motion less these"
                   : "these are the torques of the motors with the other sign: external torques are those of gravity and motion plus these";
  return out;
}

}  // namespace stiction::sensing
