// google-benchmark of the cone solver: median, 95th and 99th percentile, iterations and allocations of each family and mode.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <numeric>

#include "cone_allocations.hpp"
#include "cone_problems.hpp"

namespace {

using namespace stiction;

double percentile(std::vector<double> v, double p) {
  std::ranges::sort(v);
  return v[static_cast<std::size_t>(p * static_cast<double>(v.size() - 1))];
}

void cone_solve(benchmark::State& state, bench::ConeFamily family, cone::Mode mode, bool warm, bool sensitivities) {
  cone::Options options;
  options.mode = mode;
  options.sensitivities = sensitivities;
  bench::ConeTiming timing;
  for (auto _ : state) {
    timing = warm ? bench::time_cone_warm(family, 2000, 1, options, bench::allocations)
                  : bench::time_cone_cold(family, 2000, 1, options, bench::allocations);
    state.SetIterationTime(percentile(timing.seconds, 0.5));
  }
  state.counters["median_us"] = 1e6 * percentile(timing.seconds, 0.5);
  state.counters["p95_us"] = 1e6 * percentile(timing.seconds, 0.95);
  state.counters["p99_us"] = 1e6 * percentile(timing.seconds, 0.99);
  state.counters["iterations"] =
      std::accumulate(timing.iterations.begin(), timing.iterations.end(), 0.0) / static_cast<double>(timing.iterations.size());
  state.counters["allocations"] = static_cast<double>(timing.allocations);
  state.counters["failures"] = timing.failures;
}

void add(const char* name, bench::ConeFamily family, cone::Mode mode, bool warm, bool sensitivities) {
  benchmark::RegisterBenchmark(name, cone_solve, family, mode, warm, sensitivities)->UseManualTime()->Iterations(1);
}

}  // namespace

int main(int argc, char** argv) {
  using bench::ConeFamily;
  using cone::Mode;
  add("22dof_20contacts/exact/cold", ConeFamily::Hand22, Mode::Exact, false, false);
  add("22dof_20contacts/exact/warm", ConeFamily::Hand22, Mode::Exact, true, false);
  add("22dof_20contacts/exact_centred_factor/cold", ConeFamily::Hand22, Mode::Exact, false, true);
  add("22dof_20contacts/smoothed/cold", ConeFamily::Hand22, Mode::Smoothed, false, false);
  add("22dof_20contacts/smoothed/warm", ConeFamily::Hand22, Mode::Smoothed, true, false);
  add("22dof_20contacts/smoothed_factor/warm", ConeFamily::Hand22, Mode::Smoothed, true, true);
  add("69dof_56contacts/exact/cold", ConeFamily::Boxes69, Mode::Exact, false, false);
  add("69dof_56contacts/exact/warm", ConeFamily::Boxes69, Mode::Exact, true, false);
  add("69dof_56contacts/exact_centred_factor/cold", ConeFamily::Boxes69, Mode::Exact, false, true);
  add("69dof_56contacts/smoothed/cold", ConeFamily::Boxes69, Mode::Smoothed, false, false);
  add("69dof_56contacts/smoothed/warm", ConeFamily::Boxes69, Mode::Smoothed, true, false);
  add("69dof_56contacts/smoothed_factor/warm", ConeFamily::Boxes69, Mode::Smoothed, true, true);
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
}
