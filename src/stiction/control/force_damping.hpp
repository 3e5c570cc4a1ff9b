#pragma once

namespace stiction::control {

/// Options of ForceDamping, which slows the command down when measured forces differ from the prediction. None of these values is
/// published. w and α are stated for ticks of `period`; for other ticks they are converted so that the command slows down as much per
/// second.
struct ForceDampingOptions {
  double largest = 5.0;      ///< w_max of (5.29) [-], ≥ 0
  double force_scale = 5.0;  ///< a of (5.28) [N], > 0: an error of a gives (1 − 1/e) w_max
  double forget_rate = 0.2;  ///< α of (5.29) [-], in (0, 1]
  double period = 0.005;     ///< tick for which `largest` and `forget_rate` are stated [s], > 0; the value is that of the thesis
  bool printed = false;   ///< true: (5.29) as printed, an average of two ticks; false: the low-pass that the text of the thesis describes
  void validate() const;  ///< @throws core::InvalidInput naming the field
};

/// Computes the damping w of (5.24):  e = 1 − exp(−‖λ_pred − λ_est‖_∞ / a)  (5.28, printed without the sign of the exponent),
/// ē ← α e + (1 − α) ē ,  w = w_max ē ,
/// for ticks of h instead of the `period` T:  α → 1 − (1 − α)^(h/T) ,  w_max → w_max T/h .                                                        (C.6)
class ForceDamping {
 public:
  ForceDamping() = default;
  explicit ForceDamping(const ForceDampingOptions& options) : options_(options) {}

  /// @param error  ‖λ_pred − λ_est‖_∞ of the contacts that were predicted [N]; 0 if none was predicted    @returns w [-]
  /// @param dt  duration of the tick [s], > 0
  double update(double error, double dt);
  void reset() { filtered_ = last_ = 0; }

 private:
  ForceDampingOptions options_;
  double filtered_ = 0, last_ = 0;
};

}  // namespace stiction::control
