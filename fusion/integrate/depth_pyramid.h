// DepthPyramid: tests whether any pixel of a rectangle has a range that meets a given range of z.
#pragma once

#include <vector>

#include "fusion/integrate/depth_ranges.h"

namespace scanknit {

/// Level 0 has one range for each pixel; every further level has the hulls of 2 x 2 ranges of the level below, up to 1
/// x 1.
class DepthPyramid {
 public:
  DepthPyramid() = default;
  explicit DepthPyramid(DepthRanges pixels);

  /// The hull of all pixels; empty when no pixel has a range.
  [[nodiscard]] DepthRange hull() const { return levels_.empty() ? DepthRange{} : levels_.back().at(0, 0); }

  /// True if a range in `rect` (clipped to the picture) meets `range`. Conservative: may be true although none does,
  /// because it tests only a few hulls; false is always right.
  [[nodiscard]] bool may_meet(const PixelRect& rect, const DepthRange& range) const;

  /// Like may_meet(), but more exact: tests pixel by pixel if `rect` is at most 16 x 16, else by small hulls.
  [[nodiscard]] DepthRanges::Sight look(const PixelRect& rect, const DepthRange& range) const;

 private:
  [[nodiscard]] bool clip(PixelRect& rect) const;
  [[nodiscard]] int level_for(const PixelRect& rect) const;
  [[nodiscard]] const DepthRanges& level(int number) const { return levels_[static_cast<std::size_t>(number)]; }

  std::vector<DepthRanges> levels_;
};

}  // namespace scanknit
