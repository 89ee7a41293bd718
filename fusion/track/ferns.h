// Random ferns: a short code of a picture, to compare key frames.
#pragma once

#include <cstdint>
#include <vector>

#include "fusion/register/surface_pyramid.h"

namespace scanknit {

/// One number for each fern: the outcome of its tests, or kUnseen where the picture has no depth.
using FernCode = std::vector<std::uint8_t>;
inline constexpr std::uint8_t kUnseen = 255;

/// Glocker, Shotton, Criminisi & Izadi 2015, "Real-Time RGB-D Camera Relocalization via Randomized Ferns for Keyframe
/// Encoding". Each fern tests whether depth and intensity of one pixel are above thresholds. Pixels and thresholds are
/// the same in every run.
class Ferns {
 public:
  /// Spreads the depth thresholds round `typical_depth_m`.
  explicit Ferns(double typical_depth_m);

  [[nodiscard]] FernCode encode(const SurfaceLevel& picture) const;

 private:
  struct Fern {
    float x, y;  ///< position in the picture, 0 to 1
    float depth_m, intensity;
  };
  std::vector<Fern> ferns_;
};

/// The share of differing ferns among those that both pictures have; 1 when they have hardly any in common.
[[nodiscard]] double dissimilarity(const FernCode& a, const FernCode& b);

}  // namespace scanknit
