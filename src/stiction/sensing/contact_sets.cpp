#include "stiction/sensing/contact_sets.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>

#include "stiction/core/invalid_input.hpp"
#include "stiction/sensing/set_extension.hpp"

namespace stiction::sensing {

namespace {
std::size_t at(int i) { return static_cast<std::size_t>(i); }
}  // namespace

struct ContactSetWorkspace::Impl {
  std::shared_ptr<const Sensor> sensor;
  std::vector<int> bodies;
  world::KinematicsWorkspace kinematics_work;
  world::Kinematics kinematics;
  ContactRowsWorkspace rows_work;
  WhitenedTorques whitened;
  ContactRows rows;
  JointWorkspace joint;
  ExtensionWorkspace extension;
  std::vector<ContactSet> parents, grown, found;

  explicit Impl(std::shared_ptr<const Sensor> s) : sensor(std::move(s)), kinematics_work(sensor->model()), extension(*sensor) {
    for (const auto& link : sensor->links()) bodies.push_back(link.surface.body);
  }
};

ContactSetWorkspace::ContactSetWorkspace(std::shared_ptr<const Sensor> sensor) : impl_(std::make_unique<Impl>(std::move(sensor))) {}
ContactSetWorkspace::~ContactSetWorkspace() = default;
ContactSetWorkspace::ContactSetWorkspace(ContactSetWorkspace&&) noexcept = default;

void ContactSetOptions::validate() const {
  sense.validate();
  const auto require = [](const char* field, int value, int least, const char* expected) {
    if (value < least) core::throw_invalid(field, fmt::format("{}", value), expected);
  };
  if (max_contacts < 1 || max_contacts > kMostContacts)
    core::throw_invalid("max_contacts", fmt::format("{}", max_contacts), "an integer from 1 to 3");
  require("starts", starts, 1, "an integer ≥ 1");
  require("descents", descents, 1, "an integer ≥ 1");
  if (sense.cone.is_lorentz())
    core::throw_invalid("rays", "0 (the exact cone)", "a polyhedral cone, of 3 to 64 rays, for several contacts");
}

namespace {

class Search {
 public:
  Search(const Sensor& sensor, const ContactSetOptions& options, ContactSetWorkspace::Impl& work, ContactSetResult& out, double prior)
      : sensor_(sensor),
        options_(options),
        work_(work),
        out_(out),
        problem_{sensor, work.rows, options.sense.cone, prior, work.whitened.noise()},
        extension_(problem_, work.extension) {}

  /// Sets of `count` contacts from work.parents, of one contact less, to work.found.
  void grow(int count) {
    work_.grown.clear();
    if (count > 1)
      for (const ContactSet& parent : work_.parents) extend(parent, 1);
    if (count == 2) extend_samples();
    if (count == 1) extend(ContactSet{}, options_.starts);
    refine(count);
  }

  /// Sets of `count` contacts from those of the last cycle, to work.found.
  void follow(const std::vector<ContactSet>& last, int count) {
    work_.found.clear();
    for (const ContactSet& set : last)
      if (set.count == count) descend_from(set, count);
  }

  const JointProblem& problem() const { return problem_; }

 private:
  /// Single points spread over every link, regardless of their residual.
  void extend_samples() {
    for (int link = 0; link < static_cast<int>(sensor_.links().size()); ++link) {
      const auto samples = static_cast<int>(sensor_.links()[at(link)].samples.size()), n = std::min(samples, options_.starts);
      for (int i = 0; i < n; ++i) {
        ContactSet one;
        one.count = 1;
        one.contacts[0] = extension_.sample_point(link, static_cast<int>((2L * i + 1) * samples / (2L * n)));
        extend(one, 1);
      }
    }
  }

  void evaluate_anew(ContactSet& set) {
    work_.joint.active_set.forget();
    evaluate(problem_, work_.joint, set);
  }

