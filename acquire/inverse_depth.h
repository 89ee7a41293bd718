// InverseDepth: 1/z with a border, for looking round a pixel without asking where the picture ends.
#pragma once

#include <algorithm>
#include <cstddef>

#include "core/image.h"

namespace scanknit {

/// 1/m; 0: no return, and all of the border. A plane is linear in inverse depth over the picture.
class InverseDepth {
 public:
  static constexpr int kBorder = 15;  ///< on each side
  static constexpr int kMargin = 8;   ///< more on the right: groups of pixels may begin at the last one

  explicit InverseDepth(const DepthImage& depth_m)
      : image_(depth_m.width() + 2 * kBorder + kMargin, depth_m.height() + 2 * kBorder) {
    for (int y = 0; y < depth_m.height(); ++y) {
      std::transform(depth_m.row(y).begin(), depth_m.row(y).end(), image_.row(y + kBorder).begin() + kBorder,
                     [](float z) { return z > 0 ? 1.0F / z : 0.0F; });
    }
  }

  [[nodiscard]] const float* at(int x, int y) const { return &image_.at(x + kBorder, y + kBorder); }
  /// From a pixel to the one below it.
  [[nodiscard]] std::ptrdiff_t pitch() const { return image_.width(); }

 private:
  Image<float> image_;
};

}  // namespace scanknit
