#include "synth/sensor/correlated_noise.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "core/counter_random.h"
#include "synth/scene/texture.h"

namespace scanknit {
namespace {

/// White noise of unit deviation.
Image<float> white_noise(int width, int height, const NoiseKey& key) {
  auto white = Image<float>::uninitialised(width, height);
  const std::uint64_t stream = mix64(key.purpose + 1) + key.frame;
  tbb::parallel_for(0, height, [&](int y) {
    for (int x = 0; x < width; ++x) {
      const auto pixel =
          static_cast<std::uint64_t>(y) * static_cast<std::uint64_t>(width) + static_cast<std::uint64_t>(x);
      white.at(x, y) = static_cast<float>(CounterRandom(key.seed, stream, pixel).gaussian());
    }
  });
  return white;
}

/// Sums over `window` pixels of a row; the picture becomes narrower by window - 1.
Image<float> summed_rows(const Image<float>& picture, int window) {
  auto sums = Image<float>::uninitialised(picture.width() - window + 1, picture.height());
  tbb::parallel_for(0, sums.height(), [&](int y) {
    const auto from = picture.row(y);
    for (int x = 0; x < sums.width(); ++x) {
      float sum = 0;
      for (int i = 0; i < window; ++i) sum += from[static_cast<std::size_t>(x + i)];
      sums.at(x, y) = sum;
    }
  });
  return sums;
}

Image<float> summed_columns(const Image<float>& picture, int window, float factor) {
  Image<float> sums(picture.width(), picture.height() - window + 1);
  tbb::parallel_for(0, sums.height(), [&](int y) {
    const auto to = sums.row(y);
    for (int i = 0; i < window; ++i) {
      const auto from = picture.row(y + i);
      for (std::size_t x = 0; x < to.size(); ++x) to[x] += from[x];
    }
    for (float& sum : to) sum *= factor;
  });
  return sums;
}

}  // namespace

Image<float> correlated_noise(int width, int height, double window_px, const NoiseKey& key) {
  const int window = 2 * static_cast<int>(std::max(0.0, window_px) / 2) + 1;
  const Image<float> white = white_noise(width + window - 1, height + window - 1, key);
  if (window == 1) return white;
  return summed_columns(summed_rows(white, window), window, 1.0f / static_cast<float>(window));
}

Image<float> smooth_field(int width, int height, double cells, std::uint64_t seed) {
  CounterRandom random(seed, /*stream=*/0xB1A5, 0);
  Eigen::Vector3d place;
  for (double& coordinate : place) coordinate = 1000 * random.uniform();
  auto field = Image<float>::uninitialised(width, height);
  const double cell_px = width / cells;
  tbb::parallel_for(0, height, [&](int y) {
    for (int x = 0; x < width; ++x) {
      field.at(x, y) = static_cast<float>(2 * smooth_noise(place + Eigen::Vector3d(x, y, 0) / cell_px) - 1);
    }
  });
  return field;
}

}  // namespace scanknit
