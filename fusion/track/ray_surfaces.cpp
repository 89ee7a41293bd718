// Compiled once for each instruction set by Highway, which includes this file again through foreach_target.h.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fusion/track/ray_surfaces.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "fusion/register/luma.h"
#include "fusion/track/ray_surfaces.h"

HWY_BEFORE_NAMESPACE();
namespace scanknit::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Floats = hn::CappedTag<float, kPatchRays>;
using Ints = hn::RebindToSigned<Floats>;
using Codes = hn::RebindToUnsigned<Floats>;
using VF = hn::Vec<Floats>;
using VI = hn::Vec<Ints>;
using MF = hn::Mask<Floats>;
using MI = hn::Mask<Ints>;

constexpr float kAgreement = 0.5f;  // voxels: Newton's last step is no longer than this

HWY_INLINE VF set(float value) {
  return hn::Set(Floats(), value);
}
HWY_INLINE VF mix(VF a, VF b, VF share) {
  return hn::Add(a, hn::Mul(hn::Sub(b, a), share));
}

/// A coordinate of samples, and what it adds to the numbers that find them in BlockCopies.
struct Along {
  VI at, slot, key, offset;

  template <int kAxis>
  static HWY_INLINE Along axis(VI at) {
    using Copies = BlockCopies<float>;
    const Ints i;
    const auto lowest = [&](VI v, int bits) { return hn::And(v, hn::Set(i, (1 << bits) - 1)); };
    return {
        at, hn::ShiftLeft<kAxis * Copies::kSlotBits>(lowest(hn::ShiftRight<3>(at), Copies::kSlotBits)),
        hn::ShiftLeft<kAxis * Copies::kKeyBits>(lowest(hn::ShiftRight<3 + Copies::kSlotBits>(at), Copies::kKeyBits)),
        hn::ShiftLeft<3 * (2 - kAxis)>(lowest(at, 3))};
  }
};

/// Samples of the pixels that are `wanted`.
struct Distances {
  static const BlockCopies<float>& copies(const TileSamples& samples) { return samples.distances(); }
  static std::int32_t round(TileSamples& samples, const openvdb::Coord& at) { return samples.distances_round(at); }
};
struct Colours {
  static const BlockCopies<std::uint32_t>& copies(const TileSamples& samples) { return samples.colours(); }
  static std::int32_t round(TileSamples& samples, const openvdb::Coord& at) { return samples.colours_round(at); }
};

/// Where the blocks of those pixels begin that have not been copied; fills in `starts`.
template <typename Samples>
HWY_NOINLINE void copy_missing(TileSamples& samples, const std::array<VI, 3>& at, MF is_missing, std::int32_t* starts) {
  const Ints i;
  alignas(64) std::array<std::array<std::int32_t, kPatchRays>, 3> places;
  alignas(64) RayLanes missing;
  for (std::size_t axis = 0; axis < 3; ++axis) hn::Store(at[axis], i, places[axis].data());
  hn::Store(hn::IfThenElseZero(is_missing, set(1)), Floats(), missing.data());
  for (std::size_t pixel = 0; pixel < hn::Lanes(i); ++pixel) {
    if (missing[pixel] > 0)
      starts[pixel] = Samples::round(samples, {places[0][pixel], places[1][pixel], places[2][pixel]});
  }
}

/// Where the `wanted` samples lie among the copies.
template <typename Samples>
HWY_INLINE VI places_of(TileSamples& samples, const Along& x, const Along& y, const Along& z, MF wanted) {
  const Ints i;
  const VI slot = hn::Or(hn::Or(x.slot, y.slot), z.slot);
  const VI key = hn::Or(hn::Or(x.key, y.key), z.key);
  const auto& copies = Samples::copies(samples);
  const MI is_found = hn::Eq(hn::GatherIndex(i, copies.keys(), slot), key);
  VI starts = hn::IfThenElseZero(is_found, hn::GatherIndex(i, copies.starts(), slot));
  const MF is_there = hn::RebindMask(Floats(), is_found);
  const MF is_missing = hn::AndNot(is_there, wanted);
  if (HWY_UNLIKELY(!hn::AllFalse(Floats(), is_missing))) {
    alignas(64) std::array<std::int32_t, kPatchRays> all;
    hn::Store(starts, i, all.data());
    copy_missing<Samples>(samples, {x.at, y.at, z.at}, is_missing, all.data());
    starts = hn::Load(i, all.data());
  }
  return hn::Add(starts, hn::Or(hn::Or(x.offset, y.offset), z.offset));
}

/// The cells round some places.
struct Cells {
  std::array<Along, 2> x, y, z;
  VF in_x, in_y, in_z;  ///< from the cell's lowest corner
};

struct Field {
  VF value;
  VF gradient_x, gradient_y, gradient_z;
};

/// Some rays of a patch, as many as the processor takes at once.
class Finder {
 public:
  HWY_INLINE Finder(const Eye& eye, const RayPatch& rays, std::size_t lane, TileSamples& samples)
      : eye_(eye), rays_(rays), lane_(lane), samples_(samples) {}

