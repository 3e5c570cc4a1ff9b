#pragma once

#include <string>
#include <utility>

#include "stiction/execution/closed_loop/driver.hpp"
#include "stiction/world/object_space.hpp"

namespace stiction::execution {

/// Checks the measurements of a plant for plausibility: they must fit the model, the clock must go on, and objects must be seen and must not jump.
class DriverLink {
 public:
  /// @param tick     time between two measurements [s]
  /// @param silence  longest time for which the clock may stand still, or be behind or ahead between two commands [s]; objects unseen for longer are away
  /// @param absence  longest time for which objects may be away [s]
  DriverLink(Driver& plant, const world::Model& model, double tick, double silence, double absence)
      : plant_(plant), model_(model), space_(model), tick_(tick), silence_(silence), absence_(absence) {}

  /// Takes the newest measurement. Measurements and poses that are older than the known ones are ignored. Objects cannot move by more than their length, or a
  /// quarter of a turn, within a tick. If they are reported so far away, they are believed to be where they were last seen, until they were seen near one other
  /// place for `silence`. @returns false if a check failed; reason() says which
  bool read();
  /// True if the objects were seen within `silence`, at plausible places.
  bool sees_objects() const { return measured_.time - measured_.object_time <= silence_; }
  /// True if objects were put elsewhere, or were away, since the last call.
  bool take_displaced() { return std::exchange(displaced_, false); }
  /// Announces a time without commands, as while the planner works: the clock of the plant may be ahead by any amount at the next read().
  void pause() { paused_ = true; }
  /// Sends a command (n_a) for one tick. @returns false if the plant did not take it; see reason()
  bool command(VectorRef u);

  const Measurement& measured() const { return measured_; }
  const std::string& reason() const { return reason_; }

 private:
  bool fail(std::string reason);
  std::string with_message(std::string text) const;
  bool take(const Measurement& given);
  void keep_objects_in_place();
  double share_of_jump(const Eigen::VectorXd& from) const;
  bool is_put_elsewhere();

  Driver& plant_;
  const world::Model& model_;
  world::ObjectSpace space_;
  double tick_, silence_, absence_;
  Measurement measured_;
  Eigen::VectorXd seen_;       ///< last plausible objects' configuration (n_qu); empty: not yet seen
  Eigen::VectorXd elsewhere_;  ///< implausible place reported since elsewhere_time_ (n_qu); empty: the reports are plausible
  double seen_time_ = 0, elsewhere_time_ = 0, still_ = 0;
  bool displaced_ = false;
  bool paused_ = false;  ///< pause() was called since the last read()
  double jump_ = 0;      ///< jump of the last measurement, as a multiple of the plausible motion
  std::string reason_;
};

}  // namespace stiction::execution
