#include "acquire/filter/depth_filter.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <optional>
#include <utility>

#include "acquire/filter/depth_rows.h"
#include "acquire/filter/inverse_depth.h"
#include "acquire/filter/outlier_filter.h"

namespace scanknit {
namespace {

constexpr int kReach = 2;  // a neighbour may lie behind a hole of one pixel
constexpr int kBilateralRadius = 2;
constexpr double kBilateralSigma_px = 1.5;
constexpr double kBilateralRangeSigmas = 2.0;  // two measurements of one surface differ by 1.4 sigma

// Calls body(y) for every row; rows are independent, so that the number of threads does not matter.
template <typename Body>
void for_each_row(int height, Body body) {
  tbb::parallel_for(tbb::blocked_range<int>(0, height), [&](const tbb::blocked_range<int>& rows) {
    for (int y = rows.begin(); y != rows.end(); ++y) body(y);
  });
}

struct Neighbour {
  int distance = 0;            // pixels
  double inverse_depth = 0.0;  // 1/m
};

// The nearest valid pixel within kReach of (x, y) + start * step, going by `step`.
std::optional<Neighbour> nearest_valid(const DepthImage& depth_m, int x, int y, int dx, int dy, int start) {
  for (int i = start + 1; i <= start + kReach; ++i) {
    const int u = x + i * dx;
    const int v = y + i * dy;
    if (!depth_m.contains(u, v)) return std::nullopt;
    if (depth_m.at(u, v) > 0) return Neighbour{i, 1.0 / static_cast<double>(depth_m.at(u, v))};
  }
  return std::nullopt;
}

// How many standard deviations the pixel is off the plane through its neighbours along (dx, dy). Along a row or column
// a plane is linear in inverse depth, so that its slope does not matter. The line goes through one neighbour on each
// side, or, where one side is empty, through two on the other.
double deviation(const DepthImage& depth_m, int x, int y, int dx, int dy, double sigma_m) {
  auto before = nearest_valid(depth_m, x, y, -dx, -dy, 0);
  auto after = nearest_valid(depth_m, x, y, dx, dy, 0);
  double weight_before = 0;
  double weight_after = 0;
  if (before && after) {
    weight_before = static_cast<double>(after->distance) / (before->distance + after->distance);
    weight_after = 1 - weight_before;
  } else if (before || after) {
    const bool backwards = before.has_value();
    if (!backwards) before = after;
    const int sign = backwards ? -1 : 1;
    after = nearest_valid(depth_m, x, y, sign * dx, sign * dy, before->distance);
    if (!after) return 0;
    weight_before = static_cast<double>(after->distance) / (after->distance - before->distance);
    weight_after = 1 - weight_before;
  } else {
    return 0;
  }
  const double expected = weight_before * before->inverse_depth + weight_after * after->inverse_depth;
  const double spread = std::sqrt(1 + weight_before * weight_before + weight_after * weight_after);
  const double z = depth_m.at(x, y);
  // A difference e of inverse depths is about e z^2 in metres.
  return std::abs(1 / z - expected) * z * z / (sigma_m * spread);
}

}  // namespace

DepthImage clip_range(const DepthImage& depth_m, double min_m, double max_m) {
  DepthImage clipped = depth_m;
  for (float& z : clipped.pixels()) {
    const double depth = z;
    if (depth < min_m || (max_m > 0 && depth > max_m)) z = 0;
  }
  return clipped;
}

DepthImage mask_discontinuities(const DepthImage& depth_m, const NoiseModel& noise, double sigmas) {
  DepthImage masked = depth_m;
  if (!(sigmas > 0)) return masked;
  const InverseDepth inverse(depth_m);
  const FloatNoise noise_in_float(noise);
  for_each_row(depth_m.height(), [&](int y) {
    for (int x = 0; x < depth_m.width(); x += kPixelGroup) {
      const auto along_x = find_deviations(noise_in_float, inverse.at(x, y), 1, static_cast<float>(sigmas));
      const auto along_y =
          find_deviations(noise_in_float, inverse.at(x, y), inverse.pitch(), static_cast<float>(sigmas));
      unsigned deviates = along_x.deviates | along_y.deviates;
      for (unsigned unsure = (along_x.is_unsure | along_y.is_unsure) & ~deviates; unsure != 0; unsure &= unsure - 1) {
        const int lane = std::countr_zero(unsure);
        const double sigma_m = noise.sigma_m(depth_m.at(x + lane, y));
        const auto is_off = [&](int dx, int dy) { return deviation(depth_m, x + lane, y, dx, dy, sigma_m) > sigmas; };
        deviates |= is_off(1, 0) || is_off(0, 1) ? 1u << lane : 0;
      }
      for (; deviates != 0; deviates &= deviates - 1) masked.at(x + std::countr_zero(deviates), y) = 0;
    }
  });
  return masked;
}

DepthImage smooth_bilateral(const DepthImage& depth_m, const NoiseModel& noise) {
  constexpr int kSide = 2 * kBilateralRadius + 1;
  std::array<std::array<float, kSide>, kSide> nearness{};
  for (int j = 0; j < kSide; ++j) {
    for (int i = 0; i < kSide; ++i) {
      const int d2 = (i - kBilateralRadius) * (i - kBilateralRadius) + (j - kBilateralRadius) * (j - kBilateralRadius);
      nearness[static_cast<std::size_t>(j)][static_cast<std::size_t>(i)] =
          static_cast<float>(std::exp(-d2 / (2 * kBilateralSigma_px * kBilateralSigma_px)));
    }
  }
  DepthImage smooth(depth_m.width(), depth_m.height());
  for_each_row(depth_m.height(), [&](int y) {
    const int top = std::max(y - kBilateralRadius, 0);
    const int bottom = std::min(y + kBilateralRadius, depth_m.height() - 1);
    for (int x = 0; x < depth_m.width(); ++x) {
      const float z = depth_m.at(x, y);
      if (!(z > 0)) continue;
      const auto range_sigma_m = static_cast<float>(kBilateralRangeSigmas * noise.sigma_m(z));
      const float scale = -0.5F / (range_sigma_m * range_sigma_m);
      float sum = 0;  // of differences to z, which keeps float's digits
      float total = 0;
      for (int v = top; v <= bottom; ++v) {
        const auto& near_row = nearness[static_cast<std::size_t>(v - y + kBilateralRadius)];
        for (int u = std::max(x - kBilateralRadius, 0); u <= std::min(x + kBilateralRadius, depth_m.width() - 1); ++u) {
          const float neighbour = depth_m.at(u, v);
          if (!(neighbour > 0)) continue;
          const float difference = neighbour - z;
          const float weight =
              near_row[static_cast<std::size_t>(u - x + kBilateralRadius)] * std::exp(difference * difference * scale);
          sum += weight * difference;
          total += weight;
        }
      }
      smooth.at(x, y) = z + sum / total;  // total >= 1: the pixel itself
    }
  });
  return smooth;
}

Result<void> filter_frame(Frame& frame, const AcquireConfig& config, const NoiseModel& noise) {
  const double min_m = config.min_depth_m.value_or(0);
  const double max_m = config.max_depth_m.value_or(0);
  if (min_m > 0 || max_m > 0) frame.depth_m = clip_range(frame.depth_m, min_m, max_m);
  if (config.outlier_neighbours > 0) {
    auto cleaned =
        remove_statistical_outliers(frame.depth_m, frame.intrinsics, config.outlier_neighbours, config.outlier_sigmas);
    if (!cleaned) return cleaned.error();
    frame.depth_m = *std::move(cleaned);
  }
  if (config.edge_sigmas > 0) frame.depth_m = mask_discontinuities(frame.depth_m, noise, config.edge_sigmas);
  if (config.bilateral) frame.depth_m = smooth_bilateral(frame.depth_m, noise);
  frame.normals = estimate_normals(frame.depth_m, frame.intrinsics, noise);
  return {};
}

}  // namespace scanknit
