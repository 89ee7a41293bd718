// Compiled once for each instruction set by Highway, which includes this file again through foreach_target.h.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fusion/surface_rows.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <algorithm>
#include <array>

#include "fusion/surface_rows.h"

HWY_BEFORE_NAMESPACE();
namespace scanknit::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Floats = hn::CappedTag<float, kPixelGroup>;
using Ints = hn::RebindToSigned<Floats>;
using VF = hn::Vec<Floats>;

HWY_INLINE VF set(float value) {
  return hn::Set(Floats(), value);
}

// Loaded: hn::Iota is a loop of stores on some targets.
alignas(32) constexpr std::array<float, kPixelGroup> kLanes{0, 1, 2, 3, 4, 5, 6, 7};

HWY_INLINE VF ray_x(const Rays& rays, int x) {
  const VF at = hn::Add(set(static_cast<float>(x)), hn::Load(Floats(), kLanes.data()));
  return hn::Mul(hn::Sub(at, set(rays.cx)), set(rays.per_fx));
}

HWY_INLINE VF sigma_of(const FloatNoise& noise, VF z) {
  const VF beyond = hn::Sub(z, set(noise.from_m));
  return hn::Add(set(noise.floor_m), hn::Mul(set(noise.growth_per_m), hn::Mul(beyond, beyond)));
}

/// Calls group(x) for runs of Lanes pixels that cover first to before last; the last runs may overlap.
template <typename Group>
HWY_INLINE void for_each_group(int first, int last, const Group& group) {
  for (int x = first; x < last; x += kPixelGroup) {
    const int begin = std::min(x, last - kPixelGroup);
    for (int lane = 0; lane < kPixelGroup; lane += static_cast<int>(hn::Lanes(Floats()))) group(begin + lane);
  }
}

/// As pack().
HWY_INLINE hn::Vec<Ints> packed(VF nx, VF ny, VF nz) {
  const Ints i;
  const VF per_unit = set(1 / kNormalUnit);
  const auto code = [&](VF n) { return hn::NearestInt(hn::Mul(hn::Min(hn::Max(n, set(-1)), set(1)), per_unit)); };
  const auto faces_away = hn::VecFromMask(i, hn::RebindMask(i, hn::Gt(nz, set(0))));
  const auto y_and_sign = hn::Or(hn::And(code(ny), hn::Set(i, ~1)), hn::And(faces_away, hn::Set(i, 1)));
  return hn::Or(hn::And(code(nx), hn::Set(i, 0xFFFF)), hn::ShiftLeft<16>(y_and_sign));
}

void smooth_row(const DepthRows& rows, int y, const Rays& rays, const FloatNoise& noise, float* z_m,
                PackedNormal* normals) {
  const Floats f;
  const Ints i;
  const VF zero = hn::Zero(f);
  const VF ry = set((static_cast<float>(y) - rays.cy) * rays.per_fy);
  for_each_group(1, rows.width - 1, [&](int x) {
    const VF depth = hn::LoadU(f, rows.own + x);
    const auto has_return = hn::Gt(depth, zero);
    if (hn::AllFalse(f, has_return)) return;
    const VF rx = ray_x(rays, x);
    const VF away = hn::Div(set(-1), hn::Sqrt(hn::Add(hn::Add(hn::Mul(rx, rx), hn::Mul(ry, ry)), set(1))));
    VF nx = hn::Mul(rx, away), ny = hn::Mul(ry, away), nz = away;
    if (rows.normals != nullptr) {
      VF given_x, given_y, given_z;
      hn::LoadInterleaved3(f, rows.normals[x].data(), given_x, given_y, given_z);
      const auto is_given = hn::Or(hn::Ne(given_x, zero), hn::Or(hn::Ne(given_y, zero), hn::Ne(given_z, zero)));
      nx = hn::IfThenElse(is_given, given_x, nx);
      ny = hn::IfThenElse(is_given, given_y, ny);
      nz = hn::IfThenElse(is_given, given_z, nz);
    }
    const VF slope = hn::Add(hn::Add(hn::Mul(nx, rx), hn::Mul(ny, ry)), nz);
    const VF offset = hn::Mul(slope, depth);
    const VF same = hn::Mul(set(kSameSurfaceSigmas), sigma_of(noise, depth));
    const VF per_x = hn::Mul(nx, set(rays.per_fx));
    const VF per_y = hn::Mul(ny, set(rays.per_fy));
    VF sum = zero;
    VF weights = zero;
    const auto add = [&](const float* row, int dx, VF slope_there, float weight) {
      const VF other = hn::LoadU(f, row + x + dx);
      const VF off = hn::Sub(hn::Mul(slope_there, other), offset);
      const auto is_same = hn::And(hn::Gt(other, zero), hn::Le(hn::Abs(off), same));
      sum = hn::Add(sum, hn::IfThenElseZero(is_same, hn::Mul(off, set(weight))));
      weights = hn::Add(weights, hn::IfThenElseZero(is_same, set(weight)));
    };
    const auto add_row = [&](const float* row, VF slope_below, float weight) {
      add(row, -1, hn::Sub(slope_below, per_x), weight);
      add(row, 0, slope_below, 2 * weight);
      add(row, 1, hn::Add(slope_below, per_x), weight);
    };
    add_row(rows.above, hn::Sub(slope, per_y), 1);
    add_row(rows.own, slope, 2);
    add_row(rows.below, hn::Add(slope, per_y), 1);

    const VF moved = hn::Add(depth, hn::Div(sum, hn::Mul(weights, slope)));
    const VF smoothed = hn::IfThenElse(hn::Lt(slope, set(-kMinSmoothedSlope)), moved, depth);
    hn::StoreU(hn::IfThenElseZero(has_return, smoothed), f, z_m + x);
    const auto codes = hn::IfThenElseZero(hn::RebindMask(i, has_return), packed(nx, ny, nz));
    hn::StoreU(codes, i, reinterpret_cast<std::int32_t*>(normals + x));
  });
}

