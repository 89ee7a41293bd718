// Compiled once for each instruction set by Highway, which includes this file again through foreach_target.h.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fusion/update_block.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <tuple>
#include <type_traits>

#include "fusion/update_block.h"

HWY_BEFORE_NAMESPACE();
namespace scanknit::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Floats = hn::CappedTag<float, kBlockSide>;
using Ints = hn::RebindToSigned<Floats>;
using VF = hn::Vec<Floats>;

using Codes16 = hn::Rebind<WeightCode, Floats>;
using Codes32 = hn::RebindToUnsigned<Floats>;
using VI = hn::Vec<Ints>;
using MF = hn::Mask<Floats>;

HWY_INLINE VF set(float value) {
  return hn::Set(Floats(), value);
}

// Loaded: hn::Iota is a loop of stores on some targets.
alignas(32) constexpr std::array<float, kBlockSide> kLanes{0, 1, 2, 3, 4, 5, 6, 7};
alignas(32) constexpr std::array<std::uint32_t, kBlockSide> kLaneNumbers{0, 1, 2, 3, 4, 5, 6, 7};

HWY_INLINE std::uint64_t bits(MF mask) {
  alignas(8) std::array<std::uint8_t, 8> bytes{};
  hn::StoreMaskBits(Floats(), mask, bytes.data());
  return bytes[0];
}

/// Voxels in camera coordinates.
struct Points {
  VF x, y, z;
};

/// A frame's colours.
class ColourUpdate {
 public:
  explicit ColourUpdate(const ColourView& view) : view_(view) {}

  /// `goodness`: (cos(incidence) / z)^2 against the best that can be. `noise`: any number, another for every voxel.
  HWY_INLINE void apply(const Points& p, MF takes, VF goodness, std::uint32_t noise, ColourCode* codes) const {
    const Floats f;
    const Ints i;
    const Codes32 c;
    const auto& [R, t] = std::tie(view_.R, view_.t);
    const auto turned = [&](std::size_t row) {
      return hn::Add(hn::Add(hn::Add(hn::Mul(set(R[3 * row]), p.x), hn::Mul(set(R[3 * row + 1]), p.y)),
                             hn::Mul(set(R[3 * row + 2]), p.z)),
                     set(t[row]));
    };
    const auto z = turned(2);
    const auto per_z = hn::Div(set(1), z);
    const auto u = hn::Add(hn::Mul(hn::Mul(set(view_.fx), turned(0)), per_z), set(view_.cx));
    const auto v = hn::Add(hn::Mul(hn::Mul(set(view_.fy), turned(1)), per_z), set(view_.cy));
    const auto inside = [&](VF at, int size) {
      return hn::And(hn::Ge(at, hn::Zero(f)), hn::Lt(at, set(static_cast<float>(size - 1))));
    };
    const auto seen =
        hn::And(hn::And(takes, hn::Gt(z, hn::Zero(f))), hn::And(inside(u, view_.width), inside(v, view_.height)));
    if (hn::AllFalse(f, seen)) return;

    const auto pixel_x = hn::ConvertTo(i, hn::IfThenElseZero(seen, u));
    const auto pixel_y = hn::ConvertTo(i, hn::IfThenElseZero(seen, v));
    const auto share_x = hn::Sub(u, hn::ConvertTo(f, pixel_x));
    const auto share_y = hn::Sub(v, hn::ConvertTo(f, pixel_y));
    const auto pixel = hn::Add(hn::Mul(pixel_y, hn::Set(i, view_.width)), pixel_x);
    const auto* const pixels = reinterpret_cast<const std::int32_t*>(view_.pixels);
    const auto p00 = hn::GatherIndex(i, pixels, pixel);
    const auto p10 = hn::GatherIndex(i, pixels + 1, pixel);
    const auto p01 = hn::GatherIndex(i, pixels + view_.width, pixel);
    const auto p11 = hn::GatherIndex(i, pixels + view_.width + 1, pixel);

    const auto old = hn::LoadU(c, codes);
    const auto byte = hn::Set(c, 0xFF);
    const auto best = hn::Mul(hn::ConvertTo(f, hn::BitCast(i, hn::ShiftRight<24>(old))), set(1.0f / 255));
    const auto good = hn::Mul(goodness, goodness);
    const auto best_squared = hn::Mul(best, best);
    const auto others = hn::Mul(set(kColourViews - 1), hn::Mul(best_squared, best_squared));
    const auto share = hn::Div(good, hn::Add(good, others));
    const auto dither = dither_of(noise);
    const auto mixed = [&](auto shift) {
      constexpr int kShift = decltype(shift)::value;
      const auto channel = [&](auto code) {
        return hn::ConvertTo(f, hn::And(hn::ShiftRight<kShift>(code), hn::Set(i, 0xFF)));
      };
      const auto mix = [&](VF a, VF b, VF part) { return hn::Add(a, hn::Mul(hn::Sub(b, a), part)); };
      const auto now = mix(mix(channel(p00), channel(p10), share_x), mix(channel(p01), channel(p11), share_x), share_y);
      const auto mean = mix(channel(hn::BitCast(i, old)), now, share);
      const auto rounded = hn::ConvertTo(i, hn::Min(hn::Add(mean, dither), set(255)));
      return hn::ShiftLeft<kShift>(hn::And(hn::BitCast(c, rounded), byte));
    };
    const auto quality = hn::Min(hn::Max(best, hn::Sqrt(goodness)), set(1));
    const auto quality_code = hn::ConvertTo(i, hn::Max(hn::Add(hn::Mul(quality, set(255)), set(0.5f)), set(1)));
    const auto colour = hn::Or(hn::Or(mixed(Shift<0>()), mixed(Shift<8>())),
                               hn::Or(mixed(Shift<16>()), hn::ShiftLeft<24>(hn::BitCast(c, quality_code))));
    hn::StoreU(hn::IfThenElse(hn::RebindMask(c, seen), colour, old), c, codes);
  }

