// Numbers as colours: a place on a list of colours, mixed between neighbours.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "core/image.h"

namespace scanknit {

/// The colour at `share` of the ramp: 0 its first colour, 1 its last; beyond the ends that of the end.
template <std::size_t N>
[[nodiscard]] Rgb8 colour_on(const Rgb8 (&ramp)[N], double share) {
  const double place = std::clamp(share, 0.0, 1.0) * (N - 1);
  const auto i = std::min(static_cast<std::size_t>(place), N - 2);
  const double t = place - static_cast<double>(i);
  const auto mix = [t](std::uint8_t a, std::uint8_t b) {
    return static_cast<std::uint8_t>(std::lround(a + t * (b - a)));
  };
  return {mix(ramp[i].r, ramp[i + 1].r), mix(ramp[i].g, ramp[i + 1].g), mix(ramp[i].b, ramp[i + 1].b)};
}

}  // namespace scanknit
