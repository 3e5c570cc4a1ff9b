#include "stiction/sensing/torque_noise.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "stiction/core/invalid_input.hpp"

namespace stiction::sensing {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

MatrixXd select(const MatrixXd& matrix, const std::vector<int>& joints) {
  const auto m = static_cast<Index>(joints.size());
  MatrixXd out(m, m);
  for (Index i = 0; i < m; ++i)
    for (Index j = 0; j < m; ++j) out(i, j) = matrix(joints[static_cast<std::size_t>(i)], joints[static_cast<std::size_t>(j)]);
  return out;
}

std::vector<int> measured_joints(const std::vector<int>& unmeasured, int n_a) {
  std::vector<int> out;
  for (int j = 0; j < n_a; ++j)
    if (std::find(unmeasured.begin(), unmeasured.end(), j) == unmeasured.end()) out.push_back(j);
  return out;
}

void require_covariance(const MatrixXd& sigma, const std::vector<int>& joints) {
  core::require_finite("noise", {sigma.data(), static_cast<std::size_t>(sigma.size())});
  constexpr double kAsymmetry = 1e-9, kLeast = 1e-12;
  if ((sigma - sigma.transpose()).cwiseAbs().maxCoeff() > kAsymmetry * sigma.cwiseAbs().maxCoeff())
    core::throw_invalid("noise", "a covariance that is not symmetric", "a symmetric positive definite matrix [(N m)²]");
  for (const int j : joints)
    if (!(sigma(j, j) > 0))
      core::throw_invalid("noise", fmt::format("a variance of {} in joint {}", sigma(j, j), j),
                          "variances > 0 of all joints that are measured");
  // Of correlations, so that joints whose noises differ by orders of magnitude are no error.
  const MatrixXd part = select(sigma, joints);
  const VectorXd scale = part.diagonal().cwiseSqrt().cwiseInverse();
  const MatrixXd correlation = scale.asDiagonal() * part * scale.asDiagonal();
  const double least = Eigen::SelfAdjointEigenSolver<MatrixXd>(correlation, Eigen::EigenvaluesOnly).eigenvalues()[0];
  if (!(least > kLeast))
    core::throw_invalid("noise", fmt::format("a covariance whose correlations have the eigenvalue {:.3g}", least),
                        "a positive definite matrix [(N m)²]; of fewer rows at rest than joints take the standard deviations alone");
}

[[noreturn]] void refuse_shape(const MatrixXd& noise, int n_a) {
  core::throw_invalid("noise", fmt::format("shape ({}, {})", noise.rows(), noise.cols()),
                      fmt::format("one number, {} standard deviations, or a covariance of shape ({}, {})", n_a, n_a, n_a));
}

}  // namespace

void TorqueModel::validate(int n_a) const {
  for (const int j : unmeasured)
    if (j < 0 || j >= n_a) core::throw_invalid("unmeasured", fmt::format("joint {}", j), fmt::format("joints from 0 to {}", n_a - 1));
  const std::vector<int> joints = measured_joints(unmeasured, n_a);
  if (joints.empty()) core::throw_invalid("unmeasured", "all joints", "at least one joint whose torque is measured");
  if (sign != 1 && sign != -1) core::throw_invalid("sign", fmt::format("{}", sign), "1 or -1");
  if (rest.size() != 0) {
    core::require_size("rest", rest.size(), n_a);
    core::require_finite("rest", {rest.data(), static_cast<std::size_t>(rest.size())});
  }
  if (deviations.size() != 0) {
    core::require_size("deviations", deviations.size(), n_a);
    for (const double x : deviations) core::require_positive("deviations", x);
  }
  if (covariance.size() == 0) return;
  if (covariance.rows() != n_a || covariance.cols() != n_a)
    core::throw_invalid("noise", fmt::format("a matrix of shape ({}, {})", covariance.rows(), covariance.cols()),
                        fmt::format("({}, {})", n_a, n_a));
  require_covariance(covariance, joints);
}

