// Random logs of joint torques: columns in any order and by any name, gaps, missing numbers, units, offsets, and files that are broken. None may crash, none may be
// answered with the torque of another joint, and none that does not say what it means may be answered. random_logs [LOGS = 300] [FIRST = 0]; log i is the same in every run.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <map>
#include <numeric>

#include "stiction/core/invalid_input.hpp"
#include "stiction/core/random.hpp"
#include "stiction/sensing/scenario.hpp"
#include "stiction/sensing/sense.hpp"
#include "stiction/sensing/series_columns.hpp"

namespace {

using namespace stiction;
using Strings = std::vector<std::string>;

/// What is wrong with a log; all but the first three have to be refused.
enum class Fault {
  None,
  Millimetres,  ///< torques in N mm: refused where no motor bears them
  Bytes,        ///< some are others: whatever it then says, it must not crash
  Degrees,
  Twice,      ///< a column of a joint is there twice
  Missing,    ///< a column of a joint is not there
  Backwards,  ///< a time is not later than the one before
  Short,      ///< a line lacks a field
  Ambiguous   ///< names that fit the joints of two robots
};
constexpr const char* kFaults[] = {
    "none", "N mm", "bytes", "degrees", "column twice", "column missing", "time backwards", "short line", "names of two robots"};
constexpr int kFaultCount = 9;

struct Arm {
  std::shared_ptr<const world::Model> model;
  std::shared_ptr<const sensing::Sensor> sensor;
  Strings full, robot, name;  ///< of the joints: robot/name
  bool has_shared_names = false;
};

Arm make_arm(const std::vector<std::pair<std::string, std::string>>& robots) {
  world::Scene scene;
  scene.name = "logs";
  for (const auto& [name, file] : robots) {
    world::RobotSpec& robot = scene.robots.emplace_back();
    robot.name = name;
    robot.urdf = std::filesystem::path(STICTION_SOURCE_DIR) / "models" / file;
  }
  Arm out;
  out.model = world::Model::make(scene);
  out.sensor = sensing::Sensor::make(out.model, {.samples = 20});
  for (const world::Dof& dof : out.model->dofs().last(static_cast<std::size_t>(out.model->n_a()))) {
    out.full.push_back(dof.name);
    out.robot.push_back(dof.name.substr(0, dof.name.find('/')));
    out.name.push_back(dof.name.substr(dof.name.find('/') + 1));
  }
  out.has_shared_names = robots.size() > 1;
  return out;
}

/// A log as it is written, and what it means.
struct Log {
  Fault fault = Fault::None;
  std::string text;
  std::vector<double> times;  ///< of the lines that have all numbers
  std::vector<Eigen::VectorXd> q, tau;
  std::vector<int> unmeasured;
  Eigen::VectorXd rest;
};

class Writer {
 public:
  Writer(const Arm& arm, std::uint64_t number) : arm_(arm), random_(number, 0) {}

  Log write() {
    choose();
    make_columns();
    Log out;
    out.fault = fault_, out.unmeasured = unmeasured_, out.rest = rest_;
    std::string& text = out.text;
    if (random_.chance(0.1)) text += "\xEF\xBB\xBF";
    if (random_.chance(0.2)) text += "# a log\n";
    if (is_named_) text += line(columns_);
    const int rows = 3 + random_.index(12), bad = random_.index(rows - 1) + 1;
    double t = random_.uniform(0, 1e4);
    for (int i = 0; i < rows; ++i) {
      t += random_.chance(0.1) ? random_.uniform(1, 100) : random_.uniform(0.001, 0.1);
      const bool is_bad = i == bad;
      if (fault_ == Fault::Backwards && is_bad) go_back(t, out);
      add_row(t, is_bad, out);
    }
    if (fault_ == Fault::Bytes)
      for (int k = random_.index(5); k >= 0; --k)
        text[static_cast<std::size_t>(random_.index(static_cast<int>(text.size())))] = static_cast<char>(random_.index(256));
    return out;
  }

 private:
  /// Before the last time that is read; where none is, nothing is wrong.
  void go_back(double& t, Log& out) {
    if (out.times.empty())
      out.fault = fault_ = Fault::None;
    else
      t = out.times.back() - random_.uniform(0, 1);
  }

  int n() const { return static_cast<int>(joints_.size()); }

  void choose() {
    fault_ = random_.chance(0.5) ? Fault::None : static_cast<Fault>(random_.index(kFaultCount));
    is_named_ =
        random_.chance(0.85) || (fault_ != Fault::None && fault_ != Fault::Short && fault_ != Fault::Backwards && fault_ != Fault::Bytes);
    if (fault_ == Fault::Ambiguous && !arm_.has_shared_names) fault_ = Fault::None;
    if (random_.chance(0.3)) unmeasured_.push_back(random_.index(arm_.model->n_a()));
    joints_ = sensing::joints_but(arm_.model->n_a(), unmeasured_);
    rest_ = Eigen::VectorXd::Zero(arm_.model->n_a());
    if (random_.chance(0.5))
      for (const int j : joints_) rest_[j] = random_.uniform(-1, 1);
  }

