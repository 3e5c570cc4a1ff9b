// Times our solver on seeded cone problems and writes problems, times and solutions as JSON, for bench/cone_vs.py.
// Usage: cone_vs INSTANCES
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <numbers>
#include <vector>

#include "cone_problems.hpp"

namespace {

using namespace stiction;
using nlohmann::json;
using Clock = std::chrono::steady_clock;

constexpr int kRays = 4;
constexpr int kRepeats = 5;

/// The same step with a pyramid of kRays half-lines for every cone: w₀ + d·(w₁, w₂) ≥ 0.
cone::Problem make_polyhedral(const cone::Problem& from) {
  const cone::Layout& layout = *from.layout_ptr();
  cone::Problem out = from;
  out.clear();
  for (int i = 0; i < layout.size(); ++i) {
    out.set_b(i, from.b_padded()[layout.position(i)]);
    for (int j = 0; j <= i; ++j) {
      const int tile = layout.q_tile(std::max(layout.tile(i), layout.tile(j)), std::min(layout.tile(i), layout.tile(j)));
      if (tile < 0 || layout.group(i) != layout.group(j)) continue;
      const bool below = layout.tile(i) >= layout.tile(j);
      const int row = below ? layout.lane(i) : layout.lane(j), column = below ? layout.lane(j) : layout.lane(i);
      out.set_Q(i, j, from.Q_tiles()[16 * tile + 4 * column + row]);
    }
  }
  const auto& rows = from.cones();
  std::vector<double> G;
  for (int i = 0; i < rows.n; ++i) {
    const auto& support = layout.support(rows.support[static_cast<std::size_t>(i)]);
    const double* from_G = rows.G.data() + rows.offset[static_cast<std::size_t>(i)];
    const double* g = rows.g.data() + 3 * i;
    for (int k = 0; k < kRays; ++k) {
      const double angle = 2 * std::numbers::pi * k / kRays, c = std::cos(angle), s = std::sin(angle);
      G.resize(support.variables.size());
      for (std::size_t v = 0; v < G.size(); ++v) {
        const double* entry = from_G + 12 * support.slot[v] + support.lane[v];
        G[v] = entry[0] + c * entry[4] + s * entry[8];
      }
      out.add_half_line(static_cast<std::uint64_t>(kRays * i + k), rows.support[static_cast<std::size_t>(i)], G.data(),
                        g[0] + c * g[1] + s * g[2], 1e-3);
    }
  }
  const auto& bounds = from.bound_groups();
  for (int b = 0; b < from.n_bounds(); ++b) {
    for (int i = 0; i < from.n_bound_groups(); ++i) {
      for (int lane = 0; lane < cone::kTile; ++lane) {
        const auto& group = bounds[static_cast<std::size_t>(i)];
        if (group.index[lane] != b) continue;
        int variable = 0;
        while (layout.position(variable) != 4 * group.tile + lane) ++variable;
        out.add_bound(from.bound_id(b), variable, group.sign[lane], group.offset[lane], 1e-3);
      }
    }
  }
  return out;
}

/// Rows of Gx + g ∈ K as dense lists: cones (3 each), half-lines, bounds.
json dense(const cone::Problem& p) {
  const cone::Layout& layout = *p.layout_ptr();
  json G = json::array(), g = json::array(), Q = json::array(), b = json::array();
  const auto add = [&](const cone::Problem::Rows& rows, int components) {
    for (int i = 0; i < rows.n; ++i) {
      const auto& support = layout.support(rows.support[static_cast<std::size_t>(i)]);
      for (int r = 0; r < components; ++r) {
        std::vector<double> row(static_cast<std::size_t>(layout.size()), 0.0);
        for (std::size_t v = 0; v < support.variables.size(); ++v) {
          row[static_cast<std::size_t>(support.variables[v])] =
              rows.G.data()[rows.offset[static_cast<std::size_t>(i)] + (components * support.slot[v] + r) * 4 + support.lane[v]];
        }
        G.push_back(row);
        g.push_back(rows.g[static_cast<std::size_t>(components * i + r)]);
      }
    }
  };
  add(p.cones(), 3);
  add(p.half_lines(), 1);
  for (int i = 0; i < p.n_bound_groups(); ++i) {
    const auto& group = p.bound_groups()[static_cast<std::size_t>(i)];
    for (int lane = 0; lane < cone::kTile; ++lane) {
      if (group.index[lane] < 0) continue;
      std::vector<double> row(static_cast<std::size_t>(layout.size()), 0.0);
      for (int v = 0; v < layout.size(); ++v) {
        if (layout.position(v) == 4 * group.tile + lane) row[static_cast<std::size_t>(v)] = group.sign[lane];
      }
      G.push_back(row);
      g.push_back(group.offset[lane]);
    }
  }
  for (int i = 0; i < layout.size(); ++i) {
    std::vector<double> row(static_cast<std::size_t>(layout.size()), 0.0);
    for (int j = 0; j < layout.size(); ++j) {
      const bool below = layout.tile(i) >= layout.tile(j);
      const int tile = below ? layout.q_tile(layout.tile(i), layout.tile(j)) : layout.q_tile(layout.tile(j), layout.tile(i));
      const int lane_row = below ? layout.lane(i) : layout.lane(j), lane_column = below ? layout.lane(j) : layout.lane(i);
      if (tile >= 0 && layout.group(i) == layout.group(j))
        row[static_cast<std::size_t>(j)] = p.Q_tiles()[16 * tile + 4 * lane_column + lane_row];
    }
    Q.push_back(row);
    b.push_back(p.b_padded()[layout.position(i)]);
  }
  return {{"Q", Q}, {"b", b}, {"G", G}, {"g", g}, {"n_cones", p.n_cones()}, {"n_lines", p.n_half_lines() + p.n_bounds()}};
}

/// Problem, median time of cold solves and solution. z is stacked as the rows.
json solve_and_dump(const cone::Problem& problem, const char* family, const char* friction) {
  cone::Workspace work(problem.layout_ptr());
  cone::Options options;
  options.warm_start = options.sensitivities = false;
  const int rows = problem.n_cones() + problem.n_half_lines() + problem.n_bounds();
  options.tol_complementarity = 1e-9 / rows;  // of each row: theirs are for the sum over all
  options.tol_kkt = 1e-9;
  cone::Result result;
  std::vector<double> seconds;
  core::Status status = core::Status::NumericalFailure;
  for (int r = 0; r <= kRepeats; ++r) {
    work.forget();
    const auto start = Clock::now();
    status = cone::solve(problem, options, work, result);
    if (r > 0) seconds.push_back(std::chrono::duration<double>(Clock::now() - start).count());
  }
  std::sort(seconds.begin(), seconds.end());
  json out = dense(problem);
  out["family"] = family;
  out["friction"] = friction;
  out["status"] = std::string(core::to_string(status));
  out["seconds"] = seconds[seconds.size() / 2];
  out["x"] = std::vector<double>(result.x.data(), result.x.data() + result.x.size());
  std::vector<double> z;
  for (int i = 0; i < problem.n_cones(); ++i) {
    for (int r = 0; r < 3; ++r) z.push_back(result.z_cone.col(i)[r]);
  }
  for (int i = 0; i < problem.n_half_lines(); ++i) z.push_back(result.z_half_line[i]);
  const auto& bounds = problem.bound_groups();
  for (int i = 0; i < problem.n_bound_groups(); ++i) {
    for (int lane = 0; lane < cone::kTile; ++lane) {
      const int index = bounds[static_cast<std::size_t>(i)].index[lane];
      if (index >= 0) z.push_back(result.z_bound[index]);
    }
  }
  out["z"] = z;
  return out;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2 || std::atoi(argv[1]) < 1) {
    std::fprintf(stderr, "usage: cone_vs INSTANCES\n");
    return 2;
  }
  json out = json::array();
  for (const auto& [family, name] :
       {std::pair{bench::ConeFamily::Hand22, "22dof_20contacts"}, {bench::ConeFamily::Boxes69, "69dof_56contacts"}}) {
    for (int seed = 0; seed < std::atoi(argv[1]); ++seed) {
      const bench::ConeInstance instance(family, static_cast<std::uint64_t>(seed));
      out.push_back(solve_and_dump(instance.problem(), name, "cone"));
      out.push_back(solve_and_dump(make_polyhedral(instance.problem()), name, "pyramid"));
    }
  }
  std::printf("%s\n", out.dump().c_str());
}
