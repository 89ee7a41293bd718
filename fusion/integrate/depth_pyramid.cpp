#include "fusion/integrate/depth_pyramid.h"

#include <algorithm>
#include <utility>

namespace scanknit {
namespace {

/// The cells of a level that hold a rectangle of pixels.
PixelRect cells_of(const PixelRect& rect, int level) {
  return {rect.x0 >> level, rect.y0 >> level, rect.x1 >> level, rect.y1 >> level};
}

}  // namespace

DepthPyramid::DepthPyramid(DepthRanges pixels) {
  if (pixels.width() == 0 || pixels.height() == 0) return;
  levels_.push_back(std::move(pixels));
  while (levels_.back().width() > 1 || levels_.back().height() > 1) levels_.push_back(levels_.back().halved());
}

bool DepthPyramid::clip(PixelRect& rect) const {
  if (levels_.empty()) return false;
  rect.x0 = std::max(rect.x0, 0);
  rect.y0 = std::max(rect.y0, 0);
  rect.x1 = std::min(rect.x1, levels_.front().width() - 1);
  rect.y1 = std::min(rect.y1, levels_.front().height() - 1);
  return rect.x0 <= rect.x1 && rect.y0 <= rect.y1;
}

int DepthPyramid::level_for(const PixelRect& rect) const {
  // The first level at which the rectangle touches at most 3 cells a side.
  const int side = std::max(rect.x1 - rect.x0, rect.y1 - rect.y0);
  int level = 0;
  while ((side >> level) > 1 && level + 1 < static_cast<int>(levels_.size())) ++level;
  return level;
}

bool DepthPyramid::may_meet(const PixelRect& unclipped, const DepthRange& range) const {
  PixelRect rect = unclipped;
  if (!clip(rect)) return false;
  const int at = level_for(rect);
  return level(at).meets(cells_of(rect, at), range);
}

DepthRanges::Sight DepthPyramid::look(const PixelRect& unclipped, const DepthRange& range) const {
  PixelRect rect = unclipped;
  if (!clip(rect)) return {};
  const int at = level_for(rect);
  const int small = std::max(at - 2, 0);
  const DepthRanges::Sight seen = level(small).look(cells_of(rect, small), range);
  if (!seen.meets || at < 3) return seen;
  return {level(at - 3).meets(cells_of(rect, at - 3), range), seen.far_m};
}

}  // namespace scanknit
