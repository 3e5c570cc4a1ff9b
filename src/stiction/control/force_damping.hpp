#pragma once

namespace stiction::control {

/// How far forces that are not as predicted slow the command down. None of these numbers is published. w and α belong to ticks of `period`; at others they are
/// what slows the command down as much per second.
struct ForceDampingOptions {
  double largest = 5.0;      ///< w_max of (5.29) [-], ≥ 0
  double force_scale = 5.0;  ///< a of (5.28) [N], > 0: an error of a makes 1 − 1/e of w_max
  double forget_rate = 0.2;  ///< α of (5.29) [-], in (0, 1]
  double period = 0.005;     ///< tick for which `largest` and `forget_rate` are stated [s], > 0: that of the thesis
  bool printed = false;      ///< (5.29) as printed, an average of two ticks; else a low-pass, as the text calls it
  void validate() const;     ///< @throws core::InvalidInput naming the field
};

/// w of (5.24):  e = 1 − exp(−‖λ_pred − λ_est‖_∞ / a)  (5.28, whose exponent is printed without its sign),  ē ← α e + (1 − α) ē ,  w = w_max ē ,
/// for ticks of h instead of the `period` T:  α → 1 − (1 − α)^(h/T) ,  w_max → w_max T/h .                                                        (C.6)
class ForceDamping {
 public:
  ForceDamping() = default;
  explicit ForceDamping(const ForceDampingOptions& options) : options_(options) {}

  /// @param error  ‖λ_pred − λ_est‖_∞ of the contacts that were predicted [N]; 0 without one    @returns w
  /// @param dt  of the tick [s], > 0
  double update(double error, double dt);
  void reset() { filtered_ = last_ = 0; }

 private:
  ForceDampingOptions options_;
  double filtered_ = 0, last_ = 0;
};

}  // namespace stiction::control
