#include "fusion/integrate/masked_pixels.h"

#include <bit>
#include <cstdint>

namespace scanknit {
namespace {

constexpr std::uint32_t kUpperHalf = 0xFFFF0000;

/// Multiplies the weight, which is the upper half of a float in the lower half of its word.
void scale_weight(float share, PixelPlane& plane) {
  const float weight = std::bit_cast<float>(plane.per_truncation_and_weight << 16) * share;
  const std::uint32_t half_a_step = 0x8000;
  const std::uint32_t rounded = (std::bit_cast<std::uint32_t>(weight) + half_a_step) >> 16;
  plane.per_truncation_and_weight = (plane.per_truncation_and_weight & kUpperHalf) | rounded;
}

}  // namespace

void MaskedPixels::add_outside(int y, const Rays& rays, SurfaceImage& surface) const {
  if (!has_outside_) return;
  for (int x = 0; x < surface.z_m.width(); ++x) {
    if (!is_outside(x, y)) continue;
    surface.z_m.at(x, y) = frame_.outside_m.at(x, y);
    surface.normals.at(x, y) = -rays.at(x, y).normalized();
  }
}

void MaskedPixels::weigh(int y, DepthRanges& bands, std::span<PixelPlane> planes) const {
  if (!has_outside_ && frame_.weights.empty()) return;
  constexpr float kPerWhole = 1.0f / 255.0f;
  float* const near_m = bands.near_m(y);
  float* const far_m = bands.far_m(y);
  for (std::size_t i = 0; i < planes.size(); ++i) {
    const int x = static_cast<int>(i);
    if (is_outside(x, y)) {
      scale_weight(0, planes[i]);
      far_m[i] = near_m[i];
      near_m[i] = DepthRange{}.near_m;
    } else if (!frame_.weights.empty()) {
      scale_weight(static_cast<float>(frame_.weights.at(x, y)) * kPerWhole, planes[i]);
    }
  }
}

}  // namespace scanknit
