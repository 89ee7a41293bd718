// MaskedPixels: what the masks of a frame change in its observation.
#pragma once

#include <span>

#include "core/frame.h"
#include "fusion/integrate/depth_ranges.h"
#include "fusion/integrate/surface_image.h"
#include "fusion/integrate/surface_rows.h"
#include "fusion/integrate/update_block.h"

namespace scanknit {

/// Without masks, both functions do nothing. A pixel outside of the mask becomes a surface without weight: it never
/// moves a voxel of its band, but what stood in front of the band is carved. Rows are independent of each other.
class MaskedPixels {
 public:
  /// `frame` outlives it. Nothing is outside without carving.
  MaskedPixels(const Frame& frame, bool carves) : frame_(frame), has_outside_(carves && !frame.outside_m.empty()) {}

  /// Before the bands: row y of `surface` gets what lies outside, facing the camera.
  void add_outside(int y, const Rays& rays, SurfaceImage& surface) const;

  /// After them: each pixel's weight is multiplied by its share. Outside, the band is empty and ends where it began, so
  /// that no new block is made for it, while known blocks in front of it are still found.
  void weigh(int y, DepthRanges& bands, std::span<PixelPlane> planes) const;

 private:
  [[nodiscard]] bool is_outside(int x, int y) const {
    return has_outside_ && !(frame_.depth_m.at(x, y) > 0) && frame_.outside_m.at(x, y) > 0;
  }

  const Frame& frame_;
  bool has_outside_;
};

}  // namespace scanknit
