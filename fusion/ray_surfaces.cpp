// Compiled once for each instruction set by Highway, which includes this file again through foreach_target.h.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fusion/ray_surfaces.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <limits>

#include "fusion/luma.h"
#include "fusion/ray_surfaces.h"

HWY_BEFORE_NAMESPACE();
namespace scanknit::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Floats = hn::CappedTag<float, kPixelGroup>;
using Ints = hn::RebindToSigned<Floats>;
using Codes = hn::RebindToUnsigned<Floats>;
using VF = hn::Vec<Floats>;
using MF = hn::Mask<Floats>;

constexpr float kAgreement = 0.5f;  // voxels: Newton's last step is no longer than this

HWY_INLINE VF set(float value) {
  return hn::Set(Floats(), value);
}
HWY_INLINE VF mix(VF a, VF b, VF share) {
  return hn::Add(a, hn::Mul(hn::Sub(b, a), share));
}

/// Cells of eight samples, one for each pixel; corner x + 2 y + 4 z.
template <typename T>
struct alignas(32) Cells {
  std::array<std::array<T, kPixelGroup>, 8> corner;
};

/// Places on the rays of some neighbouring pixels: their cells, and where in these.
struct Places {
  VF x, y, z;  ///< from the cell's lowest corner
};

struct Field {
  VF value;
  VF gradient_x, gradient_y, gradient_z;
};

/// Eight rays, as many at once as the processor takes.
class Finder {
 public:
  HWY_INLINE Finder(const Eye& eye, const RayGroup& rays, VoxelReader& voxels)
      : eye_(eye), rays_(rays), voxels_(voxels) {}

  HWY_INLINE void find(std::size_t lane, SeenGroup& seen) {
    const Floats f;
    const VF zero = hn::Zero(f);
    const VF outside_z = lanes(rays_.outside_z_m, lane);
    const VF matter_z = lanes(rays_.matter_z_m, lane);
    const VF voxel_z = lanes(rays_.voxel_z_m, lane);
    MF is_seen = hn::And(hn::Gt(outside_z, zero), hn::Gt(matter_z, zero));
    hn::StoreU(zero, f, seen.depth_m.data() + lane);
    if (hn::AllFalse(f, is_seen)) return;

    const VF outside = lanes(rays_.outside_m, lane);
    const VF drop = hn::IfThenElse(is_seen, hn::Sub(outside, lanes(rays_.matter_m, lane)), set(1));
    const VF guess_z = mix(outside_z, matter_z, hn::Div(outside, drop));
    const VF first_z = hn::Sub(outside_z, voxel_z);
    const VF last_z = hn::Add(matter_z, voxel_z);
    const auto step_from = [&](VF z, Field& field) {
      field = field_at(lane, z, is_seen);
      const VF slope = along_ray(field, lane);
      const MF falls = hn::Lt(slope, zero);
      const VF step = hn::IfThenElseZero(falls, hn::Div(field.value, hn::IfThenElse(falls, slope, set(-1))));
      return hn::Min(hn::Max(hn::Sub(z, step), first_z), last_z);
    };
    Field field;
    const VF better_z = step_from(guess_z, field);
    const VF final_z = step_from(better_z, field);
    const VF last_step = hn::Abs(hn::Sub(final_z, better_z));
    is_seen = hn::And(
        is_seen, hn::And(hn::Lt(along_ray(field, lane), zero), hn::Le(last_step, hn::Mul(set(kAgreement), voxel_z))));
    if (hn::AllFalse(f, is_seen)) return;
    hn::StoreU(hn::IfThenElseZero(is_seen, final_z), f, seen.depth_m.data() + lane);
    hn::StoreU(field.gradient_x, f, seen.gradient[0].data() + lane);
    hn::StoreU(field.gradient_y, f, seen.gradient[1].data() + lane);
    hn::StoreU(field.gradient_z, f, seen.gradient[2].data() + lane);
  }

  HWY_INLINE void find_intensity(std::size_t lane, SeenGroup& seen) {
    const Floats f;
    const VF z = lanes(seen.depth_m, lane);
    const MF is_seen = hn::Gt(z, hn::Zero(f));
    if (!hn::AllFalse(f, is_seen)) hn::StoreU(intensity_at(lane, z, is_seen), f, seen.intensity.data() + lane);
  }

 private:
  static HWY_INLINE VF lanes(const PixelLanes& all, std::size_t lane) { return hn::LoadU(Floats(), all.data() + lane); }

