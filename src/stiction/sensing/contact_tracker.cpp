#include "stiction/sensing/contact_tracker.hpp"

#include <algorithm>
#include <string>

#include "stiction/core/invalid_input.hpp"

namespace stiction::sensing {

namespace {
std::size_t at(int i) { return static_cast<std::size_t>(i); }
}  // namespace

void ContactTrackerOptions::validate() const {
  const auto require = [](const char* field, int value) {
    if (value < 1) core::throw_invalid(field, std::to_string(value), "an integer ≥ 1");
  };
  require("tracker.pool", pool), require("tracker.parents", parents), require("tracker.descents", descents);
  core::require_nonnegative("tracker.merge", merge);
  if (cone.is_lorentz()) core::throw_invalid("rays", "0 (the exact cone)", "a polyhedral cone, of 3 to 64 rays, for several contacts");
}

ContactTracker::ContactTracker(std::shared_ptr<const Sensor> sensor, int count, const ContactTrackerOptions& options)
    : sensor_(std::move(sensor)), count_(count), options_(options), extension_(*sensor_) {
  options.validate();
  if (count < 2 || count > kMostContacts)
    core::throw_invalid("count", std::to_string(count), "an integer from 2 to " + std::to_string(kMostContacts));
}

void ContactTracker::reset() {
  sets_.clear();
  turn_ = 0;
}

void ContactTracker::update(const ContactTrackerInput& input) {
  const JointProblem problem{*sensor_, input.rows, options_.cone, input.prior, input.noise};
  descents_ = 0;
  before_.swap(sets_);
  sets_.clear();
  for (const ContactSet& set : before_) descend_from(problem, input.enough, set);
  grow(problem, input.enough, input.parents);
  keep_best();
}

void ContactTracker::grow(const JointProblem& problem, double enough, std::span<const ContactSet> parents) {
  SetExtension extension(problem, extension_);
  grown_.clear();
  for (std::size_t k = 0; k < std::min(parents.size(), at(options_.parents)); ++k) {
    const ContactSet& parent = parents[turn_++ % parents.size()];
    extension.hold(parent);
    for (int link = 0; link < static_cast<int>(sensor_->links().size()); ++link) {
      ContactSet set = parent;
      set.contacts[at(set.count++)] = extension.sample_point(link, extension.find_samples(link, 1)[0]);
      arrange(set);
      joint_.active_set.forget();
      evaluate(problem, joint_, set);
      grown_.push_back(set);
    }
  }
  std::sort(grown_.begin(), grown_.end(), is_better);
  for (std::size_t k = 0; k < std::min(grown_.size(), at(options_.descents)); ++k) descend_from(problem, enough, grown_[k]);
}

/// Descends from a set, and keeps the end if it needs all its contacts.
void ContactTracker::descend_from(const JointProblem& problem, double enough, ContactSet set) {
  ++descents_;
  joint_.active_set.forget();
  descend(problem, options_.descent, enough, joint_, set);
  for (int i = 0; i < set.count; ++i)
    if (set.contacts[at(i)].f_L.isZero(0)) return;  // fewer contacts explain the torques as well
  arrange(set);
  sets_.push_back(set);
}

void ContactTracker::keep_best() {
  std::sort(sets_.begin(), sets_.end(), is_better);
  std::size_t kept = 0;
  for (std::size_t k = 0; k < sets_.size() && kept < at(options_.pool); ++k) {
    const auto repeats = [&](const ContactSet& other) { return is_near(*sensor_, sets_[k], other, options_.merge); };
    if (std::none_of(sets_.begin(), sets_.begin() + static_cast<std::ptrdiff_t>(kept), repeats)) std::swap(sets_[kept++], sets_[k]);
  }
  sets_.resize(kept);
}

}  // namespace stiction::sensing
