#include "acquire/filter/inverse_depth.h"

#include <tbb/parallel_for.h>

#include <algorithm>

#include "acquire/filter/depth_rows.h"

namespace scanknit {

InverseDepth::InverseDepth(const DepthImage& depth_m)
    : image_(Image<float>::uninitialised(depth_m.width() + 2 * kBorder + kMargin, depth_m.height() + 2 * kBorder)) {
  tbb::parallel_for(0, image_.height(), [&](int row) {
    const auto inverse = image_.row(row);
    const int y = row - kBorder;
    if (y < 0 || y >= depth_m.height()) {
      std::ranges::fill(inverse, 0.0F);
      return;
    }
    std::fill_n(inverse.begin(), kBorder, 0.0F);
    invert_row(depth_m.row(y), inverse.data() + kBorder);
    std::fill_n(inverse.end() - (kBorder + kMargin), kBorder + kMargin, 0.0F);
  });
}

}  // namespace scanknit
