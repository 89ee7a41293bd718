#include "acquire/sensor/depth_bias.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "acquire/sensor/bias_rows.h"

namespace scanknit {
namespace {

using Numbers = std::vector<double>;

/// The field at every pixel.
Image<float> spread(const Numbers& numbers, const DepthBias& bias, int width, int height, double added) {
  std::vector<SplineWeights> across;
  for (int x = 0; x < width; ++x) across.push_back(spline_weights(spline_position(x, width), bias.columns));
  auto field = Image<float>::uninitialised(width, height);
  tbb::parallel_for(0, height, [&](int y) {
    const SplineWeights down = spline_weights(spline_position(y, height), bias.rows);
    Numbers row(static_cast<std::size_t>(bias.columns), added);
    for (std::size_t j = 0; j < down.weights.size(); ++j) {
      const auto begin = numbers.begin() + (down.first + static_cast<std::ptrdiff_t>(j)) * bias.columns;
      for (std::size_t i = 0; i < row.size(); ++i) row[i] += down.weights[j] * begin[static_cast<std::ptrdiff_t>(i)];
    }
    for (int x = 0; x < width; ++x) {
      const SplineWeights& at = across[static_cast<std::size_t>(x)];
      double value = 0;
      for (std::size_t i = 0; i < at.weights.size(); ++i) {
        value += at.weights[i] * row[static_cast<std::size_t>(at.first) + i];
      }
      field.at(x, y) = static_cast<float>(value);
    }
  });
  return field;
}

bool are_within(const Numbers& numbers, double most) {
  return std::all_of(numbers.begin(), numbers.end(), [most](double n) { return std::abs(n) <= most; });  // no NaN
}

}  // namespace

DepthCorrection::DepthCorrection(const DepthBias& bias, int width, int height)
    : one_plus_scale_(spread(bias.scale, bias, width, height, 1)),
      shift_per_m_(spread(bias.shift_per_m, bias, width, height, 0)) {}

void DepthCorrection::apply(DepthImage& depth_m) const {
  SCANKNIT_CHECK(fits(depth_m));
  tbb::parallel_for(0, depth_m.height(), [&](int y) {
    correct_row(one_plus_scale_.row(y), shift_per_m_.row(y), {kLeastDivisor, kMostDivisor}, depth_m.row(y));
  });
}

bool is_valid(const DepthBias& bias) {
  const auto is_count = [](int n) { return n >= DepthBias::kFewest && n <= DepthBias::kMost; };
  if (!is_count(bias.columns) || !is_count(bias.rows)) return false;
  const auto expected = static_cast<std::size_t>(bias.columns) * static_cast<std::size_t>(bias.rows);
  return bias.scale.size() == expected && bias.shift_per_m.size() == expected &&
         are_within(bias.scale, DepthBias::kMostScale) && are_within(bias.shift_per_m, DepthBias::kMostShift_per_m);
}

SplineWeights spline_weights(double position, int count) {
  const int cells = count - 3;
  const double place = std::clamp(position, 0.0, 1.0) * cells;
  const int cell = std::min(static_cast<int>(place), cells - 1);
  const double t = place - cell;
  const double s = 1 - t;
  return {cell,
          {s * s * s / 6, (3 * t * t * t - 6 * t * t + 4) / 6, (3 * s * s * s - 6 * s * s + 4) / 6, t * t * t / 6}};
}

}  // namespace scanknit
