// Writes seeded cone problems and our solutions as one JSON array on stdout, for tests/python/test_cone_oracle.py.
// Usage: cone_dump FIRST_SEED COUNT
#include <cstdio>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <string>

#include "cone/random_problem.hpp"

namespace {

nlohmann::json matrix_json(const Eigen::MatrixXd& m) {
  auto rows = nlohmann::json::array();
  for (Eigen::Index i = 0; i < m.rows(); ++i) {
    auto row = nlohmann::json::array();
    for (Eigen::Index j = 0; j < m.cols(); ++j) row.push_back(m(i, j));
    rows.push_back(row);
  }
  return rows;
}

nlohmann::json vector_json(const Eigen::VectorXd& v) { return std::vector<double>(v.data(), v.data() + v.size()); }

}  // namespace

int main(int argc, char** argv) {
  using namespace stiction::cone;
  if (argc != 3) {
    std::fprintf(stderr, "usage: cone_dump FIRST_SEED COUNT\n");
    return 2;
  }
  test::RandomOptions random;
  random.deep = 0;
  random.mass_decades = 2;
  random.planar = false;
  random.max_contacts = 30;
  auto out = nlohmann::json::array();
  const auto first = static_cast<std::uint64_t>(std::atoll(argv[1]));
  for (std::uint64_t seed = first; seed < first + static_cast<std::uint64_t>(std::atoll(argv[2])); ++seed) {
    const test::RawProblem raw = test::make_random(seed, random);
    const Problem problem = raw.make();
    Workspace work(problem.layout_ptr());
    Options options;
    options.tol_complementarity = 1e-11;  // ‖x − x*‖ falls with it; 1e-9 would leave up to 1e-5
    Result r;
    const auto status = solve(problem, options, work, r);
    out.push_back({{"seed", seed},
                   {"status", std::string(stiction::core::to_string(status))},
                   {"Q", matrix_json(raw.Q)},
                   {"b", vector_json(raw.b)},
                   {"G", matrix_json(raw.stacked_G())},
                   {"g", vector_json(raw.stacked_g())},
                   {"n_cones", raw.cones.size()},
                   {"n_lines", raw.lines.size() + raw.bounds.size()},
                   {"x", vector_json(r.x)}});
  }
  std::printf("%s\n", out.dump().c_str());
}
