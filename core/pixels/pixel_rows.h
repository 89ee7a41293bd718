// Definitions for inner loops over rows of pixels.
#pragma once

#include "core/noise_model.h"

namespace scanknit {

/// Vectorised loops process so many pixels together on every machine, whatever its vector width, to give the same bits.
inline constexpr int kPixelGroup = 16;

/// NoiseModel in float.
struct FloatNoise {
  float floor_m, growth_per_m, from_m;

  explicit FloatNoise(const NoiseModel& noise)
      : floor_m(static_cast<float>(noise.floor_m)),
        growth_per_m(static_cast<float>(noise.growth_per_m)),
        from_m(static_cast<float>(noise.from_m)) {}

  [[nodiscard]] float sigma_m(float z_m) const {
    const float beyond = z_m - from_m;
    return floor_m + growth_per_m * (beyond * beyond);
  }
};

}  // namespace scanknit
