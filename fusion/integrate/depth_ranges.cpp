// Compiled once for each instruction set by Highway, which includes this file again through foreach_target.h.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fusion/integrate/depth_ranges.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <tbb/parallel_for.h>

#include <algorithm>

#include "core/pixels/pixel_vectors.inl"
#include "fusion/integrate/depth_ranges.h"

HWY_BEFORE_NAMESPACE();
namespace scanknit::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// Pairs of columns of two rows become one column each.
void halve_rows(const float* a, const float* b, int count, bool is_nearest, float* out) {
  const Floats f;
  const auto hull = [&](VF x, VF y) { return is_nearest ? hn::Min(x, y) : hn::Max(x, y); };
  for (int x = 0; x < count; x += static_cast<int>(hn::Lanes(f))) {
    VF a0, a1, b0, b1;
    hn::LoadInterleaved2(f, a + 2 * x, a0, a1);
    hn::LoadInterleaved2(f, b + 2 * x, b0, b1);
    hn::StoreU(hull(hull(a0, a1), hull(b0, b1)), f, out + x);
  }
}

/// Whether a run of ranges meets another range.
class Meeting {
 public:
  explicit Meeting(const DepthRange& range)
      : near_m_(hn::Set(Floats(), range.near_m)), far_m_(hn::Set(Floats(), range.far_m)) {}

  HWY_INLINE bool operator()(VF near_m, VF far_m, hn::Mask<Floats> counts) const {
    return !hn::AllFalse(Floats(), hn::And(counts, hn::And(hn::Le(near_m, far_m_), hn::Ge(far_m, near_m_))));
  }

 private:
  VF near_m_, far_m_;
};

bool meets(const DepthRanges& ranges, const PixelRect& rect, const DepthRange& range) {
  const Floats f;
  const Meeting is_met(range);
  for (int y = rect.y0; y <= rect.y1; ++y) {
    for (int x = rect.x0; x <= rect.x1; x += static_cast<int>(hn::Lanes(f))) {
      const auto counts = hn::FirstN(f, static_cast<std::size_t>(rect.x1 - x + 1));
      if (is_met(hn::LoadU(f, ranges.near_m(y) + x), hn::LoadU(f, ranges.far_m(y) + x), counts)) return true;
    }
  }
  return false;
}

DepthRanges::Sight look(const DepthRanges& ranges, const PixelRect& rect, const DepthRange& range) {
  const Floats f;
  const Meeting is_met(range);
  DepthRanges::Sight sight;
  VF farthest = hn::Set(f, sight.far_m);
  for (int x = rect.x0; x <= rect.x1; x += static_cast<int>(hn::Lanes(f))) {
    const auto counts = hn::FirstN(f, static_cast<std::size_t>(rect.x1 - x + 1));
    for (int y = rect.y0; y <= rect.y1; ++y) {
      const VF far_m = hn::LoadU(f, ranges.far_m(y) + x);
      sight.meets |= is_met(hn::LoadU(f, ranges.near_m(y) + x), far_m, counts);
      farthest = hn::Max(farthest, hn::IfThenElse(counts, far_m, farthest));
    }
  }
  sight.far_m = hn::GetLane(hn::MaxOfLanes(f, farthest));
  return sight;
}

}  // namespace scanknit::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace scanknit {

HWY_EXPORT(halve_rows);
HWY_EXPORT(meets);
HWY_EXPORT(look);

DepthRanges::DepthRanges(int width, int height) : DepthRanges(uninitialised(width, height)) {
  std::fill(near_m_.begin(), near_m_.end(), DepthRange{}.near_m);
  std::fill(far_m_.begin(), far_m_.end(), DepthRange{}.far_m);
}

DepthRanges DepthRanges::uninitialised(int width, int height) {
  DepthRanges ranges;
  ranges.width_ = width;
  ranges.height_ = height;
  ranges.stride_ = (static_cast<std::size_t>(width) / kPadding + 2) * kPadding;
  ranges.near_m_.resize(ranges.stride_ * static_cast<std::size_t>(height));
  ranges.far_m_.resize(ranges.near_m_.size());
  for (int y = 0; y < height; ++y) {
    std::fill(ranges.near_m(y) + width, ranges.near_m(y) + ranges.stride_, DepthRange{}.near_m);
    std::fill(ranges.far_m(y) + width, ranges.far_m(y) + ranges.stride_, DepthRange{}.far_m);
  }
  return ranges;
}

DepthRanges DepthRanges::halved() const {
  DepthRanges half = uninitialised((width_ + 1) / 2, (height_ + 1) / 2);
  tbb::parallel_for(0, half.height(), [&](int y) {
    const int last = std::min(2 * y + 1, height_ - 1);
    HWY_DYNAMIC_DISPATCH(halve_rows)(near_m(2 * y), near_m(last), half.width(), true, half.near_m(y));
    HWY_DYNAMIC_DISPATCH(halve_rows)(far_m(2 * y), far_m(last), half.width(), false, half.far_m(y));
  });
  return half;
}

bool DepthRanges::meets(const PixelRect& rect, const DepthRange& range) const {
  return HWY_DYNAMIC_DISPATCH(meets)(*this, rect, range);
}

DepthRanges::Sight DepthRanges::look(const PixelRect& rect, const DepthRange& range) const {
  return HWY_DYNAMIC_DISPATCH(look)(*this, rect, range);
}

}  // namespace scanknit
#endif
