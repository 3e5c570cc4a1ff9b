#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <vector>

#include "stiction/sensing/link_torque.hpp"

namespace stiction::sensing {

/// Deviations of noise that are passed by chance at one in 16 000 torques.
inline constexpr double kDeviations = 4;

/// What is known of torques as a sensor gives them: τ = sign (measured − rest) + noise.
struct TorqueModel {
  /// Σ of the noise of all joints (n_a × n_a) [(N·m)²], symmetric, positive definite on the joints that are measured; empty: the same noise in every joint.
  Eigen::MatrixXd covariance{};
  Eigen::VectorXd rest{};  ///< measured where nothing touches (n_a) [N·m; N]; empty: 0
  double sign = 1;         ///< −1: of torques that the robot makes against its surroundings, as libfranka gives them; else 1
  /// Deviations of its noise from which on the torque of a joint shows a contact (n_a), > 0; empty: kDeviations. More where noise is known from few rows: calc_student_bound().
  Eigen::VectorXd deviations{};
  std::vector<int> unmeasured{};  ///< joints without a torque sensor, by their index in u: their torques are unknown, and not 0

  bool is_plain() const { return covariance.size() == 0 && rest.size() == 0 && deviations.size() == 0 && sign == 1 && unmeasured.empty(); }
  /// @throws core::InvalidInput naming the field: sizes, not finite, a covariance that is not symmetric and positive definite, no measured joint
  void validate(int n_a) const;
};

/// Σ of one number, n_a numbers or an n_a × n_a matrix. @param noise  standard deviations (n_a), or Σ itself (n_a × n_a)
/// @returns Σ; empty where all joints have the same noise, which is then `uniform`  @throws core::InvalidInput
Eigen::MatrixXd make_covariance(const Eigen::MatrixXd& noise, int n_a, double& uniform);

/// Measured torques in coordinates in which each has the same noise s and none depends on another:
///     τ_s = W (sign (measured − rest)) ,   W Σ_m Wᵀ = s² 1 ,   s = |Σ_m|^{1/2m}                                          (Y.17)
/// with Σ_m the rows and columns of Σ of the m measured joints, so that residuals stay in newton metres and where all joints have one noise W is 1.
class WhitenedTorques {
 public:
  /// @param noise  of every joint where the model has no covariance  @param model_error  share of ‖τ‖ by which the model of the contact may be off: added to Σ
  /// No heap use from the second call on.
  void assign(const TorqueModel& model, VectorRef measured, double noise, double model_error);

  const Eigen::VectorXd& tau() const { return tau_; }            ///< (m)
  const Eigen::VectorXd& external() const { return external_; }  ///< sign (measured − rest) (n_a) [N·m; N]
  double noise() const { return noise_; }                        ///< s, of each of them
  bool is_identity() const { return !whitens_; }
  /// Of J_w or J_v (3 × n_a), its columns as those of τ_s. Nothing to do where is_identity().
  void apply(Eigen::Matrix3Xd& J) const;

  /// The measured torque that is largest against what its noise may make: its joint, its size, its standard deviation, and how many of these show a contact.
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