MatrixXd make_covariance(const VectorXd& deviations, int n_a, double& uniform) {
  if (deviations.size() != n_a) refuse_shape(deviations, n_a);
  core::require_finite("noise", {deviations.data(), static_cast<std::size_t>(deviations.size())});
  for (Index j = 0; j < n_a; ++j)
    if (!(deviations[j] > 0)) core::throw_invalid(fmt::format("noise[{}]", j), fmt::format("{}", deviations[j]), "a number > 0 [N m]");
  if ((deviations.array() == deviations[0]).all()) {
    uniform = deviations[0];
    return {};
  }
  return deviations.array().square().matrix().asDiagonal();
}

MatrixXd make_covariance(const MatrixXd& covariance, int n_a, double& uniform) {
  if (covariance.rows() != n_a || covariance.cols() != n_a) refuse_shape(covariance, n_a);
  require_covariance(covariance, measured_joints({}, n_a));
  if (covariance.isApprox(covariance(0, 0) * MatrixXd::Identity(n_a, n_a), 0)) {
    uniform = std::sqrt(covariance(0, 0));
    return {};
  }
  return covariance;
}

void WhitenedTorques::find_joints(const TorqueModel& model) {
  const auto n = static_cast<int>(external_.size());
  joints_.clear();
  for (int j = 0; j < n; ++j)
    if (std::find(model.unmeasured.begin(), model.unmeasured.end(), j) == model.unmeasured.end()) joints_.push_back(j);
}

void WhitenedTorques::assign(const TorqueModel& model, VectorRef measured, double noise, double model_error) {
  external_ = measured;
  if (model.rest.size() != 0) external_ -= model.rest;
  if (model.sign < 0) external_ = -external_;
  find_joints(model);
  for (const int j : model.unmeasured) external_[j] = 0;
  largest_ = {};
  double most = -1;
  for (const int j : joints_) {
    const double sigma = model.covariance.size() == 0 ? noise : std::sqrt(model.covariance(j, j)), size = std::abs(external_[j]);
    const double deviations = model.deviations.size() == 0 ? kDeviations : model.deviations[j];
    if (!(size / (sigma * deviations) > most)) continue;
    most = size / (sigma * deviations);
    largest_ = {j, size, sigma, deviations};
  }
  whitens_ = model.covariance.size() != 0 || !model.unmeasured.empty();
  if (whitens_) return whiten(model, noise, model_error);
  noise_ = noise;
  tau_ = external_;
}

void WhitenedTorques::whiten(const TorqueModel& model, double noise, double model_error) {
  const auto m = static_cast<Index>(joints_.size());
  tau_.resize(m);
  sigma_.setZero(m, m);
  for (Index i = 0; i < m; ++i) {
    const int joint = joints_[static_cast<std::size_t>(i)];
    tau_[i] = external_[joint];
    if (model.covariance.size() == 0) continue;
    for (Index j = 0; j < m; ++j) sigma_(i, j) = model.covariance(joint, joints_[static_cast<std::size_t>(j)]);
  }
  if (model.covariance.size() == 0) sigma_.diagonal().setConstant(noise * noise);
  factor_.compute(sigma_);
  double log_scale = 0;
  for (Index i = 0; i < m; ++i) log_scale += std::log(factor_.matrixLLT()(i, i));
  noise_ = std::exp(log_scale / static_cast<double>(m));
  if (model.covariance.size() != 0) {
    sigma_.diagonal().array() += model_error * model_error * tau_.squaredNorm() / static_cast<double>(m);
    factor_.compute(sigma_);
  }
  factor_.matrixL().solveInPlace(tau_);
  tau_ *= noise_;
}

void WhitenedTorques::apply(Eigen::Matrix3Xd& J) const {
  if (is_identity()) return;
  const auto m = static_cast<Index>(joints_.size());
  Eigen::Matrix<double, Eigen::Dynamic, 3> rows(m, 3);
  for (Index i = 0; i < m; ++i) rows.row(i) = J.col(joints_[static_cast<std::size_t>(i)]).transpose();
  factor_.matrixL().solveInPlace(rows);
  J.resize(3, m);
  J = noise_ * rows.transpose();
}

}  // namespace stiction::sensing
