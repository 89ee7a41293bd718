// DepthPyramid: does any pixel of a rectangle show something in a range of z?
#pragma once

#include <vector>

#include "fusion/integrate/depth_ranges.h"

namespace scanknit {

/// Level 0 holds one range a pixel; every further level the hull of 2 x 2 ranges of the one below, up to 1 x 1.
class DepthPyramid {
 public:
  DepthPyramid() = default;
  explicit DepthPyramid(DepthRanges pixels);

  /// The hull of all pixels; empty when no pixel has a range.
  [[nodiscard]] DepthRange hull() const { return levels_.empty() ? DepthRange{} : levels_.back().at(0, 0); }

  /// True if a range in `rect` (clipped to the picture) meets `range`. May be true without cause: it looks at a few
  /// hulls only. Never false without cause.
  [[nodiscard]] bool may_meet(const PixelRect& rect, const DepthRange& range) const;

  /// As may_meet, with fewer mistakes: pixel by pixel if `rect` is no larger than 16 x 16, else by small hulls.
  [[nodiscard]] DepthRanges::Sight look(const PixelRect& rect, const DepthRange& range) const;

 private:
  [[nodiscard]] bool clip(PixelRect& rect) const;
  [[nodiscard]] int level_for(const PixelRect& rect) const;
  [[nodiscard]] const DepthRanges& level(int number) const { return levels_[static_cast<std::size_t>(number)]; }

  std::vector<DepthRanges> levels_;
};

}  // namespace scanknit