 private:
  template <int kBits>
  using Shift = std::integral_constant<int, kBits>;

  /// From 0 to below 1, as if at random.
  HWY_INLINE VF dither_of(std::uint32_t noise) const {
    const Codes32 c;
    const auto number = hn::Add(hn::Load(c, kLaneNumbers.data()), hn::Set(c, noise + view_.seed));
    const auto mixed = hn::Mul(
        hn::Xor(hn::Mul(number, hn::Set(c, 0x9E3779B1u)), hn::ShiftRight<15>(hn::Mul(number, hn::Set(c, 0x85EBCA77u)))),
        hn::Set(c, 0xC2B2AE3Du));
    return hn::Mul(hn::ConvertTo(Floats(), hn::BitCast(Ints(), hn::ShiftRight<9>(mixed))), set(0x1p-23f));
  }

  const ColourView& view_;
};

/// A row of voxels along z, or a part of one, against the planes of the pixels they project to.
class RowUpdate {
 public:
  explicit RowUpdate(const FrameView& frame) : frame_(frame), colours_(frame.colour) {}

  struct Done {
    std::uint64_t observed = 0;  ///< the voxels that the frame says something of
    std::uint64_t free = 0;      ///< those of them that are in free space by now
    bool has_matter = false;     ///< some of them are behind a surface by now
  };

