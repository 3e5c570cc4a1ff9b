#include "stiction/execution/driver_link.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <numbers>

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

bool DriverLink::fits() const {
  return measured_.q.size() == model_.n_q() && measured_.u.size() == model_.n_a() && measured_.q.allFinite() && measured_.u.allFinite() &&
         std::isfinite(measured_.time);
}

void DriverLink::keep_objects_in_place() {
  const Eigen::Index n = model_.n_qu();
  if (seen_.size() > 0) {
    Eigen::VectorXd moved(model_.n_vu());
    space_.error(seen_.data(), measured_.q.data(), moved.data());
    jump_ = 0;
    for (int i = 0; i < static_cast<int>(model_.objects().size()); ++i) {
      const world::ObjectInfo& object = model_.objects()[static_cast<std::size_t>(i)];
      Eigen::VectorXd alone = Eigen::VectorXd::Zero(model_.n_vu());
      alone.segment(object.v_begin, object.n_v) = moved.segment(object.v_begin, object.n_v);
      jump_ = std::max(jump_, world::largest_share(model_, alone, model_.scales().object(i).length, std::numbers::pi / 2));
    }
    if (jump_ > 1) {
      measured_.q.head(n) = seen_;
      measured_.object_time = seen_time_;
      return;
    }
  }
  seen_ = measured_.q.head(n);
  seen_time_ = measured_.object_time;
}

bool DriverLink::read() {
  const double before = measured_.q.size() > 0 ? measured_.time : -std::numeric_limits<double>::infinity();
  if (!plant_.read(measured_)) return fail(with_message("the plant does not answer"));
  if (!fits())
    return fail(fmt::format("the plant gave no measurement of {} positions and {} commands, all finite", model_.n_q(), model_.n_a()));
  keep_objects_in_place();
  still_ = measured_.time > before ? 0 : still_ + tick_;
  if (still_ > silence_) return fail(fmt::format("the clock of the plant stands still at {:.3f} s", measured_.time));
  if (measured_.time - measured_.object_time <= silence_) return true;
  return fail(fmt::format("the objects were last seen {:.3f} s ago{}", measured_.time - measured_.object_time,
                          jump_ > 1 ? "; since then they are reported where they cannot have got to" : ""));
}

bool DriverLink::command(VectorRef u) { return plant_.command(u, tick_) || fail(with_message("the plant takes no commands")); }

}  // namespace stiction::execution
