#include "synth/sensor/depth_effects.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

namespace scanknit {
namespace {

/// Half of the eight neighbours: the other half are opposite.
constexpr std::array<std::pair<int, int>, 4> kHalfCircle = {{{1, 0}, {1, 1}, {0, 1}, {-1, 1}}};

double inverse_depth(const DepthImage& depth_m, int x, int y) {
  if (!depth_m.contains(x, y)) return -1;  // beyond the picture: unknown
  const auto z = static_cast<double>(depth_m.at(x, y));
  return z > 0 ? 1 / z : 0;
}

/// A row as the second centre sees it: at each of its pixels the largest disparity, without its sign.
std::vector<double> seen_from_second(std::span<const float> depth_m, double focal_times_baseline) {
  constexpr double kSameSurface_px = 2;  // neighbours whose places differ by more have a gap between them
  const auto width = static_cast<std::ptrdiff_t>(depth_m.size());
  std::vector<double> nearest(depth_m.size(), 0.0);
  double last = 0;
  bool has_last = false;
  for (std::ptrdiff_t x = 0; x < width; ++x) {
    const auto z = static_cast<double>(depth_m[static_cast<std::size_t>(x)]);
    if (!(z > 0)) {
      has_last = false;
      continue;
    }
    const double disparity = std::abs(focal_times_baseline) / z;
    const double place = static_cast<double>(x) - focal_times_baseline / z;
    const double from = has_last && std::abs(place - last) <= kSameSurface_px ? std::min(last, place) : place;
    const double to = has_last && std::abs(place - last) <= kSameSurface_px ? std::max(last, place) : place;
    const auto first = std::max(std::ptrdiff_t{0}, static_cast<std::ptrdiff_t>(std::lround(from)));
    const auto end = std::min(width - 1, static_cast<std::ptrdiff_t>(std::lround(to)));
    for (std::ptrdiff_t i = first; i <= end; ++i) {
      nearest[static_cast<std::size_t>(i)] = std::max(nearest[static_cast<std::size_t>(i)], disparity);
    }
    last = place;
    has_last = true;
  }
  return nearest;
}

bool is_step(const DepthImage& depth_m, int x, int y, const StepThreshold& threshold) {
  const auto z = static_cast<double>(depth_m.at(x, y));
  const double limit = std::max({threshold.floor_m, threshold.share * z, threshold.per_square_metre * z * z});
  for (const auto& [dx, dy] : kHalfCircle) {
    const double before = inverse_depth(depth_m, x - dx, y - dy);
    const double after = inverse_depth(depth_m, x + dx, y + dy);
    if (before < 0 || after < 0) continue;
    if (before == 0 || after == 0) return true;
    if (std::abs(before + after - 2 / z) * z * z > limit) return true;
  }
  return false;
}

}  // namespace

Image<std::uint8_t> occlusion_shadows(const DepthImage& depth_m, double focal_px, double baseline_m) {
  constexpr double kHides_px = 1;  // of disparity: a smaller step makes no shadow
  Image<std::uint8_t> shadow(depth_m.width(), depth_m.height());
  tbb::parallel_for(0, depth_m.height(), [&](int y) {
    const auto row = depth_m.row(y);
    const std::vector<double> nearest = seen_from_second(row, focal_px * baseline_m);
    for (int x = 0; x < depth_m.width(); ++x) {
      const auto z = static_cast<double>(row[static_cast<std::size_t>(x)]);
      if (!(z > 0)) continue;
      const double disparity = std::abs(focal_px * baseline_m) / z;
      const auto place = std::lround(x - focal_px * baseline_m / z);
      if (place < 0 || place >= depth_m.width()) continue;
      if (nearest[static_cast<std::size_t>(place)] > disparity + kHides_px) shadow.at(x, y) = 1;
    }
  });
  return shadow;
}

Image<std::uint8_t> depth_steps(const DepthImage& depth_m, const StepThreshold& threshold) {
  Image<std::uint8_t> steps(depth_m.width(), depth_m.height());
  tbb::parallel_for(0, depth_m.height(), [&](int y) {
    for (int x = 0; x < depth_m.width(); ++x) {
      if (depth_m.at(x, y) > 0 && is_step(depth_m, x, y, threshold)) steps.at(x, y) = 1;
    }
  });
  return steps;
}

Image<std::uint8_t> widened(const Image<std::uint8_t>& mask, int reach) {
  if (reach <= 0) return mask;
  Image<std::uint8_t> wide(mask.width(), mask.height());
  tbb::parallel_for(0, mask.height(), [&](int y) {
    for (int dy = std::max(0, y - reach); dy <= std::min(mask.height() - 1, y + reach); ++dy) {
      for (int x = 0; x < mask.width(); ++x) {
        if (mask.at(x, dy) == 0) continue;
        const int end = std::min(mask.width() - 1, x + reach);
        for (int i = std::max(0, x - reach); i <= end; ++i) wide.at(i, y) = 1;
      }
    }
  });
  return wide;
}

DepthImage smear_corners(const DepthImage& depth_m, double focal_px, double share, double radius_m) {
  if (!(share > 0) || !(radius_m > 0)) return depth_m;
  DepthImage smeared(depth_m.width(), depth_m.height());
  tbb::parallel_for(0, depth_m.height(), [&](int y) {
    for (int x = 0; x < depth_m.width(); ++x) {
      const auto z = static_cast<double>(depth_m.at(x, y));
      if (!(z > 0)) continue;
      const int reach = std::max(1, static_cast<int>(std::lround(focal_px * radius_m / z)));
      double nearest = 1 / z;
      for (const auto& [dx, dy] : kHalfCircle) {
        const double before = inverse_depth(depth_m, x - reach * dx, y - reach * dy);
        const double after = inverse_depth(depth_m, x + reach * dx, y + reach * dy);
        // Both sides must be parts of the same corner: not nearer or farther than its own size.
        const bool is_corner = before > 0 && after > 0 && std::abs(1 / before - z) < 2 * radius_m &&
                               std::abs(1 / after - z) < 2 * radius_m;
        if (is_corner) nearest = std::max(nearest, (before + after) / 2);
      }
      smeared.at(x, y) = static_cast<float>(1 / (1 / z + share * (nearest - 1 / z)));
    }
  });
  return smeared;
}

}  // namespace scanknit