  HWY_INLINE VF along_ray(const Field& field, std::size_t lane) const {
    return hn::Add(hn::Add(hn::Mul(field.gradient_x, lanes(rays_.step[0], lane)),
                           hn::Mul(field.gradient_y, lanes(rays_.step[1], lane))),
                   hn::Mul(field.gradient_z, lanes(rays_.step[2], lane)));
  }

  static constexpr VoxelReader::At kNowhere{std::numeric_limits<int>::max(), 0, 0};

  /// The cells round the places where depth is z; those of pixels that are not `wanted` mean nothing.
  HWY_INLINE Places places_at(std::size_t lane, VF z, MF wanted) {
    const Floats f;
    const Ints i;
    const auto along = [&](std::size_t axis) {
      const VF p = hn::Add(set(eye_.start[axis]), hn::Mul(z, lanes(rays_.step[axis], lane)));
      const VF low = hn::Floor(hn::IfThenElseZero(wanted, p));
      hn::StoreU(hn::ConvertTo(i, low), i, low_[axis].data());
      return hn::Sub(p, low);
    };
    hn::StoreU(hn::IfThenElseZero(wanted, set(1)), f, wanted_.data());
    return {along(0), along(1), along(2)};
  }
  [[nodiscard]] HWY_INLINE VoxelReader::At low_of(std::size_t pixel) const {
    return {low_[0][pixel], low_[1][pixel], low_[2][pixel]};
  }

  /// Trilinear. A pixel whose cell is not known all round is no longer `wanted`.
  HWY_INLINE Field field_at(std::size_t lane, VF z, MF& wanted) {
    const Floats f;
    const Places at = places_at(lane, z, wanted);
    for (std::size_t pixel = 0; pixel < hn::Lanes(f); ++pixel) {
      if (!(wanted_[pixel] > 0)) continue;
      const VoxelReader::At low = low_of(pixel);
      if (low == in_cells_[pixel]) continue;
      in_cells_[pixel] = low;
      if (!voxels_.distances(low, cells_.corner[0].data() + pixel, kPixelGroup)) {
        in_cells_[pixel] = kNowhere;
        wanted_[pixel] = 0;
      }
    }
    wanted = hn::Gt(hn::LoadU(f, wanted_.data()), hn::Zero(f));
    const auto corner = [&](std::size_t n) { return hn::LoadU(f, cells_.corner[n].data()); };
    const VF dx00 = hn::Sub(corner(1), corner(0)), dx10 = hn::Sub(corner(3), corner(2));
    const VF dx01 = hn::Sub(corner(5), corner(4)), dx11 = hn::Sub(corner(7), corner(6));
    const VF x00 = hn::Add(corner(0), hn::Mul(dx00, at.x)), x10 = hn::Add(corner(2), hn::Mul(dx10, at.x));
    const VF x01 = hn::Add(corner(4), hn::Mul(dx01, at.x)), x11 = hn::Add(corner(6), hn::Mul(dx11, at.x));
    const VF y0 = mix(x00, x10, at.y), y1 = mix(x01, x11, at.y);
    return {mix(y0, y1, at.z), mix(mix(dx00, dx10, at.y), mix(dx01, dx11, at.y), at.z),
            mix(hn::Sub(x10, x00), hn::Sub(x11, x01), at.z), hn::Sub(y1, y0)};
  }

  /// Trilinear over the voxels that have a colour.
  HWY_INLINE VF intensity_at(std::size_t lane, VF z, MF wanted) {
    const Floats f;
    const Places at = places_at(lane, z, wanted);
    Cells<ColourCode> cells{};
    for (std::size_t pixel = 0; pixel < hn::Lanes(f); ++pixel) {
      if (wanted_[pixel] > 0) voxels_.colours(low_of(pixel), cells.corner[0].data() + pixel, kPixelGroup);
    }
    const Codes c;
    const VF one = set(1);
    const VF rest_x = hn::Sub(one, at.x), rest_y = hn::Sub(one, at.y), rest_z = hn::Sub(one, at.z);
    VF sum = hn::Zero(f);
    VF weights = hn::Zero(f);
    for (std::size_t n = 0; n < 8; ++n) {
      const auto code = hn::LoadU(c, cells.corner[n].data());
      const auto has_colour = hn::RebindMask(f, hn::Ne(hn::ShiftRight<24>(code), hn::Zero(c)));
      const VF share =
          hn::Mul(hn::Mul((n & 1) != 0 ? at.x : rest_x, (n & 2) != 0 ? at.y : rest_y), (n & 4) != 0 ? at.z : rest_z);
      const VF weight = hn::IfThenElseZero(has_colour, share);
      const auto channel = [&](auto shifted) {
        return hn::ConvertTo(f, hn::BitCast(Ints(), hn::And(shifted, hn::Set(c, 0xFF))));
      };
      const VF brightness = hn::Add(hn::Add(hn::Mul(set(luma(1, 0, 0)), channel(code)),
                                            hn::Mul(set(luma(0, 1, 0)), channel(hn::ShiftRight<8>(code)))),
                                    hn::Mul(set(luma(0, 0, 1)), channel(hn::ShiftRight<16>(code))));
      sum = hn::Add(sum, hn::Mul(weight, brightness));
      weights = hn::Add(weights, weight);
    }
    const MF some = hn::Gt(weights, hn::Zero(f));
    return hn::IfThenElse(some, hn::Div(sum, hn::IfThenElse(some, hn::Mul(set(255), weights), one)), set(-1));
  }

