// DepthRanges: a picture of ranges of z.
#pragma once

#include <cstddef>
#include <vector>

#include "core/image.h"
#include "core/pixels/pixel_rows.h"
#include "fusion/picture_part.h"

namespace scanknit {

/// z from near_m to far_m along a pixel's ray. The default is the empty range, which meets nothing.
struct DepthRange {
  float near_m = 1e30f;
  float far_m = -1e30f;

  [[nodiscard]] bool meets(const DepthRange& other) const { return near_m <= other.far_m && far_m >= other.near_m; }
};

/// One range for each pixel, in two planes. Empty ranges follow each row, for vectors that reach beyond its end.
class DepthRanges {
 public:
  static constexpr int kPadding = kPixelGroup;

  DepthRanges() = default;
  DepthRanges(int width, int height);  ///< all empty
  /// For ranges that are all written before they are read: fills in only those behind the rows' ends.
  [[nodiscard]] static DepthRanges uninitialised(int width, int height);

  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }

  [[nodiscard]] DepthRange at(int x, int y) const { return {near_m(y)[x], far_m(y)[x]}; }
  [[nodiscard]] float* near_m(int y) { return near_m_.data() + first_of(y); }
  [[nodiscard]] float* far_m(int y) { return far_m_.data() + first_of(y); }
  [[nodiscard]] const float* near_m(int y) const { return near_m_.data() + first_of(y); }
  [[nodiscard]] const float* far_m(int y) const { return far_m_.data() + first_of(y); }

  /// The hulls of 2 x 2 ranges each.
  [[nodiscard]] DepthRanges halved() const;

  /// `rect` lies within the picture in all of these.
  [[nodiscard]] bool meets(const PixelRect& rect, const DepthRange& range) const;
  struct Sight {
    bool meets = false;
    float far_m = DepthRange{}.far_m;  ///< the farthest end of all ranges
  };
  [[nodiscard]] Sight look(const PixelRect& rect, const DepthRange& range) const;

 private:
  [[nodiscard]] std::size_t first_of(int y) const { return static_cast<std::size_t>(y) * stride_; }

  int width_ = 0;
  int height_ = 0;
  std::size_t stride_ = 0;
  std::vector<float, UninitialisedAllocator<float>> near_m_, far_m_;
};

}  // namespace scanknit