  std::string name_of(int joint) { return !arm_.has_shared_names && random_.chance(0.7) ? arm_.name[at(joint)] : arm_.full[at(joint)]; }
  static std::size_t at(int i) { return static_cast<std::size_t>(i); }

  /// Names of the columns, and the numbers that stand in them: 0 the time, then positions, torques, and others.
  void make_columns() {
    static const char* const kTimes[] = {"t", "time", "Time [s]", "__time", "timestamp"};
    columns_ = {kTimes[random_.index(5)]};
    const int style = random_.index(5);
    const std::string unit = random_.chance(0.3) ? " [rad]" : "", torque_unit = random_.chance(0.3) ? " [Nm]" : "";
    const int first = random_.index(2);
    const char* const torques = random_.chance(0.3) ? "tau_ext_hat_filtered" : "tau";
    for (const bool is_torque : {false, true})
      for (int i = 0; i < n(); ++i) columns_.push_back(make_name(style, is_torque, i, first, torques) + (is_torque ? torque_unit : unit));
    if (fault_ == Fault::Ambiguous)
      for (int i = 0; i < n(); ++i) columns_[at(1 + i)] = "q_" + arm_.name[at(joints_[at(i)])];
    if (fault_ == Fault::Degrees) columns_[at(1 + random_.index(n()))] = "q_" + arm_.full[at(joints_[0])] + " [deg]";
    meaning_.resize(columns_.size());
    std::iota(meaning_.begin(), meaning_.end(), 0);
    if (!is_named_) return;
    if (fault_ == Fault::Twice) {
      const int again = random_.index(static_cast<int>(columns_.size()));
      columns_.push_back(columns_[at(again)]), meaning_.push_back(again);
    }
    if (fault_ == Fault::Missing) {
      const auto gone = static_cast<std::ptrdiff_t>(random_.index(static_cast<int>(columns_.size())));
      columns_.erase(columns_.begin() + gone), meaning_.erase(meaning_.begin() + gone);
    }
    for (int k = random_.index(3); k > 0; --k) columns_.push_back(fmt::format("other_{}", k)), meaning_.push_back(-1);
    for (int i = static_cast<int>(columns_.size()) - 1; i > 0; --i) {
      const int j = random_.index(i + 1);
      std::swap(columns_[at(i)], columns_[at(j)]), std::swap(meaning_[at(i)], meaning_[at(j)]);
    }
  }

  std::string make_name(int style, bool is_torque, int i, int first, const char* torques) {
    const int joint = joints_[at(i)];
    if (style == 0) return fmt::format("{}{}", is_torque ? torques : "q", i + first);
    if (style == 1) return fmt::format("{}[{}]", is_torque ? torques : "q", i + first);
    if (style == 2) return fmt::format("{}_{}", is_torque ? "tau" : "q", name_of(joint));
    if (style == 3) return fmt::format("/joint_states/{}/{}", name_of(joint), is_torque ? "effort" : "position");
    return fmt::format("{}.{}", name_of(joint), is_torque ? "tau_ext" : "q");
  }

  std::string line(const Strings& fields) {
    return fmt::format("{}{}", fmt::join(fields, random_.chance(0.3) ? ", " : ","), random_.chance(0.1) ? "\r\n" : "\n");
  }

  void add_row(double t, bool is_bad, Log& out) {
    Eigen::VectorXd q = arm_.model->neutral().tail(arm_.model->n_a()), tau = Eigen::VectorXd::Zero(q.size());
    for (const int j : joints_) q[j] = random_.uniform(-1, 1), tau[j] = rest_[j] + random_.uniform(-20, 20);
    const double scale = fault_ == Fault::Millimetres ? 1000 : 1;
    Strings fields;
    for (const int meaning : meaning_) {
      const double value = meaning < 0      ? 0
                           : meaning == 0   ? t
                           : meaning <= n() ? q[joints_[at(meaning - 1)]]
                                            : scale * tau[joints_[at(meaning - 1 - n())]];
      fields.push_back(meaning < 0 ? (random_.chance(0.5) ? "x" : "") : fmt::format("{:.12g}", value));
    }
    bool lacks = false;
    if (is_named_ && random_.chance(0.2)) {
      const int hole = random_.index(static_cast<int>(fields.size()));
      fields[at(hole)] = random_.chance(0.5) ? "nan" : "";
      lacks = meaning_[at(hole)] >= 0;
    }
    if (fault_ == Fault::Backwards && is_bad) lacks = false, fields = whole(fields, t, q, tau);
    if (fault_ == Fault::Short && is_bad) fields.pop_back();
    out.text += line(fields);
    if (lacks) return;
    out.times.push_back(t), out.q.push_back(q), out.tau.push_back(scale * tau);
  }

