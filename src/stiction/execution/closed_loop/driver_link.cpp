#include "stiction/execution/closed_loop/driver_link.hpp"

#include <fmt/format.h>

#include <numbers>

#include "stiction/core/invalid_input.hpp"
#include "stiction/world/model.hpp"
#include "stiction/world/scales.hpp"

namespace stiction::execution {

bool DriverLink::fail(std::string reason) {
  reason_ = std::move(reason);
  return false;
}

std::string DriverLink::with_message(std::string text) const {
  const std::string message = plant_.message();
  return message.empty() ? text : text + ": " + message;
}

bool DriverLink::take(const Measurement& given) {
  try {
    world::require_configuration(model_, "q", given.q);
    core::require_size("u", given.u.size(), model_.n_a());
    core::require_finite("u", {given.u.data(), static_cast<std::size_t>(given.u.size())});
    core::require_finite("time", given.time);
    core::require_finite("object_time", given.object_time);
  } catch (const core::InvalidInput& error) {
    return fail(fmt::format("the plant gave a measurement that cannot be: {}", error.what()));
  }
  if (measured_.q.size() == 0) return measured_ = given, true;  // the first measurement
  const double passed = given.time - measured_.time;
  if (passed < -silence_ || (passed > silence_ && !paused_))
    return fail(fmt::format("the clock of the plant went from {:.3f} s to {:.3f} s between two commands", measured_.time, given.time));
  if (passed > 0 && given.object_time > given.time + silence_)
    return fail(fmt::format("the plant gave a measurement that cannot be: object_time: got {:.3f} s, expected at most its time, {:.3f} s",
                            given.object_time, given.time));
  paused_ = false;
  still_ = passed > 0 ? 0 : still_ + tick_;
  if (passed < 0) return true;  // a late message: the known measurement is newer
  const Measurement before = std::exchange(measured_, given);
  if (given.object_time < before.object_time) {
    measured_.q.head(model_.n_qu()) = before.q.head(model_.n_qu());
    measured_.object_time = before.object_time;
  }
  return true;
}

/// Largest displacement of an object from its configuration in `from` (n_qu), as a multiple of the plausible motion in a tick.
double DriverLink::share_of_jump(const Eigen::VectorXd& from) const {
  Eigen::VectorXd moved(model_.n_vu());
  space_.error(from.data(), measured_.q.data(), moved.data());
  double out = 0;
  for (int i = 0; i < static_cast<int>(model_.objects().size()); ++i) {
    const world::ObjectInfo& object = model_.objects()[static_cast<std::size_t>(i)];
    Eigen::VectorXd alone = Eigen::VectorXd::Zero(model_.n_vu());
    alone.segment(object.v_begin, object.n_v) = moved.segment(object.v_begin, object.n_v);
    out = std::max(out, world::largest_share(model_, alone, model_.scales().object(i).length, std::numbers::pi / 2));
  }
  return out;
}

/// True if the objects were reported near one other place for `silence`.
bool DriverLink::is_put_elsewhere() {
  if (elsewhere_.size() == 0 || share_of_jump(elsewhere_) > 1) elsewhere_time_ = measured_.object_time;
  elsewhere_ = measured_.q.head(model_.n_qu());
  return measured_.object_time - elsewhere_time_ >= silence_;
}

void DriverLink::keep_objects_in_place() {
  const Eigen::Index n = model_.n_qu();
  jump_ = seen_.size() > 0 ? share_of_jump(seen_) : 0;
  if (jump_ > 1 && !is_put_elsewhere()) {
    measured_.q.head(n) = seen_;
    measured_.object_time = seen_time_;
    return;
  }
  displaced_ = displaced_ || jump_ > 1 || (seen_.size() > 0 && measured_.object_time - seen_time_ > silence_);
  elsewhere_.resize(0);
  seen_ = measured_.q.head(n);
  seen_time_ = measured_.object_time;
}

bool DriverLink::read() {
  Measurement given;
  if (!plant_.read(given)) return fail(with_message("the plant does not answer"));
  if (!take(given)) return false;
  keep_objects_in_place();
  if (still_ > silence_) return fail(fmt::format("the clock of the plant stands still at {:.3f} s", measured_.time));
  if (measured_.time - measured_.object_time <= absence_) return true;
  return fail(fmt::format("the objects were last seen {:.3f} s ago{}", measured_.time - measured_.object_time,
                          jump_ > 1 ? "; since then they are reported where they cannot have got to" : ""));
}

bool DriverLink::command(VectorRef u) { return plant_.command(u, tick_) || fail(with_message("the plant takes no commands")); }

}  // namespace stiction::execution