  /// Extends a set on every link by the `most` samples with the least residual when its own forces may have any value.
  void extend(const ContactSet& set, int most) {
    extension_.hold(set);
    for (int link = 0; link < static_cast<int>(sensor_.links().size()); ++link)
      for (const int sample : extension_.find_samples(link, most)) {
        ContactSet larger = set;
        larger.contacts[at(larger.count++)] = extension_.sample_point(link, sample);
        arrange(larger);
        evaluate_anew(larger);
        work_.grown.push_back(larger);
      }
  }

  /// Restarts a descent whose end almost explains the torques: such ends lie at creases of a surface more often than in a minimum. One
  /// contact after the other jumps to the best sample of its link beside the others, and all descend again, as long as this lowers the
  /// objective.
  void restart(ContactSet& set) {
    constexpr int kRounds = 3;
    constexpr double kAlmost = 30;  // an objective up to this many times the explained bound almost explains the torques
    bool lower = set.objective <= kAlmost * kAlmost * out_.explained;
    for (int round = 0; round < kRounds && lower && set.objective > out_.explained; ++round) {
      lower = false;
      for (int i = 0; i < set.count; ++i) {
        ContactSet next = set;
        std::swap(next.contacts[at(i)], next.contacts[at(--next.count)]);
        extension_.hold(next);
        const int link = set.contacts[at(i)].link;
        next = set;
        next.contacts[at(i)] = extension_.sample_point(link, extension_.find_samples(link, 1)[0]);
        descend_joint(next);
        if (next.objective < set.objective) set = next, lower = true;
      }
    }
  }

  void descend_joint(ContactSet& set) {
    ++out_.descents;
    work_.joint.active_set.forget();
    descend(problem_, options_.descent, out_.explained, work_.joint, set);
  }

  /// Descends from the best sets of every combination of links; the starts are not near each other.
  void refine(int count) {
    work_.found.clear();
    std::sort(work_.grown.begin(), work_.grown.end(), [](const ContactSet& a, const ContactSet& b) {
      return links_of(a) == links_of(b) ? is_better(a, b) : links_of(a) < links_of(b);
    });
    for (auto begin = work_.grown.begin(); begin != work_.grown.end();) {
      const auto end = std::find_if(begin, work_.grown.end(), [&](const ContactSet& s) { return links_of(s) != links_of(*begin); });
      refine_combination({begin, end}, count);
      begin = end;
    }
  }

  void refine_combination(std::span<ContactSet> sets, int count) {
    std::size_t tried = 0;
    for (std::size_t i = 0; i < sets.size() && tried < at(options_.descents); ++i) {
      const auto repeats = [&](const ContactSet& other) { return is_near(sensor_, sets[i], other, options_.sense.thin); };
      if (std::any_of(sets.begin(), sets.begin() + static_cast<std::ptrdiff_t>(tried), repeats)) continue;
      std::swap(sets[tried], sets[i]);
      descend_from(sets[tried++], count);
    }
  }

  void descend_from(const ContactSet& start, int count) {
    ContactSet set = start;
    descend_joint(set);
    restart(set);
    for (int i = 0; i < count; ++i)
      if (set.contacts[at(i)].f_L.isZero(0)) return;  // fewer contacts explain the torques as well
    arrange(set);
    work_.found.push_back(set);
  }

