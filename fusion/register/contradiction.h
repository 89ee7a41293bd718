// When two depths cannot be of the same surface.
#pragma once

#include "core/noise_model.h"

namespace scanknit {

inline constexpr double kContradiction_m = 0.03;
inline constexpr double kContradictionSigmas = 6;

/// Depths near `z_m` that differ by more than this are of different surfaces. Metres.
[[nodiscard]] inline double contradiction_m(const NoiseModel& noise, double z_m) {
  return kContradiction_m + kContradictionSigmas * noise.sigma_m(z_m);
}

}  // namespace scanknit
