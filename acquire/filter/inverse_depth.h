// InverseDepth: 1/z with a border, for looking round a pixel without asking where the picture ends.
#pragma once

#include <cstddef>

#include "core/image.h"
#include "core/pixel_rows.h"

namespace scanknit {

/// 1/m; 0: no return, and all of the border. A plane is linear in inverse depth over the picture.
class InverseDepth {
 public:
  static constexpr int kBorder = 15;  ///< on each side
  /// More on the right: groups of pixels may begin at the last one.
  static constexpr int kMargin = kPixelGroup;

  explicit InverseDepth(const DepthImage& depth_m);

  [[nodiscard]] const float* at(int x, int y) const { return &image_.at(x + kBorder, y + kBorder); }
  /// From a pixel to the one below it.
  [[nodiscard]] std::ptrdiff_t pitch() const { return image_.width(); }

 private:
  Image<float> image_;
};

}  // namespace scanknit
