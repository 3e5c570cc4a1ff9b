#include "stiction/core/random.hpp"

#include <bit>
#include <cmath>
#include <numbers>

namespace stiction::core {
namespace {

std::uint64_t mix(std::uint64_t z) {
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
  return z ^ (z >> 31);
}

// An odd increment with enough bit transitions, so that the Weyl sequence behind SplitMix64 is well spread (Steele et al. 2014, §5).
std::uint64_t mix_increment(std::uint64_t z) {
  z = mix(z) | 1ULL;
  return std::popcount(z ^ (z >> 1)) < 24 ? z ^ 0xaaaaaaaaaaaaaaaaULL : z;
}

}  // namespace

Random::Random(std::uint64_t seed, std::uint64_t stream)
    : state_(mix(seed + 0x9e3779b97f4a7c15ULL) ^ mix(stream * 0xd1342543de82ef95ULL + 0x632be59bd9b4e019ULL)),
      increment_(mix_increment(stream + 0x9e3779b97f4a7c15ULL)) {}

std::uint64_t Random::bits() { return mix(state_ += increment_); }

double Random::uniform() { return static_cast<double>(bits() >> 11) * 0x1.0p-53; }

double Random::uniform(double low, double high) { return low + (high - low) * uniform(); }

double Random::normal() {
  const double u = 1.0 - uniform();  // in (0, 1], so that the logarithm is finite
  return std::sqrt(-2.0 * std::log(u)) * std::cos(2.0 * std::numbers::pi * uniform());
}

int Random::index(int n) { return static_cast<int>(uniform() * n); }

}  // namespace stiction::core
