#pragma once

#include <string>
#include <utility>

#include "stiction/execution/closed_loop/driver.hpp"
#include "stiction/world/object_space.hpp"

namespace stiction::execution {

/// A plant and what is believed of it: measurements that fit, a clock that goes on, objects that are seen and do not jump.
class DriverLink {
 public:
  /// @param tick     between two measurements [s]
  /// @param silence  for so long the clock may stand still, or be behind or ahead between two commands [s]; objects that were not seen for longer are away
  /// @param absence  for so long objects may be away [s]
  DriverLink(Driver& plant, const world::Model& model, double tick, double silence, double absence)
      : plant_(plant), model_(model), space_(model), tick_(tick), silence_(silence), absence_(absence) {}

  /// Takes the newest measurement; one that is older than what is known is left out, and so are poses that are older. Objects that are farther than their
  /// length, or a quarter of a turn, from where they were last seen cannot be there within a tick: they stay where they were seen, until they were seen near
  /// one other place for the silence. False: reason() says what is wrong.
  bool read();
  /// Objects were seen within the silence, where they can be.
  bool sees_objects() const { return measured_.time - measured_.object_time <= silence_; }
  /// Objects were put elsewhere since the last call, or were away.
  bool take_displaced() { return std::exchange(displaced_, false); }
  /// Time passes without commands, as while the planner works: the clock of the plant may be any amount ahead at the next read().
  void pause() { paused_ = true; }
  /// False: reason() says that it was not taken.
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
  Eigen::VectorXd seen_;       ///< objects, where they were seen and can have been (n_qu); empty: not yet
  Eigen::VectorXd elsewhere_;  ///< where they were reported since elsewhere_time_, and cannot have got to (n_qu); empty: they are believed
  double seen_time_ = 0, elsewhere_time_ = 0, still_ = 0;
  bool displaced_ = false;
  bool paused_ = false;  ///< since the last read()
  double jump_ = 0;      ///< of the last measurement, in what is believed
  std::string reason_;
};

}  // namespace stiction::execution