  const Sensor& sensor_;
  const ContactSetOptions& options_;
  ContactSetWorkspace::Impl& work_;
  ContactSetResult& out_;
  JointProblem problem_;
  SetExtension extension_;
};

/// Makes a group of the set `best` and all later sets on the same links.
void add_group(const JointProblem& problem, JointWorkspace& joint, const std::vector<ContactSet>& found, std::size_t best,
               ContactSetResult& out) {
  ContactGroup group{.first = static_cast<int>(out.sets.size())};
  for (std::size_t k = best; k < found.size(); ++k) {
    if (links_of(found[k]) != links_of(found[best])) continue;
    ContactSet& set = out.sets.emplace_back(found[k]);
    calc_identifiability(problem, joint, set);
    ++group.count;
    for (int c = 0; c < set.count; ++c)
      group.extent[at(c)] = std::max(group.extent[at(c)], (set.contacts[at(c)].p_L - found[best].contacts[at(c)].p_L).norm());
  }
  out.groups.push_back(group);
}

/// Collects the sets that explain the torques by combination of links, the best combination first; if none explains them, the best set.
void collect(const JointProblem& problem, JointWorkspace& joint, std::vector<ContactSet>& found, ContactSetResult& out) {
  std::sort(found.begin(), found.end(), is_better);
  const bool any = !found.empty() && found.front().objective <= out.explained;
  out.verdict = any ? Verdict::Explained : Verdict::Unexplained;
  if (any)
    std::erase_if(found, [&](const ContactSet& s) { return s.objective > out.explained; });
  else if (!found.empty())
    found.erase(found.begin() + 1, found.end());
  for (std::size_t i = 0; i < found.size(); ++i) {
    const auto same = [&](const ContactSet& s) { return links_of(s) == links_of(found[i]); };
    if (std::none_of(out.sets.begin(), out.sets.end(), same)) add_group(problem, joint, found, i, out);
  }
  out.ambiguous = any && (out.groups.size() > 1 || out.sets.front().freedom > 0);
}

void require_input(const Sensor& sensor, const ContactSetInput& input) {
  const world::Model& model = sensor.model();
  world::require_configuration(model, "q", input.q);
  core::require_size("tau", input.tau.size(), model.n_a());
  core::require_finite("tau", {input.tau.data(), static_cast<std::size_t>(input.tau.size())});
  if (input.base != nullptr) input.base->validate();
  if (input.last == nullptr) return;
  for (const ContactSet& set : *input.last) {
    if (set.count < 0 || set.count > kMostContacts)
      core::throw_invalid("last", fmt::format("a set of {} contacts", set.count), fmt::format("sets of at most {}", kMostContacts));
    for (int i = 0; i < set.count; ++i) require_point(sensor, "last", set.contacts[at(i)]);
  }
}

}  // namespace

void sense_contacts(const Sensor& sensor, const ContactSetInput& input, const ContactSetOptions& options, ContactSetWorkspace& workspace,
                    ContactSetResult& out) {
  const world::Model& model = sensor.model();
  options.validate();
  require_input(sensor, input);
  ContactSetWorkspace::Impl& work = workspace.impl();
  if (!options.sense.torques.is_plain()) options.sense.torques.validate(model.n_a());
  work.whitened.assign(options.sense.torques, input.tau, options.sense.noise, options.sense.tolerance);
  const double noise = work.whitened.noise();
  out.verdict = Verdict::BelowThreshold;
  out.ambiguous = false;
  out.contacts = out.descents = 0;
  out.sets.clear();
  out.groups.clear();

  world::calc_kinematics(model, input.q, work.kinematics_work, work.kinematics);
  calc_contact_rows(model, work.kinematics, work.bodies, work.whitened.tau(), input.base, noise, work.rows_work, work.rows, &work.whitened);
  const double tau_tau = work.rows.tau.squaredNorm();
  out.explained = std::max(options.sense.tolerance * options.sense.tolerance * tau_tau, calc_noise_bound(noise, work.rows.tau.size()));
  if (work.rows.tau.cwiseAbs().maxCoeff() < options.sense.threshold.value_or(4 * noise)) return;

  Search search(sensor, options, work, out, calc_prior(sensor, noise, work.rows.tau.norm(), options.sense.plausible_force));
  const auto explains = [&](const ContactSet& set) { return set.objective <= out.explained; };
  for (int count = 1; count <= options.max_contacts; ++count) {
    out.contacts = count;
    const auto any_explains = [&] { return std::any_of(work.found.begin(), work.found.end(), explains); };
    if (input.last != nullptr && count > 1) {
      search.follow(*input.last, count);
      if (any_explains()) break;
    }
    search.grow(count);
    if (any_explains()) break;
    if (count < options.max_contacts) work.parents.swap(work.found);
  }
  collect(search.problem(), work.joint, work.found, out);
}

}  // namespace stiction::sensing
