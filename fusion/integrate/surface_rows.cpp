// Compiled once for each instruction set by Highway, which includes this file again through foreach_target.h.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fusion/integrate/surface_rows.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <algorithm>
#include <array>

#include "core/pixels/pixel_vectors.inl"
#include "fusion/integrate/surface_rows.h"

HWY_BEFORE_NAMESPACE();
namespace scanknit::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

HWY_INLINE VF ray_x(const Rays& rays, int x) {
  const VF at = hn::Add(set(static_cast<float>(x)), lane_numbers());
  return hn::Mul(hn::Sub(at, set(rays.cx)), set(rays.per_fx));
}

using Words = hn::RebindToUnsigned<Floats>;

/// The upper half of a float, rounded to the nearest; the lower half means nothing.
HWY_INLINE hn::Vec<Words> rounded_half(VF number) {
  const Words w;
  const auto word = hn::BitCast(w, number);
  const auto last = hn::And(hn::ShiftRight<16>(word), hn::Set(w, 1));
  return hn::Add(word, hn::Add(last, hn::Set(w, 0x7FFF)));
}

void smooth_row(const DepthRows& rows, int y, const Rays& rays, const FloatNoise& noise, float* z_m,
                Eigen::Vector3f* normals) {
  const Floats f;
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
    hn::StoreInterleaved3(nx, ny, nz, f, normals[x].data());
  });
}

void band_row(const float* z_m, const Eigen::Vector3f* normals, int width, int y, const Rays& rays, const Band& band,
              float* near_m, float* far_m, PixelPlane* planes) {
  const Floats f;
  const VF ry = set((static_cast<float>(y) - rays.cy) * rays.per_fy);
  const DepthRange nothing;
  for_each_group(0, width, [&](int x) {
    const VF z = hn::LoadU(f, z_m + x);
    const VF rx = ray_x(rays, x);
    VF nx, ny, nz;
    hn::LoadInterleaved3(f, normals[x].data(), nx, ny, nz);
    const VF slope = hn::Add(hn::Add(hn::Mul(nx, rx), hn::Mul(ny, ry)), nz);
    const VF sigma = sigma_of(band.noise, z);
    const VF truncation = hn::Max(set(band.least_m), hn::Mul(set(band.sigmas), sigma));
    const VF towards = hn::Max(hn::Neg(slope), hn::Zero(f));
    const VF before = hn::Div(truncation, hn::Max(towards, set(kMinBandSlope)));
    const auto is_seen = hn::Gt(z, hn::Zero(f));
    const VF near = hn::IfThenElse(is_seen, hn::Sub(z, before), set(nothing.near_m));
    const VF far = hn::IfThenElse(is_seen, hn::Add(z, truncation), set(nothing.far_m));
    hn::StoreU(near, f, near_m + x);
    hn::StoreU(far, f, far_m + x);

    const VF ray = hn::Sqrt(hn::Add(hn::Add(hn::Mul(rx, rx), hn::Mul(ry, ry)), set(1)));
    const VF weight = hn::Div(hn::Mul(towards, set(band.best_variance)), hn::Mul(hn::Mul(sigma, sigma), ray));
    const auto word = [](VF upper, VF lower) {
      return hn::Or(hn::And(rounded_half(upper), hn::Set(Words(), 0xFFFF0000)),
                    hn::ShiftRight<16>(rounded_half(lower)));
    };
    hn::StoreInterleaved4(hn::BitCast(Words(), hn::IfThenElseZero(is_seen, z)), hn::BitCast(Words(), slope),
                          word(hn::Mul(nx, set(rays.per_fx)), hn::Mul(ny, set(rays.per_fy))),
                          word(hn::Div(set(1), truncation), weight), Words(),
                          reinterpret_cast<std::uint32_t*>(planes + x));
  });
}

}  // namespace scanknit::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace scanknit {

HWY_EXPORT(smooth_row);
HWY_EXPORT(band_row);

void smooth_row(const DepthRows& rows, int y, const Rays& rays, const FloatNoise& noise, float* z_m,
                Eigen::Vector3f* normals) {
  HWY_DYNAMIC_DISPATCH(smooth_row)(rows, y, rays, noise, z_m, normals);
}

void band_row(std::span<const float> z_m, const Eigen::Vector3f* normals, int y, const Rays& rays, const Band& band,
              DepthRanges& ranges, PixelPlane* planes) {
  const auto width = static_cast<int>(z_m.size());
  if (width >= kPixelGroup) {
    HWY_DYNAMIC_DISPATCH(band_row)
    (z_m.data(), normals, width, y, rays, band, ranges.near_m(y), ranges.far_m(y), planes);
    return;
  }
  std::array<float, kPixelGroup> wide_z{};
  std::array<Eigen::Vector3f, kPixelGroup> wide_normals;
  std::array<PixelPlane, kPixelGroup> wide_planes;
  wide_normals.fill(Eigen::Vector3f::Zero());
  std::copy(z_m.begin(), z_m.end(), wide_z.begin());
  std::copy(normals, normals + width, wide_normals.begin());
  HWY_DYNAMIC_DISPATCH(band_row)
  (wide_z.data(), wide_normals.data(), kPixelGroup, y, rays, band, ranges.near_m(y), ranges.far_m(y),
   wide_planes.data());
  std::copy(wide_planes.begin(), wide_planes.begin() + width, planes);
}

}  // namespace scanknit
#endif