  /// Without a hole, so that the fault is there.
  Strings whole(Strings fields, double t, const Eigen::VectorXd& q, const Eigen::VectorXd& tau) const {
    for (std::size_t k = 0; k < fields.size(); ++k) {
      const int meaning = meaning_[k];
      if (meaning < 0) continue;
      fields[k] = fmt::format("{:.12g}", meaning == 0     ? t
                                         : meaning <= n() ? q[joints_[at(meaning - 1)]]
                                                          : tau[joints_[at(meaning - 1 - n())]]);
    }
    return fields;
  }

  const Arm& arm_;
  core::Random random_;
  Fault fault_ = Fault::None;
  bool is_named_ = true;
  std::vector<int> unmeasured_, joints_;
  Eigen::VectorXd rest_;
  Strings columns_;
  std::vector<int> meaning_;
};

struct Judge {
  std::map<std::string, long> counts;
  std::vector<std::string> faults;

  void fail(std::uint64_t number, const std::string& why) { faults.push_back(fmt::format("log {}: {}", number, why)); }

  /// Whether every number that was read is that of its joint.
  static bool says_the_same(const Log& log, const sensing::Series& series) {
    if (series.times.size() != log.times.size()) return false;
    for (std::size_t i = 0; i < log.times.size(); ++i) {
      const auto k = static_cast<Eigen::Index>(i);
      if (std::abs(series.times[i] - log.times[i]) > 1e-6 || (series.q.col(k) - log.q[i]).norm() > 1e-9) return false;
      if ((series.tau.col(k) - log.tau[i]).norm() > 1e-8 * (1 + log.tau[i].norm())) return false;
    }
    return true;
  }

  void judge(const Arm& arm, std::uint64_t number, const Log& log, const std::filesystem::path& file, sensing::SenseWorkspace& work) {
    const char* const fault = kFaults[static_cast<int>(log.fault)];
    sensing::Series series;
    try {
      series = sensing::load_series(file, *arm.model, log.unmeasured);
    } catch (const core::InvalidInput& e) {
      ++counts[fmt::format("{}: refused", fault)];
      if (log.fault == Fault::None && !log.times.empty()) fail(number, e.what());
      return;
    }
    ++counts[fmt::format("{}: read", fault)];
    if (log.fault == Fault::Bytes) return sense_all(arm, log, series, work, nullptr, number);
    if (log.fault > Fault::Bytes) return fail(number, fmt::format("a log with the fault '{}' was read", fault));
    if (!says_the_same(log, series)) return fail(number, "a number is not that of its joint");
    sense_all(arm, log, series, work, this, number);
  }

  /// The joint that an answer names is the one whose torque was the largest.
  static void sense_all(const Arm& arm, const Log& log, const sensing::Series& series, sensing::SenseWorkspace& work, Judge* judge,
                        std::uint64_t number) {
    sensing::SenseOptions options{.max_descents = 2};
    options.torques.rest = log.rest;
    options.torques.unmeasured = log.unmeasured;
    sensing::SenseResult out;
    const Eigen::Index k = series.tau.cols() - 1;
    if (!series.q.allFinite() || !series.tau.allFinite()) return;
    sensing::sense(*arm.sensor, {sensing::place_robots(*arm.model, series.q.col(k)), series.tau.col(k)}, options, work, out);
    if (judge == nullptr) return;
    Eigen::Index largest = 0;
    (log.tau.back() - log.rest).cwiseAbs().maxCoeff(&largest);
    if (out.largest.joint != largest)
      judge->fail(number, fmt::format("joint {} is named, and joint {} has the largest torque", out.largest.joint, largest));
  }
};

}  // namespace

int main(int argc, char** argv) {
  const long logs = argc > 1 ? std::atol(argv[1]) : 300, first = argc > 2 ? std::atol(argv[2]) : 0;
  const std::vector<Arm> arms{make_arm({{"arm", "iiwa7_balls.urdf"}}),
                              make_arm({{"left", "planar_arm_left.urdf"}, {"right", "planar_arm_right.urdf"}})};
  std::vector<sensing::SenseWorkspace> work;
  for (const Arm& arm : arms) work.emplace_back(arm.sensor);
  const std::filesystem::path file = std::filesystem::temp_directory_path() / fmt::format("random_log_{}.csv", getpid());
  Judge judge;
  for (long i = first; i < first + logs; ++i) {
    const auto number = static_cast<std::uint64_t>(i);
    const std::size_t which = number % arms.size();
    const Log log = Writer(arms[which], number).write();
    std::ofstream(file, std::ios::binary) << log.text;
    judge.judge(arms[which], number, log, file, work[which]);
  }
  std::filesystem::remove(file);
  fmt::print("{} logs from {} on\n", logs, first);
  for (const auto& [what, count] : judge.counts) fmt::print("  {:32} {}\n", what, count);
  for (std::size_t k = 0; k < std::min<std::size_t>(judge.faults.size(), 10); ++k) fmt::print("{}\n", judge.faults[k]);
  fmt::print("{} wrong\n", judge.faults.size());
  return judge.faults.empty() ? 0 : 1;
}