void band_row(const float* z_m, const PackedNormal* normals, int width, int y, const Rays& rays, const Band& band,
              DepthRange* ranges) {
  const Floats f;
  const Ints i;
  const VF ry = set((static_cast<float>(y) - rays.cy) * rays.per_fy);
  const VF unit = set(kNormalUnit);
  const DepthRange nothing;
  for_each_group(0, width, [&](int x) {
    const VF z = hn::LoadU(f, z_m + x);
    const auto code = hn::LoadU(i, reinterpret_cast<const std::int32_t*>(normals + x));
    const VF nx = hn::Mul(hn::ConvertTo(f, hn::ShiftRight<16>(hn::ShiftLeft<16>(code))), unit);
    const VF ny = hn::Mul(hn::ConvertTo(f, hn::ShiftRight<16>(code)), unit);
    const VF nz_squared = hn::Sub(hn::Sub(set(1), hn::Mul(nx, nx)), hn::Mul(ny, ny));
    const auto sign = hn::And(hn::ShiftLeft<15>(code), hn::Set(i, static_cast<std::int32_t>(0x80000000u)));
    const VF nz = hn::Xor(hn::Neg(hn::Sqrt(hn::Max(hn::Zero(f), nz_squared))), hn::BitCast(f, sign));
    const VF slope = hn::Add(hn::Add(hn::Mul(nx, ray_x(rays, x)), hn::Mul(ny, ry)), nz);
    const VF truncation = hn::Max(set(band.least_m), hn::Mul(set(band.sigmas), sigma_of(band.noise, z)));
    const VF before = hn::Div(truncation, hn::Max(hn::Neg(slope), set(kMinBandSlope)));
    const auto is_seen = hn::Gt(z, hn::Zero(f));
    const VF near = hn::IfThenElse(is_seen, hn::Sub(z, before), set(nothing.near_m));
    const VF far = hn::IfThenElse(is_seen, hn::Add(z, truncation), set(nothing.far_m));
    hn::StoreInterleaved2(near, far, f, &ranges[x].near_m);
  });
}

}  // namespace scanknit::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace scanknit {

HWY_EXPORT(smooth_row);
HWY_EXPORT(band_row);

void smooth_row(const DepthRows& rows, int y, const Rays& rays, const FloatNoise& noise, float* z_m,
                PackedNormal* normals) {
  HWY_DYNAMIC_DISPATCH(smooth_row)(rows, y, rays, noise, z_m, normals);
}

void band_row(std::span<const float> z_m, const PackedNormal* normals, int y, const Rays& rays, const Band& band,
              DepthRange* ranges) {
  const auto width = static_cast<int>(z_m.size());
  if (width >= kPixelGroup) {
    HWY_DYNAMIC_DISPATCH(band_row)(z_m.data(), normals, width, y, rays, band, ranges);
    return;
  }
  std::array<float, kPixelGroup> wide_z{};
  std::array<PackedNormal, kPixelGroup> wide_normals{};
  std::array<DepthRange, kPixelGroup> wide_ranges;
  std::copy(z_m.begin(), z_m.end(), wide_z.begin());
  std::copy(normals, normals + width, wide_normals.begin());
  HWY_DYNAMIC_DISPATCH(band_row)(wide_z.data(), wide_normals.data(), kPixelGroup, y, rays, band, wide_ranges.data());
  std::copy(wide_ranges.begin(), wide_ranges.begin() + width, ranges);
}

}  // namespace scanknit
#endif
