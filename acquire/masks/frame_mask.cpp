#include "acquire/masks/frame_mask.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace scanknit {
namespace {

/// For each pixel of the thing, its distance from the nearest pixel outside: 1 at the rim, at most kRimPixels + 1;
/// steps go along rows and columns. 0 outside.
Image<std::uint8_t> distances_from_outside(const Mask& mask) {
  constexpr int kFar = kRimPixels + 1;
  Image<std::uint8_t> distances(mask.width(), mask.height());
  const auto distance = [&](int x, int y) { return distances.contains(x, y) ? int{distances.at(x, y)} : kFar; };
  for (int y = 0; y < mask.height(); ++y) {
    for (int x = 0; x < mask.width(); ++x) {
      if (mask.at(x, y) < kHalfOfMask) continue;
      distances.at(x, y) = static_cast<std::uint8_t>(std::min({kFar, distance(x - 1, y) + 1, distance(x, y - 1) + 1}));
    }
  }
  for (int y = mask.height() - 1; y >= 0; --y) {
    for (int x = mask.width() - 1; x >= 0; --x) {
      distances.at(x, y) =
          static_cast<std::uint8_t>(std::min({distance(x, y), distance(x + 1, y) + 1, distance(x, y + 1) + 1}));
    }
  }
  return distances;
}

/// The pixels of a side of `from` that one of the same side of `to` pixels covers.
struct CoveredPixels {
  CoveredPixels(int at, int to, int from)
      : begin(1.0 * at * from / to),
        end(1.0 * (at + 1) * from / to),
        first(static_cast<int>(begin)),
        last(std::clamp(static_cast<int>(std::ceil(end)) - 1, first, from - 1)) {}
  /// Of the covered length.
  [[nodiscard]] double share(int pixel) const {
    return std::max(0.0, std::min<double>(end, pixel + 1) - std::max<double>(begin, pixel)) / (end - begin);
  }

  double begin, end;
  int first, last;
};

/// By the distance from outside.
std::array<std::uint8_t, kRimPixels + 2> weights_by_distance() {
  std::array<std::uint8_t, kRimPixels + 2> weights{};
  for (std::size_t distance = 1; distance < weights.size(); ++distance) {
    const double share = static_cast<double>(distance - 1) / kRimPixels;
    weights[distance] = static_cast<std::uint8_t>(255 * share * share + 0.5);
  }
  return weights;
}

}  // namespace

Mask resized(const Mask& mask, int width, int height) {
  if (mask.width() == width && mask.height() == height) return mask;
  Mask other(width, height);
  for (int y = 0; y < height; ++y) {
    const auto row = static_cast<int>((y + 0.5) * mask.height() / height);
    for (int x = 0; x < width; ++x) {
      other.at(x, y) = mask.at(static_cast<int>((x + 0.5) * mask.width() / width), row);
    }
  }
  return other;
}

Mask resized_by_mean(const Mask& mask, int width, int height) {
  if (mask.width() == width && mask.height() == height) return mask;
  Mask other(width, height);
  for (int y = 0; y < height; ++y) {
    const CoveredPixels rows(y, height, mask.height());
    for (int x = 0; x < width; ++x) {
      const CoveredPixels columns(x, width, mask.width());
      double sum = 0;
      for (int row = rows.first; row <= rows.last; ++row) {
        for (int column = columns.first; column <= columns.last; ++column) {
          sum += rows.share(row) * columns.share(column) * mask.at(column, row);
        }
      }
      other.at(x, y) = static_cast<std::uint8_t>(sum + 0.5);
    }
  }
  return other;
}

void keep_within(const Mask& mask, MaskMeans means, Frame& frame) {
  static const auto weights = weights_by_distance();
  const Image<std::uint8_t> distances = distances_from_outside(mask);
  frame.weights = Image<std::uint8_t>(mask.width(), mask.height());
  frame.outside_m = means == MaskMeans::kFree ? DepthImage(mask.width(), mask.height()) : DepthImage();
  for (std::size_t i = 0; i < mask.size(); ++i) {
    const std::uint8_t weight = weights[distances.pixels()[i]];
    frame.weights.pixels()[i] = weight;
    if (weight > 0) continue;
    const float depth_m = std::exchange(frame.depth_m.pixels()[i], 0.0f);
    if (means == MaskMeans::kFree) frame.outside_m.pixels()[i] = depth_m;
  }
}

Frame frame_of_class(const Frame& frame, std::uint8_t label, MaskMeans means) {
  Frame part = frame;
  for (std::uint8_t& value : part.labels.pixels()) value = value == label ? 255 : 0;
  keep_within(std::exchange(part.labels, {}), means, part);
  return part;
}

}  // namespace scanknit
