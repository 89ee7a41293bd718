// Silhouette: signed distances to the outline of a thing in one picture.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/camera.h"
#include "core/image.h"

namespace scanknit {

/// Pixels; the mean of both axes.
[[nodiscard]] inline double focal_length(const CameraIntrinsics& camera) {
  return (std::abs(camera.fx) + std::abs(camera.fy)) / 2;
}

/// A rectangle of pixel coordinates, both ends inclusive.
struct OutlineRect {
  double left, top, right, bottom;
};

/// The outline is where a mask, interpolated bilinearly between the centres of its pixels, passes half of 255. A mask
/// of only two values is smoothed by 0.7 pixel first: its outline would be a staircase; a line one pixel wide stays.
class Silhouette {
 public:
  /// `mask`: 0 background, 255 the thing, between them its share of the pixel; not empty. `reach_px`: distances beyond
  /// it are not measured, > 0 and at most kLongestReach_px.
  Silhouette(const Image<std::uint8_t>& mask, double reach_px);
  static constexpr double kLongestReach_px = 250;

  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }
  [[nodiscard]] double reach_px() const { return reach_px_; }

  /// True if (u, v) lies among the centres of the picture's pixels: elsewhere it says nothing.
  [[nodiscard]] bool sees(double u, double v) const { return u >= 0 && v >= 0 && u <= width_ - 1 && v <= height_ - 1; }
  /// Pixels to the outline, positive outside of it; between -reach_px() and reach_px(). Only where it sees.
  [[nodiscard]] float distance_px(double u, double v) const;

  /// The least and the greatest distance within a rectangle, or in pixels beside it.
  struct Range {
    float least_px, greatest_px;
  };
  /// Nothing if the rectangle reaches beyond what the picture sees.
  [[nodiscard]] std::optional<Range> range_px(const OutlineRect& rect) const;

  /// The pixels of the thing; nothing if there are none.
  [[nodiscard]] std::optional<OutlineRect> bounds() const { return bounds_; }
  /// The mean of their positions.
  [[nodiscard]] double middle_u() const { return middle_u_; }
  [[nodiscard]] double middle_v() const { return middle_v_; }

 private:
  using Step = std::int16_t;  ///< of kSteps a pixel
  static constexpr float kSteps = 128;
  struct Tile {
    Step least, greatest;
  };
  void measure(const Image<float>& level);
  void note_tiles();
  void note_bounds();

  int width_, height_;
  double reach_px_;
  Image<Step> distances_;
  std::vector<Image<Tile>> tiles_;  ///< of 8 x 8 pixels, of 16 x 16, ...
  std::optional<OutlineRect> bounds_;
  double middle_u_ = 0, middle_v_ = 0;
};

inline float Silhouette::distance_px(double u, double v) const {
  const int x = std::min(static_cast<int>(u), std::max(0, width_ - 2));
  const int y = std::min(static_cast<int>(v), std::max(0, height_ - 2));
  const auto right = static_cast<float>(u - x);
  const auto down = static_cast<float>(v - y);
  const int next_x = std::min(x + 1, width_ - 1);
  const int next_y = std::min(y + 1, height_ - 1);
  const auto value = [&](int column, int row) { return static_cast<float>(distances_.at(column, row)); };
  const float above = value(x, y) + (value(next_x, y) - value(x, y)) * right;
  const float below = value(x, next_y) + (value(next_x, next_y) - value(x, next_y)) * right;
  return (above + (below - above) * down) / kSteps;
}

}  // namespace scanknit
