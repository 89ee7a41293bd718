#include "fusion/depth_pyramid.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <utility>

namespace scanknit {
namespace {

DepthRange hull_of(const DepthRange& a, const DepthRange& b) {
  return {std::min(a.near_m, b.near_m), std::max(a.far_m, b.far_m)};
}

Image<DepthRange> halved(const Image<DepthRange>& fine) {
  Image<DepthRange> coarse((fine.width() + 1) / 2, (fine.height() + 1) / 2);
  tbb::parallel_for(0, coarse.height(), [&](int y) {
    for (int fine_y = 2 * y; fine_y < std::min(2 * y + 2, fine.height()); ++fine_y) {
      for (int x = 0; x < fine.width(); ++x) {
        DepthRange& cell = coarse.at(x / 2, y);
        cell = hull_of(cell, fine.at(x, fine_y));
      }
    }
  });
  return coarse;
}

/// Calls visit(range) for the cells of a level that a rectangle of pixels touches, until it gives false.
template <typename Visit>
void for_each_cell(const Image<DepthRange>& cells, const PixelRect& rect, int level, const Visit& visit) {
  for (int y = rect.y0 >> level; y <= rect.y1 >> level; ++y) {
    for (int x = rect.x0 >> level; x <= rect.x1 >> level; ++x) {
      if (!visit(cells.at(x, y))) return;
    }
  }
}

}  // namespace

DepthPyramid::DepthPyramid(Image<DepthRange> pixels) {
  if (pixels.empty()) return;
  levels_.push_back(std::move(pixels));
  while (levels_.back().size() > 1) levels_.push_back(halved(levels_.back()));
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
  const int level = level_for(rect);
  bool is_met = false;
  for_each_cell(levels_[static_cast<std::size_t>(level)], rect, level, [&](const DepthRange& cell) {
    is_met = cell.meets(range);
    return !is_met;
  });
  return is_met;
}

DepthPyramid::Sight DepthPyramid::look(const PixelRect& unclipped, const DepthRange& range) const {
  Sight sight;
  PixelRect rect = unclipped;
  if (!clip(rect)) return sight;
  const int level = level_for(rect);
  const auto& coarse = levels_[static_cast<std::size_t>(std::max(level - 2, 0))];
  for_each_cell(coarse, rect, std::max(level - 2, 0), [&](const DepthRange& cell) {
    sight.may_meet |= cell.meets(range);
    sight.far_m = std::max(sight.far_m, cell.far_m);
    return true;
  });
  if (!sight.may_meet || level < 3) return sight;
  sight.may_meet = false;
  for_each_cell(levels_[static_cast<std::size_t>(level - 3)], rect, level - 3, [&](const DepthRange& cell) {
    sight.may_meet = cell.meets(range);
    return !sight.may_meet;
  });
  return sight;
}

}  // namespace scanknit