  HWY_INLINE void find(const Eigen::Matrix3f& R_camera_world, SeenPatch& seen) {
    const Floats f;
    const VF zero = hn::Zero(f);
    const VF matter_z = lanes(rays_.matter_z_m);
    const VF voxel_z = lanes(rays_.voxel_z_m);
    const MF has_matter = hn::Gt(matter_z, zero);
    VF depth = zero, nx = zero, ny = zero, nz = zero, intensity = set(-1);
    if (!hn::AllFalse(f, has_matter)) {
      VF outside_z = lanes(rays_.outside_z_m);
      VF outside = lanes(rays_.outside_m);
      look_back(matter_z, voxel_z, has_matter, outside_z, outside);
      MF is_seen = hn::And(hn::Gt(outside_z, zero), has_matter);

      const VF drop = hn::IfThenElse(is_seen, hn::Sub(outside, lanes(rays_.matter_m)), set(1));
      const VF guess_z = mix(outside_z, matter_z, hn::Div(outside, drop));
      const VF first_z = hn::Sub(outside_z, voxel_z);
      const VF last_z = hn::Add(matter_z, voxel_z);
      const auto step_from = [&](VF z, Field& field) {
        field = field_at(z, is_seen);
        const VF slope = along_ray(field);
        const MF falls = hn::Lt(slope, zero);
        const VF step = hn::IfThenElseZero(falls, hn::Div(field.value, hn::IfThenElse(falls, slope, set(-1))));
        return hn::Min(hn::Max(hn::Sub(z, step), first_z), last_z);
      };
      Field field;
      const VF better_z = step_from(guess_z, field);
      const VF final_z = step_from(better_z, field);
      const VF last_step = hn::Abs(hn::Sub(final_z, better_z));
      is_seen = hn::And(is_seen,
                        hn::And(hn::Lt(along_ray(field), zero), hn::Le(last_step, hn::Mul(set(kAgreement), voxel_z))));
      depth = hn::IfThenElseZero(is_seen, final_z);
      const auto turned = [&](int row) {
        return hn::Add(hn::Mul(set(R_camera_world(row, 0)), field.gradient_x),
                       hn::Add(hn::Mul(set(R_camera_world(row, 1)), field.gradient_y),
                               hn::Mul(set(R_camera_world(row, 2)), field.gradient_z)));
      };
      nx = turned(0), ny = turned(1), nz = turned(2);
      const VF squared = hn::Add(hn::Mul(nx, nx), hn::Add(hn::Mul(ny, ny), hn::Mul(nz, nz)));
      const VF length = hn::IfThenElse(is_seen, hn::Sqrt(squared), set(1));
      nx = hn::IfThenElseZero(is_seen, hn::Div(nx, length));
      ny = hn::IfThenElseZero(is_seen, hn::Div(ny, length));
      nz = hn::IfThenElseZero(is_seen, hn::Div(nz, length));
      if (!hn::AllFalse(f, is_seen)) intensity = hn::IfThenElse(is_seen, intensity_at(depth, is_seen), set(-1));
    }
    hn::Store(depth, f, seen.depth_m.data() + lane_);
    hn::Store(nx, f, seen.normal[0].data() + lane_);
    hn::Store(ny, f, seen.normal[1].data() + lane_);
    hn::Store(nz, f, seen.normal[2].data() + lane_);
    hn::Store(intensity, f, seen.intensity.data() + lane_);
  }

 private:
  HWY_INLINE VF lanes(const RayLanes& all) const { return hn::Load(Floats(), all.data() + lane_); }

  HWY_INLINE VF along_ray(const Field& field) const {
    return hn::Add(
        hn::Add(hn::Mul(field.gradient_x, lanes(rays_.step[0])), hn::Mul(field.gradient_y, lanes(rays_.step[1]))),
        hn::Mul(field.gradient_z, lanes(rays_.step[2])));
  }

  HWY_INLINE VF place(VF z, std::size_t axis) const {
    return hn::Add(set(eye_.start[axis]), hn::Mul(z, lanes(rays_.step[axis])));
  }

  /// Free space may end at the wall of a block that was not looked at, since all of it is free: whoever met matter
  /// first looks back by one voxel.
  HWY_INLINE void look_back(VF matter_z, VF voxel_z, MF has_matter, VF& outside_z, VF& outside) {
    const Floats f;
    const MF looks = hn::AndNot(hn::Gt(outside_z, hn::Zero(f)), has_matter);
    if (hn::AllFalse(f, looks)) return;
    const VF z = hn::Sub(matter_z, voxel_z);
    const auto nearest = [&](std::size_t axis) {
      const VF p = hn::IfThenElseZero(looks, hn::Add(place(z, axis), set(0.5f)));
      return hn::ConvertTo(Ints(), hn::Floor(p));
    };
    const VI at = places_of<Distances>(samples_, Along::axis<0>(nearest(0)), Along::axis<1>(nearest(1)),
                                       Along::axis<2>(nearest(2)), looks);
    const VF value = hn::GatherIndex(f, samples_.distances().samples(), at);
    const MF is_free = hn::And(looks, hn::Gt(value, hn::Zero(f)));
    outside_z = hn::IfThenElse(is_free, z, outside_z);
    outside = hn::IfThenElse(is_free, value, outside);
  }

