// CounterRandom: random numbers as a pure function of a key and a counter; the order of threads cannot change them.
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>

namespace scanknit {

/// The finaliser of SplitMix64 (Steele, Lea, Flood 2014, "Fast Splittable Pseudorandom Number Generators", figure 16).
[[nodiscard]] constexpr std::uint64_t mix64(std::uint64_t z) {
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
  return z ^ (z >> 31);
}

/// One sequence of numbers for each (seed, stream, element). For noise, each pixel of each frame has its own sequence.
class CounterRandom {
 public:
  CounterRandom(std::uint64_t seed, std::uint64_t stream, std::uint64_t element)
      : state_(mix64(mix64(mix64(seed + kGamma) + stream + kGamma) + element + kGamma)) {}

  /// Uniform in [0, 1), 53 bits.
  [[nodiscard]] double uniform() {
    state_ += kGamma;
    return static_cast<double>(mix64(state_) >> 11) * 0x1p-53;
  }

  /// Normal with mean 0 and deviation 1 (Box & Muller 1958).
  [[nodiscard]] double gaussian() {
    const double radius = std::sqrt(-2 * std::log(1 - uniform()));  // 1 - u is in (0, 1]: the logarithm is finite
    return radius * std::cos(2 * std::numbers::pi * uniform());
  }

 private:
  static constexpr std::uint64_t kGamma = 0x9E3779B97F4A7C15u;  // 2^64 / golden ratio, odd
  std::uint64_t state_;
};

}  // namespace scanknit
