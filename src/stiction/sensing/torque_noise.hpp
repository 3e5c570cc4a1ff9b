#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <vector>

#include "stiction/sensing/link_torque.hpp"

namespace stiction::sensing {

/// Threshold in standard deviations of noise; noise exceeds it in one of 16 000 torques.
inline constexpr double kDeviations = 4;

/// Model of the measured torques: τ = sign (measured − rest) + noise.
struct TorqueModel {
  /// Σ of the noise of all joints (n_a × n_a) [(N·m)²], symmetric, positive definite on the measured joints; empty: equal noise in all
  /// joints.
  Eigen::MatrixXd covariance{};
  Eigen::VectorXd rest{};  ///< measured torque without contact (n_a) [N·m; N]; empty: 0
  double sign = 1;         ///< −1: measured torques are those of the robot on its surroundings, as in libfranka; otherwise 1
  /// Number of noise deviations above which the torque of a joint shows a contact (n_a), > 0; empty: kDeviations. Larger if the noise is
  /// known from few rows: calc_student_bound().
  Eigen::VectorXd deviations{};
  std::vector<int> unmeasured{};  ///< joints without a torque sensor, as indices into u: their torques are unknown, not 0

  bool is_plain() const { return covariance.size() == 0 && rest.size() == 0 && deviations.size() == 0 && sign == 1 && unmeasured.empty(); }
  /// @throws core::InvalidInput naming the field: sizes, not finite, a covariance that is not symmetric and positive definite, no measured joint
  void validate(int n_a) const;
};

/// Makes Σ from standard deviations (n_a), or from Σ itself (n_a × n_a). A vector and a matrix differ by their types, since those of one
/// joint have the same size.
/// @returns Σ; empty if all joints have the same noise, which is then in `uniform`  @throws core::InvalidInput
Eigen::MatrixXd make_covariance(const Eigen::VectorXd& deviations, int n_a, double& uniform);
Eigen::MatrixXd make_covariance(const Eigen::MatrixXd& covariance, int n_a, double& uniform);

/// Whitened torques: measured torques in coordinates with equal and independent noise s:
///     τ_s = W (sign (measured − rest)) ,   W Σ_m Wᵀ = s² 1 ,   s = |Σ_m|^{1/2m}                                          (Y.17)
/// with Σ_m the rows and columns of Σ of the m measured joints, so that residuals stay in newton metres, and W = 1 if all joints have equal
/// noise.
class WhitenedTorques {
 public:
  /// Computes the whitened torques. @param noise  of every joint if the model has no covariance  @param model_error  error of the contact
  /// model as a share of ‖τ‖, added to Σ
  /// No heap use from the second call on.
  void assign(const TorqueModel& model, VectorRef measured, double noise, double model_error);

  const Eigen::VectorXd& tau() const { return tau_; }            ///< (m)
  const Eigen::VectorXd& external() const { return external_; }  ///< sign (measured − rest) (n_a) [N·m; N]
  double noise() const { return noise_; }                        ///< s, the noise of each whitened torque
  bool is_identity() const { return !whitens_; }
  /// Transforms the columns of J_w or J_v (3 × n_a) to the coordinates of τ_s. Does nothing if is_identity().
  void apply(Eigen::Matrix3Xd& J) const;

  /// The measured torque that is largest relative to its threshold: its joint, its size, its noise, and the number of noise deviations that
  /// show a contact.
  struct Largest {
    int joint = -1;
    double torque = 0, noise = 0, deviations = kDeviations;
  };
  const Largest& largest() const { return largest_; }

 private:
  Eigen::VectorXd external_, tau_;
  std::vector<int> joints_;  ///< measured
  Eigen::MatrixXd sigma_;
  Eigen::LLT<Eigen::MatrixXd> factor_;
  double noise_ = 1;
  bool whitens_ = false;
  Largest largest_;
  void find_joints(const TorqueModel& model);
  void whiten(const TorqueModel& model, double noise, double model_error);
};

}  // namespace stiction::sensing
