#include "cone_allocations.hpp"
#include "cone_problems.hpp"
#include "table.hpp"

namespace stiction::app {
namespace {

constexpr Reference kCone22 = {{}, 0.90e-3};    // peer: exact step of the same hand, contacts and B included
constexpr Reference kCone69 = {10e-3, 6.3e-3};  // peer: exact step of ten boxes and an arm, contacts and B included
constexpr int kConeInstances = 2000;

void cone(BenchTable& table, const std::string& base, bench::ConeFamily family, const Reference& reference) {
  for (const bool warm : {false, true}) {
    const std::string name = base + (warm ? "/warm" : "");
    if (!table.wanted(name)) continue;
    table.line().show("timing " + name);
    cone::Options options;
    options.sensitivities = false;  // as in a step without B
    const auto timing = warm ? bench::time_cone_warm(family, kConeInstances, 0, options, bench::allocations)
                             : bench::time_cone_cold(family, kConeInstances, 0, options, bench::allocations);
    table.add(make_row(name, timing.seconds, reference, timing.allocations, timing.failures));
  }
}

}  // namespace

void add_cone_rows(BenchTable& table) {
  cone(table, "cone/22dof_20contacts", bench::ConeFamily::Hand22, kCone22);
  cone(table, "cone/69dof_56contacts", bench::ConeFamily::Boxes69, kCone69);
}

}  // namespace stiction::app