  /// The cells round the places where depth is z; those of pixels that are not `wanted` mean nothing.
  HWY_INLINE Cells cells_at(VF z, MF wanted) const {
    const Ints i;
    const auto low = [&](VF p) { return hn::Floor(hn::IfThenElseZero(wanted, p)); };
    const auto both = [&](auto axis, VF lowest) {
      constexpr int kAxis = decltype(axis)::value;
      const VI at = hn::ConvertTo(i, lowest);
      return std::array{Along::axis<kAxis>(at), Along::axis<kAxis>(hn::Add(at, hn::Set(i, 1)))};
    };
    const VF x = place(z, 0), y = place(z, 1), z3 = place(z, 2);
    return {both(std::integral_constant<int, 0>(), low(x)),
            both(std::integral_constant<int, 1>(), low(y)),
            both(std::integral_constant<int, 2>(), low(z3)),
            hn::Sub(x, low(x)),
            hn::Sub(y, low(y)),
            hn::Sub(z3, low(z3))};
  }

  /// Trilinear. A pixel whose cell is not known all round is no longer `wanted`.
  HWY_INLINE Field field_at(VF z, MF& wanted) {
    const Floats f;
    const Cells cells = cells_at(z, wanted);
    MF is_known = wanted;
    const auto corner = [&](std::size_t x, std::size_t y, std::size_t z_side) {
      const VI at = places_of<Distances>(samples_, cells.x[x], cells.y[y], cells.z[z_side], wanted);
      const VF value = hn::GatherIndex(f, samples_.distances().samples(), at);
      is_known = hn::And(is_known, hn::Eq(value, value));
      return value;
    };
    const VF c0 = corner(0, 0, 0), c1 = corner(1, 0, 0), c2 = corner(0, 1, 0), c3 = corner(1, 1, 0);
    const VF c4 = corner(0, 0, 1), c5 = corner(1, 0, 1), c6 = corner(0, 1, 1), c7 = corner(1, 1, 1);
    wanted = is_known;
    const VF dx00 = hn::Sub(c1, c0), dx10 = hn::Sub(c3, c2), dx01 = hn::Sub(c5, c4), dx11 = hn::Sub(c7, c6);
    const VF x00 = hn::Add(c0, hn::Mul(dx00, cells.in_x)), x10 = hn::Add(c2, hn::Mul(dx10, cells.in_x));
    const VF x01 = hn::Add(c4, hn::Mul(dx01, cells.in_x)), x11 = hn::Add(c6, hn::Mul(dx11, cells.in_x));
    const VF y0 = mix(x00, x10, cells.in_y), y1 = mix(x01, x11, cells.in_y);
    return {mix(y0, y1, cells.in_z), mix(mix(dx00, dx10, cells.in_y), mix(dx01, dx11, cells.in_y), cells.in_z),
            mix(hn::Sub(x10, x00), hn::Sub(x11, x01), cells.in_z), hn::Sub(y1, y0)};
  }

  /// Trilinear over the voxels that have a colour.
  HWY_INLINE VF intensity_at(VF z, MF wanted) {
    const Floats f;
    const Codes c;
    const Cells cells = cells_at(z, wanted);
    const VF one = set(1);
    const VF rest_x = hn::Sub(one, cells.in_x), rest_y = hn::Sub(one, cells.in_y), rest_z = hn::Sub(one, cells.in_z);
    VF sum = hn::Zero(f);
    VF weights = hn::Zero(f);
    for (std::size_t n = 0; n < 8; ++n) {
      const VI at = places_of<Colours>(samples_, cells.x[n & 1], cells.y[n >> 1 & 1], cells.z[n >> 2], wanted);
      const auto code = hn::GatherIndex(c, samples_.colours().samples(), at);
      const auto has_colour = hn::RebindMask(f, hn::Ne(hn::ShiftRight<24>(code), hn::Zero(c)));
      const VF share = hn::Mul(hn::Mul((n & 1) != 0 ? cells.in_x : rest_x, (n & 2) != 0 ? cells.in_y : rest_y),
                               (n & 4) != 0 ? cells.in_z : rest_z);
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
  const RayPatch& rays_;
  std::size_t lane_;
  TileSamples& samples_;
};

void find_surfaces(const Eye& eye, const Eigen::Matrix3f& R_camera_world, const RayPatch& rays, TileSamples& samples,
                   SeenPatch& seen) {
  for (std::size_t lane = 0; lane < kPatchRays; lane += hn::Lanes(Floats())) {
    Finder(eye, rays, lane, samples).find(R_camera_world, seen);
  }
}

}  // namespace scanknit::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace scanknit {

HWY_EXPORT(find_surfaces);

void find_surfaces(const Eye& eye, const Eigen::Matrix3f& R_camera_world, const RayPatch& rays, TileSamples& samples,
                   SeenPatch& seen) {
  HWY_DYNAMIC_DISPATCH(find_surfaces)(eye, R_camera_world, rays, samples, seen);
}

}  // namespace scanknit
#endif
