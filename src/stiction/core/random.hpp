#pragma once

#include <cstdint>

namespace stiction::core {

/// Counter-based random numbers: the same (seed, stream) gives the same sequence on every machine and for any number of threads.
/// The generator is SplitMix64 with an odd increment derived from the stream; distributions are our own, because the
/// distributions of the standard library differ between implementations.
class Random {
 public:
  Random(std::uint64_t seed, std::uint64_t stream);

  std::uint64_t bits();
  double uniform();                         ///< in [0, 1)
  double uniform(double low, double high);  ///< in [low, high)
  double normal();                          ///< mean 0, variance 1
  int index(int n);                         ///< in {0 … n−1}, n ≥ 1
  bool chance(double probability) { return uniform() < probability; }

 private:
  std::uint64_t state_;
  std::uint64_t increment_;
};

}  // namespace stiction::core
