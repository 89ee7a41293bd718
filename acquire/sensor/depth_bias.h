// DepthCorrection: takes a sensor's systematic error out of its depth.
#pragma once

#include <array>

#include "acquire/acquire_config.h"
#include "core/image.h"

namespace scanknit {

/// A DepthBias for pictures of one size: z = z_measured / (1 + scale + shift z_measured). The divisor is held between
/// the two bounds below, so that depth stays finite, positive and in its order, however far away.
class DepthCorrection {
 public:
  static constexpr float kLeastDivisor = 0.8F, kMostDivisor = 1.25F;

  /// `bias` is valid. width, height >= 1.
  DepthCorrection(const DepthBias& bias, int width, int height);

  [[nodiscard]] bool fits(const DepthImage& depth_m) const {
    return depth_m.width() == one_plus_scale_.width() && depth_m.height() == one_plus_scale_.height();
  }

  /// `depth_m` fits. 0 stays 0. The same bits for any number of threads.
  void apply(DepthImage& depth_m) const;

 private:
  Image<float> one_plus_scale_, shift_per_m_;
};

/// Whether `bias` has columns and rows within its bounds, as many numbers as they say, and these within their bounds.
[[nodiscard]] bool is_valid(const DepthBias& bias);

/// The four numbers of a uniform cubic B-spline that make its value at a place (C. de Boor 1978).
struct SplineWeights {
  int first = 0;
  std::array<double, 4> weights{};
};

/// At 0 <= position <= 1, the ends of what `count` numbers span; places beyond count as the nearer end. count >= 4.
[[nodiscard]] SplineWeights spline_weights(double position, int count);

/// The position of a pixel's centre in a row or column of `pixels` pixels.
[[nodiscard]] inline double spline_position(double pixel, int pixels) {
  return (pixel + 0.5) / pixels;
}

}  // namespace scanknit