  const Eye& eye_;
  const RayGroup& rays_;
  VoxelReader& voxels_;
  std::array<std::array<std::int32_t, kPixelGroup>, 3> low_{};
  PixelLanes wanted_{};
  Cells<float> cells_{};  ///< the last that were read for each pixel ...
  std::array<VoxelReader::At, kPixelGroup> in_cells_{kNowhere, kNowhere, kNowhere, kNowhere, kNowhere,
                                                     kNowhere, kNowhere, kNowhere};  ///< ... and where these are
};

void find_surfaces(const Eye& eye, const RayGroup& rays, VoxelReader& voxels, SeenGroup& seen) {
  Finder finder(eye, rays, voxels);
  for (std::size_t lane = 0; lane < kPixelGroup; lane += hn::Lanes(Floats())) finder.find(lane, seen);
}

void find_intensities(const Eye& eye, const RayGroup& rays, VoxelReader& voxels, SeenGroup& seen) {
  Finder finder(eye, rays, voxels);
  for (std::size_t lane = 0; lane < kPixelGroup; lane += hn::Lanes(Floats())) finder.find_intensity(lane, seen);
}

}  // namespace scanknit::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace scanknit {
namespace {

/// The sample below and beside a place on a ray, plus `offset` along each axis.
VoxelReader::At sample_at(const Eye& eye, const RayGroup& rays, std::size_t lane, float z_m, float offset) {
  const auto along = [&](std::size_t axis) {
    return VoxelReader::floor_of(eye.start[axis] + z_m * rays.step[axis][lane] + offset);
  };
  return {along(0), along(1), along(2)};
}

/// Free space may end at the wall of a block that was not looked at, since all of it is free: whoever met matter first
/// looks back by one voxel.
void look_back(const Eye& eye, VoxelReader& voxels, RayGroup& rays) {
  for (std::size_t lane = 0; lane < kPixelGroup; ++lane) {
    if (!(rays.matter_z_m[lane] > 0) || rays.outside_z_m[lane] > 0) continue;
    const float z_m = rays.matter_z_m[lane] - rays.voxel_z_m[lane];
    const auto value = voxels.distance(sample_at(eye, rays, lane, z_m, 0.5f));
    if (!value || *value <= 0) continue;
    rays.outside_z_m[lane] = z_m;
    rays.outside_m[lane] = *value;
  }
}

}  // namespace

HWY_EXPORT(find_surfaces);
HWY_EXPORT(find_intensities);

void find_surfaces(const Eye& eye, RayGroup& rays, VoxelReader& voxels, SeenGroup& seen) {
  look_back(eye, voxels, rays);
  HWY_DYNAMIC_DISPATCH(find_surfaces)(eye, rays, voxels, seen);
}

void find_intensities(const Eye& eye, const RayGroup& rays, VoxelReader& voxels, SeenGroup& seen) {
  HWY_DYNAMIC_DISPATCH(find_intensities)(eye, rays, voxels, seen);
}

void prefetch_intensities(const Eye& eye, const RayGroup& rays, VoxelReader& voxels, const SeenGroup& seen) {
  for (std::size_t lane = 0; lane < kPixelGroup; ++lane) {
    if (seen.depth_m[lane] > 0) voxels.prefetch_colours(sample_at(eye, rays, lane, seen.depth_m[lane], 0));
  }
}

}  // namespace scanknit
#endif
