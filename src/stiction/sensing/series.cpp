#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <fstream>
#include <limits>
#include <numbers>

#include "stiction/core/invalid_input.hpp"
#include "stiction/sensing/scenario.hpp"

namespace stiction::sensing {
namespace {

/// The numbers of a line, separated by commas; nothing where a field is no finite number.
std::optional<std::vector<double>> read_numbers(const std::string& line) {
  std::vector<double> out;
  std::size_t begin = 0;
  while (begin <= line.size()) {
    const std::size_t end = std::min(line.find(',', begin), line.size());
    const std::size_t first = line.find_first_not_of(" \t", begin);
    double value = 0;
    if (first == std::string::npos || first >= end) return std::nullopt;
    const auto read = std::from_chars(line.data() + first, line.data() + end, value);
    const std::size_t rest = line.find_first_not_of(" \t\r", static_cast<std::size_t>(read.ptr - line.data()));
    if (read.ec != std::errc() || !std::isfinite(value) || (rest != std::string::npos && rest < end)) return std::nullopt;
    out.push_back(value);
    begin = end + 1;
  }
  return out;
}

}  // namespace

Series load_series(const std::filesystem::path& file, const world::Model& model) {
  std::ifstream stream(file);
  if (!stream) throw core::InvalidInput(fmt::format("{}: series: got a file that cannot be read, expected a CSV file", file.string()));
  const Eigen::Index n = model.n_a();
  const auto fail = [&](int line, const std::string& got, const std::string& expected) {
    throw core::InvalidInput(fmt::format("{}:{}: series: got {}, expected {}", file.string(), line, got, expected));
  };
  std::vector<std::vector<double>> rows;
  std::string text;
  for (int line = 1; std::getline(stream, text); ++line) {
    if (text.find_first_not_of(" \t\r") == std::string::npos) continue;
    const auto numbers = read_numbers(text);
    if (!numbers && line == 1) continue;  // names of the columns
    const std::string expected = fmt::format("{} finite numbers: a time, {} joint positions, {} torques", 1 + 2 * n, n, n);
    if (!numbers) fail(line, fmt::format("'{}'", text.substr(0, 40)), expected);
    if (static_cast<Eigen::Index>(numbers->size()) != 1 + 2 * n) fail(line, fmt::format("{} numbers", numbers->size()), expected);
    if (!rows.empty() && !(numbers->front() > rows.back().front()))
      fail(line, fmt::format("time {} after {}", numbers->front(), rows.back().front()), "times that increase");
    rows.push_back(*numbers);
  }
  if (rows.empty()) throw core::InvalidInput(fmt::format("{}: series: got no line of numbers, expected at least one", file.string()));
  Series out;
  out.q.resize(n, static_cast<Eigen::Index>(rows.size()));
  out.tau.resize(n, static_cast<Eigen::Index>(rows.size()));
  for (std::size_t i = 0; i < rows.size(); ++i) {
    out.times.push_back(rows[i].front());
    out.q.col(static_cast<Eigen::Index>(i)) = Eigen::Map<const Eigen::VectorXd>(rows[i].data() + 1, n);
    out.tau.col(static_cast<Eigen::Index>(i)) = Eigen::Map<const Eigen::VectorXd>(rows[i].data() + 1 + n, n);
  }
  return out;
}

Eigen::VectorXd place_robots(const world::Model& model, VectorRef joints) {
  Eigen::VectorXd q = model.neutral();
  q.tail(model.n_a()) = joints;
  return q;
}

KnownCase make_random_case(const Sensor& sensor, std::span<const int> links, const FrictionCone& cone, double force, core::Random& random) {
  const world::Model& model = sensor.model();
  KnownCase out;
  Eigen::VectorXd joints(model.n_a());
  for (Eigen::Index j = 0; j < model.n_a(); ++j) {
    const double lower = std::max(model.lower()[j], -std::numbers::pi), upper = std::min(model.upper()[j], std::numbers::pi);
    constexpr double kShare = 0.9;
    joints[j] = 0.5 * ((lower + upper) + kShare * (upper - lower) * random.uniform(-1, 1));
  }
  out.q = place_robots(model, joints);
  out.contact.link = links[static_cast<std::size_t>(random.index(static_cast<int>(links.size())))];
  const SensedLink& link = sensor.links()[static_cast<std::size_t>(out.contact.link)];
  const SurfacePoint point = sample_surface(link.surface, 1, Sampling::Uniform, random.bits())[0];
  Eigen::Vector3d f_C;
  do {
    f_C = Eigen::Vector3d(random.normal(), random.normal(), random.normal()).normalized();
  } while (!cone.contains(f_C));
  out.contact.p_L = point.p_L;
  out.contact.f_L = force * (make_contact_frame(link.surface.normal(point.triangle, point.p_L, sensor.options().normals)) * f_C);
  out.tau = calc_contact_torque(model, out.q, link.surface.body, out.contact.p_L, out.contact.f_L);
  return out;
}

double calc_distance(const SenseResult& result, const Candidate& candidate, const KnownContact& contact) {
  double squared = std::numeric_limits<double>::infinity();
  if (candidate.best.link != contact.link) return squared;
  for (int i = candidate.first; i < candidate.first + candidate.count; ++i) {
    const ContactPoint& point = result.points[static_cast<std::size_t>(i)];
    if (point.residual <= std::max(result.explained, candidate.best.residual))
      squared = std::min(squared, (point.p_L - contact.p_L).squaredNorm());
  }
  return std::sqrt(squared);
}

}  // namespace stiction::sensing
