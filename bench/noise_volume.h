// Volumes of noise for the comparisons.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <random>
#include <vector>

namespace scanknit {

/// side^3 samples, x fastest.
struct BenchVolume {
  int side = 0;
  std::vector<float> samples;
};

[[nodiscard]] inline BenchVolume make_volume(int side, const std::function<float(int, int, int)>& sample) {
  BenchVolume volume{side, {}};
  volume.samples.reserve(static_cast<std::size_t>(side) * static_cast<std::size_t>(side * side));
  for (int z = 0; z < side; ++z) {
    for (int y = 0; y < side; ++y) {
      for (int x = 0; x < side; ++x) volume.samples.push_back(sample(x, y, z));
    }
  }
  return volume;
}

/// A ball's signed distance, positive inside, off the centre so that no sample is met exactly.
[[nodiscard]] inline BenchVolume sphere(int side) {
  const float centre = static_cast<float>(side) / 2 - 0.6f;
  return make_volume(side, [=](int x, int y, int z) {
    const auto from_centre = [&](int i) { return static_cast<float>(i) - centre; };
    return 0.39f * static_cast<float>(side) - std::hypot(from_centre(x), from_centre(y), from_centre(z));
  });
}

/// Between -1 and 1.
[[nodiscard]] inline BenchVolume white_noise(int side, unsigned seed) {
  std::mt19937 random(seed);
  return make_volume(side, [&](int, int, int) { return static_cast<float>(random()) / 2147483648.0f - 1.0f; });
}

/// White noise, averaged three times over 3 x 3 x 3 samples: some 15 million triangles at 256^3.
[[nodiscard]] inline BenchVolume smooth_noise(int side, unsigned seed) {
  BenchVolume volume = white_noise(side, seed);
  const auto n = static_cast<std::size_t>(side);
  const auto average_along = [&](std::size_t stride) {
    std::vector<float> smooth = volume.samples;
    for (std::size_t i = 0; i < smooth.size(); ++i) {
      const std::size_t at = i / stride % n;
      if (at > 0 && at + 1 < n)
        smooth[i] = (volume.samples[i - stride] + volume.samples[i] + volume.samples[i + stride]) / 3;
    }
    volume.samples.swap(smooth);
  };
  for (const std::size_t stride : {std::size_t{1}, n, n * n}) {
    for (int pass = 0; pass < 3; ++pass) average_along(stride);
  }
  return volume;
}

}  // namespace scanknit
