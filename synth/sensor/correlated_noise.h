// Random pictures whose pixels are alike within a window.
#pragma once

#include <cstdint>

#include "core/image.h"

namespace scanknit {

/// Which random picture: a seed, what it is for, and the picture's number.
struct NoiseKey {
  std::uint64_t seed = 1;
  std::uint64_t purpose = 0;
  std::uint64_t frame = 0;
};

/// Normal with mean 0 and deviation 1 at each pixel. The mean of white noise over a square window whose side is
/// `window_px`, made odd: two pixels k apart in a row have the correlation max(0, 1 - k / window). The same bits for
/// any number of threads.
[[nodiscard]] Image<float> correlated_noise(int width, int height, double window_px, const NoiseKey& key);

/// A smooth picture with values from -1 to 1, with `cells` waves across the width: value noise on a lattice, belonging
/// to the seed alone.
[[nodiscard]] Image<float> smooth_field(int width, int height, double cells, std::uint64_t seed);

}  // namespace scanknit