  HWY_INLINE Done apply(const Points& p, std::uint32_t noise, float* tsdf, WeightCode* weights,
                        ColourCode* colours) const {
    const Floats f;
    const Ints i;
    const auto zero = hn::Zero(f);
    const auto half = set(0.5f);
    const auto one = set(1);
    const auto& [x, y, z] = p;

    const auto per_z = hn::Div(one, z);
    const auto u = hn::Add(hn::Add(hn::Mul(hn::Mul(set(frame_.fx), x), per_z), set(frame_.cx)), half);
    const auto v = hn::Add(hn::Add(hn::Mul(hn::Mul(set(frame_.fy), y), per_z), set(frame_.cy)), half);
    const auto in_u = hn::And(hn::Ge(u, zero), hn::Lt(u, set(static_cast<float>(frame_.width))));
    const auto in_v = hn::And(hn::Ge(v, zero), hn::Lt(v, set(static_cast<float>(frame_.height))));
    const auto in_picture = hn::And(hn::And(in_u, in_v), hn::Gt(z, zero));
    if (hn::AllFalse(f, in_picture)) return {};

    const auto pixel_x = hn::ConvertTo(i, hn::IfThenElseZero(in_picture, u));
    const auto pixel_y = hn::ConvertTo(i, hn::IfThenElseZero(in_picture, v));
    const auto pixel = hn::Add(hn::Mul(pixel_y, hn::Set(i, frame_.width)), pixel_x);
    const auto seen_z = hn::GatherIndex(f, frame_.z_m, pixel);

    const auto beyond = hn::Sub(seen_z, set(frame_.noise_from));
    const auto sigma = hn::Add(set(frame_.noise_floor), hn::Mul(set(frame_.noise_growth), hn::Mul(beyond, beyond)));
    const auto truncation = hn::Max(set(frame_.band_m), hn::Mul(set(frame_.band_sigmas), sigma));
    const auto is_seen = hn::And(hn::And(in_picture, hn::Gt(seen_z, zero)), hn::Le(hn::Sub(z, seen_z), truncation));
    if (hn::AllFalse(f, is_seen)) return {};

    // The plane: its normal, and the point on the pixel's own ray.
    const auto packed = hn::GatherIndex(i, reinterpret_cast<const std::int32_t*>(frame_.normals), pixel);
    const auto unit = set(kNormalUnit);
    const auto nx = hn::Mul(hn::ConvertTo(f, hn::ShiftRight<16>(hn::ShiftLeft<16>(packed))), unit);
    const auto ny = hn::Mul(hn::ConvertTo(f, hn::ShiftRight<16>(packed)), unit);
    const auto nz_squared = hn::Sub(hn::Sub(one, hn::Mul(nx, nx)), hn::Mul(ny, ny));
    const auto sign = hn::And(hn::ShiftLeft<15>(packed), hn::Set(i, static_cast<std::int32_t>(0x80000000u)));
    const auto nz = hn::Xor(hn::Neg(hn::Sqrt(hn::Max(zero, nz_squared))), hn::BitCast(f, sign));
    const auto ray_x = hn::Mul(hn::Sub(hn::ConvertTo(f, pixel_x), set(frame_.cx)), set(frame_.per_fx));
    const auto ray_y = hn::Mul(hn::Sub(hn::ConvertTo(f, pixel_y), set(frame_.cy)), set(frame_.per_fy));
    const auto dot = [&](VF a, VF b, VF c) { return hn::Add(hn::Add(hn::Mul(nx, a), hn::Mul(ny, b)), hn::Mul(nz, c)); };
    const auto distance =
        dot(hn::Sub(x, hn::Mul(ray_x, seen_z)), hn::Sub(y, hn::Mul(ray_y, seen_z)), hn::Sub(z, seen_z));

    // weight = cos(incidence) best_variance / sigma^2 * max(((truncation - |distance|) / truncation)^3, share of free
    // space), as one fraction. Behind the band there is no such share.
    const auto slope = hn::Max(hn::Neg(dot(ray_x, ray_y, one)), zero);
    const auto ray_squared = hn::Add(hn::Add(hn::Mul(ray_x, ray_x), hn::Mul(ray_y, ray_y)), one);
    const auto cube = [](VF a) { return hn::Mul(hn::Mul(a, a), a); };
    const auto truncation_cubed = cube(truncation);
    const auto nearness = cube(hn::Max(zero, hn::Sub(truncation, hn::Abs(distance))));
    const auto in_front = hn::Max(nearness, hn::Mul(truncation_cubed, set(kFreeSpaceShare)));
    const auto share = hn::IfThenElse(hn::Ge(distance, zero), in_front, nearness);
    const auto above = hn::IfThenElseZero(is_seen, hn::Mul(hn::Mul(slope, set(frame_.best_variance)), share));
    const auto below = hn::Mul(hn::Mul(hn::Mul(sigma, sigma), hn::Sqrt(ray_squared)), truncation_cubed);
    const auto weight_now = hn::Div(above, below);
    const auto observed = hn::Gt(weight_now, zero);
    const std::uint64_t observed_bits = bits(observed);
    if (observed_bits == 0) return {};

    const auto old_weight = decoded(weights);
    const auto mean = hn::LoadU(f, tsdf);
    const auto sum = hn::Add(old_weight, weight_now);
    const auto step = hn::Mul(hn::Sub(hn::Min(distance, truncation), mean), hn::Div(weight_now, sum));
    const auto moved = hn::IfThenElse(observed, hn::Add(mean, step), mean);
    hn::StoreU(moved, f, tsdf);
    store_encoded(hn::IfThenElse(observed, hn::Min(sum, set(frame_.max_weight)), old_weight), weights);

    if (frame_.colour.pixels != nullptr) {
      const auto takes = hn::And(observed, hn::Lt(hn::Abs(distance), hn::Mul(set(kInnerBand), truncation)));
      if (!hn::AllFalse(f, takes)) {
        const auto per_range = hn::Mul(per_z, set(kBestColourRange));
        const auto cosine_squared = hn::Div(hn::Mul(slope, slope), ray_squared);
        const auto goodness = hn::Min(hn::Mul(cosine_squared, hn::Mul(per_range, per_range)), one);
        colours_.apply(p, takes, goodness, noise, colours);
      }
    }
    return {observed_bits, bits(hn::And(observed, hn::Ge(moved, set(frame_.band_m)))),
            !hn::AllFalse(f, hn::And(observed, hn::Lt(moved, zero)))};
  }

