// Compiled once for each instruction set by Highway, which includes this file again through foreach_target.h.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "acquire/sensor/bias_rows.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <algorithm>

#include "acquire/sensor/bias_rows.h"
#include "core/pixels/pixel_vectors.inl"

HWY_BEFORE_NAMESPACE();
namespace scanknit::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

void correct_row(const float* one_plus_scale, const float* shift_per_m, DivisorBounds bounds, float* z_m, int width) {
  const Floats f;
  int x = 0;
  for (const auto lanes = static_cast<int>(hn::Lanes(f)); x + lanes <= width; x += lanes) {
    const VF z = hn::LoadU(f, z_m + x);
    const VF divisor = hn::Add(hn::LoadU(f, one_plus_scale + x), hn::Mul(hn::LoadU(f, shift_per_m + x), z));
    const VF held = hn::Min(hn::Max(divisor, set(bounds.least)), set(bounds.most));
    hn::StoreU(hn::IfThenElseZero(hn::Gt(z, hn::Zero(f)), hn::Div(z, held)), f, z_m + x);
  }
  for (; x < width; ++x) {
    const float divisor = one_plus_scale[x] + shift_per_m[x] * z_m[x];
    z_m[x] = z_m[x] > 0 ? z_m[x] / std::min(std::max(divisor, bounds.least), bounds.most) : 0;
  }
}

}  // namespace scanknit::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace scanknit {

HWY_EXPORT(correct_row);

void correct_row(std::span<const float> one_plus_scale, std::span<const float> shift_per_m, DivisorBounds bounds,
                 std::span<float> z_m) {
  HWY_DYNAMIC_DISPATCH(correct_row)
  (one_plus_scale.data(), shift_per_m.data(), bounds, z_m.data(), static_cast<int>(z_m.size()));
}

}  // namespace scanknit
#endif
