// Rasterises triangles exactly, so that neighbours neither overlap nor leave a gap.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

namespace scanknit {

/// Fixed point: the steps in a texel. Texel (x, y) has its centre at (x, y) * kTexelSteps.
inline constexpr std::int64_t kTexelSteps = 256;

struct TexelPoint {
  std::int32_t x = 0, y = 0;  ///< in steps
  friend bool operator==(const TexelPoint&, const TexelPoint&) = default;
};

[[nodiscard]] constexpr int first_texel(std::int64_t steps) {
  return static_cast<int>((steps + kTexelSteps - 1) >> 8);
}
[[nodiscard]] constexpr int last_texel(std::int64_t steps) {
  return static_cast<int>(steps >> 8);
}
static_assert(kTexelSteps == 1 << 8);

/// Twice the signed area of (a, b, p). Exact for coordinates within +-2^30.
[[nodiscard]] constexpr std::int64_t texel_edge(const TexelPoint& a, const TexelPoint& b, std::int64_t x,
                                                std::int64_t y) {
  return (std::int64_t{b.x} - a.x) * (y - a.y) - (std::int64_t{b.y} - a.y) * (x - a.x);
}

/// Calls `visit(x, y, weights)` for every texel whose centre is in the triangle, row by row; `weights` are those of the
/// corners, with the sum 1. A centre on an edge belongs to exactly one of its two triangles. The winding does not
/// matter; a triangle without area has no texels. Stops and returns false when `visit` returns false.
template <typename Visit>
bool for_each_texel(std::array<TexelPoint, 3> p, Visit&& visit) {
  std::int64_t area = texel_edge(p[0], p[1], p[2].x, p[2].y);
  if (area == 0) return true;
  const bool is_turned = area < 0;
  if (is_turned) {
    std::swap(p[1], p[2]);
    area = -area;
  }
  // A centre on an edge belongs to the triangle whose edge goes up, or horizontally to the left: in the neighbour that
  // edge goes the other way.
  const auto owns = [](const TexelPoint& a, const TexelPoint& b) { return b.y > a.y || (b.y == a.y && b.x < a.x); };
  const std::array<std::int64_t, 3> least = {owns(p[1], p[2]) ? 0 : 1, owns(p[2], p[0]) ? 0 : 1,
                                             owns(p[0], p[1]) ? 0 : 1};
  const auto [x_low, x_high] = std::minmax({p[0].x, p[1].x, p[2].x});
  const auto [y_low, y_high] = std::minmax({p[0].y, p[1].y, p[2].y});
  const float inverse_area = 1 / static_cast<float>(area);
  for (int y = first_texel(y_low); y <= last_texel(y_high); ++y) {
    for (int x = first_texel(x_low); x <= last_texel(x_high); ++x) {
      const std::int64_t e0 = texel_edge(p[1], p[2], x * kTexelSteps, y * kTexelSteps);
      const std::int64_t e1 = texel_edge(p[2], p[0], x * kTexelSteps, y * kTexelSteps);
      const std::int64_t e2 = texel_edge(p[0], p[1], x * kTexelSteps, y * kTexelSteps);
      if (e0 < least[0] || e1 < least[1] || e2 < least[2]) continue;
      const float w1 = static_cast<float>(e1) * inverse_area, w2 = static_cast<float>(e2) * inverse_area;
      const std::array<float, 3> weights = {1 - w1 - w2, is_turned ? w2 : w1, is_turned ? w1 : w2};
      if (!visit(x, y, weights)) return false;
    }
  }
  return true;
}

}  // namespace scanknit