 private:
  static HWY_INLINE VF decoded(const WeightCode* codes) {
    const auto code = hn::PromoteTo(Ints(), hn::LoadU(Codes16(), codes));
    const auto root = hn::Mul(hn::ConvertTo(Floats(), code), set(kWeightCodeUnit));
    return hn::Mul(root, root);
  }

  /// As encode_weight.
  static HWY_INLINE void store_encoded(VF weight, WeightCode* codes) {
    const auto code = hn::Mul(hn::Sqrt(weight), set(1 / kWeightCodeUnit));
    const auto least = hn::IfThenElseZero(hn::Gt(weight, hn::Zero(Floats())), set(1));
    const auto rounded = hn::NearestInt(hn::Min(hn::Max(code, least), set(65535)));
    hn::StoreU(hn::DemoteTo(Codes16(), rounded), Codes16(), codes);
  }

  const FrameView& frame_;
  ColourUpdate colours_;
};

void update_block(const FrameView& frame, const BlockPlace& place, const BlockVoxels& voxels, BlockChange& change) {
  const Floats f;
  const RowUpdate update(frame);
  const auto& [along_x, along_y, along_z] = place.step;
  const auto row = [&](std::size_t axis, int x, int y, std::size_t first_z) {
    const float start =
        place.first[axis] + static_cast<float>(x) * along_x[axis] + static_cast<float>(y) * along_y[axis];
    return hn::Add(set(start), hn::Mul(hn::LoadU(f, kLanes.data() + first_z), set(along_z[axis])));
  };
  std::uint64_t free = ~std::uint64_t{0};
  change.has_matter = false;
  for (int x = 0; x < kBlockSide; ++x) {
    std::uint64_t observed = 0;
    std::uint64_t free_here = 0;
    for (int y = 0; y < kBlockSide; ++y) {
      for (std::size_t z = 0; z < kBlockSide; z += hn::Lanes(f)) {
        const std::size_t bit = static_cast<std::size_t>(kBlockSide * y) + z;
        const std::size_t voxel = static_cast<std::size_t>(kBlockSide * kBlockSide * x) + bit;
        const auto done =
            update.apply({row(0, x, y, z), row(1, x, y, z), row(2, x, y, z)}, static_cast<std::uint32_t>(voxel),
                         voxels.tsdf + voxel, voxels.weight + voxel, voxels.colour + voxel);
        observed |= done.observed << bit;
        free_here |= done.free << bit;
        change.has_matter = change.has_matter || done.has_matter;
      }
    }
    change.observed[static_cast<std::size_t>(x)] = observed;
    free &= free_here;
  }
  change.is_free = free == ~std::uint64_t{0};
}

}  // namespace scanknit::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace scanknit {

HWY_EXPORT(update_block);

void update_block(const FrameView& frame, const BlockPlace& place, const BlockVoxels& voxels, BlockChange& change) {
  HWY_DYNAMIC_DISPATCH(update_block)(frame, place, voxels, change);
}

FrameView::FrameView(const SurfaceImage& surface, const CameraIntrinsics& camera, const FusionConfig& config)
    : z_m(surface.z_m.pixels().data()),
      normals(surface.normals.pixels().data()),
      width(camera.width),
      height(camera.height),
      fx(static_cast<float>(camera.fx)),
      fy(static_cast<float>(camera.fy)),
      cx(static_cast<float>(camera.cx)),
      cy(static_cast<float>(camera.cy)),
      per_fx(static_cast<float>(1 / camera.fx)),
      per_fy(static_cast<float>(1 / camera.fy)),
      band_m(static_cast<float>(config.truncation_voxels * config.voxel_size_m)),
      band_sigmas(static_cast<float>(config.truncation_sigmas)),
      noise_floor(static_cast<float>(config.noise.floor_m)),
      noise_growth(static_cast<float>(config.noise.growth_per_m)),
      noise_from(static_cast<float>(config.noise.from_m)),
      best_variance(
          static_cast<float>(config.noise.sigma_m(config.noise.from_m) * config.noise.sigma_m(config.noise.from_m))),
      max_weight(std::min(static_cast<float>(config.max_weight), kMaxCodedWeight)) {}

}  // namespace scanknit
#endif
