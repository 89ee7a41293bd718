// InverseDepth: 1/z with a border, so that code can read around a pixel without checking the picture's edges.
#pragma once

#include <cstddef>

#include "core/image.h"
#include "core/pixels/pixel_rows.h"

namespace scanknit {

/// In 1/m; 0 for no return and in the border. A plane is linear in inverse depth over the picture.
class InverseDepth {
 public:
  static constexpr int kBorder = 15;  ///< on each side
  /// Additional columns on the right: a group of pixels may begin at the last pixel.
  static constexpr int kMargin = kPixelGroup;

  explicit InverseDepth(const DepthImage& depth_m);

  [[nodiscard]] const float* at(int x, int y) const { return &image_.at(x + kBorder, y + kBorder); }
  /// The step from a pixel to the one below it.
  [[nodiscard]] std::ptrdiff_t pitch() const { return image_.width(); }

 private:
  Image<float> image_;
};

}  // namespace scanknit
