// The fraction of a pixel of a disparity. Private to the room.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>

namespace scanknit {

/// A grey picture; rows follow one another without padding.
struct GreyView {
  std::span<const std::uint8_t> pixels;
  int width = 0, height = 0;

  [[nodiscard]] const std::uint8_t* row(int y) const {
    return pixels.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(width);
  }
};

/// The disparity near `disparity_px` by which the surroundings of (x, y) in the left picture look most like those in
/// the right one, each less its mean: least squares along the row (B. D. Lucas and T. Kanade 1981), two steps.
/// SGBM's own fractions, from costs of whole pixels, lean towards whole pixels. What has too little texture, lies too
/// near to a border, or moves by more than what SGBM may miss, stays as it is.
[[nodiscard]] inline float refine_disparity(const GreyView& left, const GreyView& right, int x, int y,
                                            float disparity_px) {
  constexpr int kHalf = 3, kSteps = 2;
  constexpr float kMostMove_px = 0.7F;
  constexpr int kPixels = (2 * kHalf + 1) * (2 * kHalf + 1);
  constexpr float kLeastSlope = 2;  // grey levels a pixel, in the mean
  if (x < kHalf || x >= left.width - kHalf || y < kHalf || y >= left.height - kHalf) return disparity_px;
  float refined = disparity_px;
  for (int step = 0; step < kSteps; ++step) {
    const float at = static_cast<float>(x) - refined;
    const float whole = std::floor(at);
    const float part = at - whole;
    const int x_right = static_cast<int>(whole);
    // One pixel more than the surroundings on either side, for the slope.
    if (x_right < kHalf + 1 || x_right + kHalf + 2 >= right.width) return disparity_px;
    float slopes = 0, differences = 0, slopes_squared = 0, products = 0;
    for (int j = -kHalf; j <= kHalf; ++j) {
      const std::uint8_t* l = left.row(y + j) + x - kHalf;
      const std::uint8_t* r = right.row(y + j) + x_right - kHalf;
      for (int i = 0; i <= 2 * kHalf; ++i) {
        const float value = static_cast<float>(r[i]) + part * static_cast<float>(r[i + 1] - r[i]);
        const float slope = 0.5F * (static_cast<float>(r[i + 1] - r[i - 1]) +
                                    part * static_cast<float>(r[i + 2] - r[i] - r[i + 1] + r[i - 1]));
        const float difference = static_cast<float>(l[i]) - value;
        slopes += slope;
        differences += difference;
        slopes_squared += slope * slope;
        products += slope * difference;
      }
    }
    const float spread = slopes_squared - slopes * slopes / kPixels;
    if (!(spread > kPixels * kLeastSlope * kLeastSlope)) return disparity_px;
    refined -= (products - slopes * differences / kPixels) / spread;
    if (!(std::abs(refined - disparity_px) <= kMostMove_px)) return disparity_px;
  }
  return refined;
}

/// Sums over pixels of both pictures.
struct LikenessSums {
  float count = 0, left = 0, right = 0, left_squared = 0, right_squared = 0, products = 0;

  void add(float l, float r) { *this += {1, l, r, l * l, r * r, l * r}; }
  LikenessSums& operator+=(const LikenessSums& other) {
    count += other.count;
    left += other.left;
    right += other.right;
    left_squared += other.left_squared;
    right_squared += other.right_squared;
    products += other.products;
    return *this;
  }
  /// Whether their correlation is at least `least`: false where one of them does not change at all.
  [[nodiscard]] bool is_correlated(float least) const {
    const float left_spread = left_squared - left * left / count;
    const float right_spread = right_squared - right * right / count;
    const float common = products - left * right / count;
    constexpr float kRounding = 1e-3F;
    return common > kRounding && common * common >= least * least * left_spread * right_spread;
  }
};

/// Whether the match is more than what SGBM, for the sake of smoothness, goes on with where there is nothing to see:
/// the upper, lower, left and right half of the surroundings each correlate with those in the right picture. Bare walls
/// and backgrounds fail, whatever their noise, and so does the fringe that widens things beyond their edges.
[[nodiscard]] inline bool is_alike_on_all_sides(const GreyView& left, const GreyView& right, int x, int y,
                                                float disparity_px) {
  constexpr int kHalf = 3;
  constexpr float kLeast = 0.5F;
  if (x < kHalf || x >= left.width - kHalf || y < kHalf || y >= left.height - kHalf) return false;
  const float at = static_cast<float>(x) - disparity_px;
  const float whole = std::floor(at);
  const float part = at - whole;
  const int x_right = static_cast<int>(whole);
  if (x_right < kHalf || x_right + kHalf + 1 >= right.width) return false;
  LikenessSums parts[3][3];  // before, at and after the pixel, by rows and by columns
  const auto part_of = [](int step) { return step < 0 ? 0 : step == 0 ? 1 : 2; };
  for (int j = -kHalf; j <= kHalf; ++j) {
    const std::uint8_t* l = left.row(y + j) + x;
    const std::uint8_t* r = right.row(y + j) + x_right;
    for (int i = -kHalf; i <= kHalf; ++i) {
      const float value = static_cast<float>(r[i]) + part * static_cast<float>(r[i + 1] - r[i]);
      parts[part_of(j)][part_of(i)].add(static_cast<float>(l[i]), value);
    }
  }
  for (const int first : {0, 1}) {  // the half before, and the half after, with the pixel's own row or column
    LikenessSums rows, columns;
    for (int own = first; own < first + 2; ++own) {
      for (int other = 0; other < 3; ++other) {
        rows += parts[own][other];
        columns += parts[other][own];
      }
    }
    if (!rows.is_correlated(kLeast) || !columns.is_correlated(kLeast)) return false;
  }
  return true;
}

}  // namespace scanknit
