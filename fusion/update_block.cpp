// Compiled once for each instruction set by Highway, which includes this file again through foreach_target.h.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fusion/update_block.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "fusion/update_block.h"

HWY_BEFORE_NAMESPACE();
namespace scanknit::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Floats = hn::CappedTag<float, kBlockSide>;
using Ints = hn::RebindToSigned<Floats>;
using VF = hn::Vec<Floats>;

/// A row of voxels along z, or a part of one, against the planes of the pixels they project to.
class RowUpdate {
 public:
  explicit RowUpdate(const FrameView& frame) : frame_(frame) {}

  /// Returns the bits of the voxels that the frame says something of; `colour` gets those of the inner band.
  HWY_INLINE std::uint64_t apply(VF x, VF y, VF z, float* tsdf, float* weight, float* added,
                                 std::uint64_t& colour) const {
    const Floats f;
    const Ints i;
    const auto set = [&](float value) { return hn::Set(f, value); };
    const auto zero = hn::Zero(f);
    const auto half = set(0.5f);
    const auto one = set(1);

    const auto per_z = hn::Div(one, z);
    const auto u = hn::Add(hn::Add(hn::Mul(hn::Mul(set(frame_.fx), x), per_z), set(frame_.cx)), half);
    const auto v = hn::Add(hn::Add(hn::Mul(hn::Mul(set(frame_.fy), y), per_z), set(frame_.cy)), half);
    const auto in_u = hn::And(hn::Ge(u, zero), hn::Lt(u, set(static_cast<float>(frame_.width))));
    const auto in_v = hn::And(hn::Ge(v, zero), hn::Lt(v, set(static_cast<float>(frame_.height))));
    const auto in_picture = hn::And(hn::And(in_u, in_v), hn::Gt(z, zero));
    if (hn::AllFalse(f, in_picture)) return 0;

    const auto pixel_x = hn::ConvertTo(i, hn::IfThenElseZero(in_picture, u));
    const auto pixel_y = hn::ConvertTo(i, hn::IfThenElseZero(in_picture, v));
    const auto pixel = hn::Add(hn::Mul(pixel_y, hn::Set(i, frame_.width)), pixel_x);
    const auto seen_z = hn::GatherIndex(f, frame_.z_m, pixel);

    const auto beyond = hn::Sub(seen_z, set(frame_.noise_from));
    const auto sigma = hn::Add(set(frame_.noise_floor), hn::Mul(set(frame_.noise_growth), hn::Mul(beyond, beyond)));
    const auto truncation = hn::Max(set(frame_.band_m), hn::Mul(set(frame_.band_sigmas), sigma));
    const auto is_seen = hn::And(hn::And(in_picture, hn::Gt(seen_z, zero)), hn::Le(hn::Sub(z, seen_z), truncation));
    if (hn::AllFalse(f, is_seen)) return 0;

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

    const auto ray_length = hn::Sqrt(hn::Add(hn::Add(hn::Mul(ray_x, ray_x), hn::Mul(ray_y, ray_y)), one));
    const auto cosine = hn::Min(hn::Max(hn::Neg(hn::Div(dot(ray_x, ray_y, one), ray_length)), zero), one);
    const auto certainty = hn::Div(set(frame_.best_variance), hn::Mul(sigma, sigma));
    const auto nearness = hn::Max(zero, hn::Sub(one, hn::Div(hn::Abs(distance), truncation)));
    const auto cube = hn::Mul(hn::Mul(nearness, nearness), nearness);
    const auto share = hn::IfThenElse(hn::Ge(distance, zero), hn::Max(cube, set(kFreeSpaceShare)), cube);
    const auto weight_now = hn::IfThenElseZero(is_seen, hn::Mul(hn::Mul(cosine, certainty), share));
    const auto observed = hn::Gt(weight_now, zero);

    const auto mean = hn::LoadU(f, tsdf);
    const auto sum = hn::Add(hn::LoadU(f, weight), weight_now);
    const auto part = hn::IfThenElseZero(observed, hn::Div(weight_now, sum));
    const auto step = hn::Mul(hn::Sub(hn::Min(distance, truncation), mean), part);
    hn::StoreU(hn::IfThenElse(observed, hn::Add(mean, step), mean), f, tsdf);
    hn::StoreU(hn::Min(sum, set(frame_.max_weight)), f, weight);
    hn::StoreU(weight_now, f, added);
    colour = bits(hn::And(observed, hn::Lt(hn::Abs(distance), hn::Mul(set(kInnerBand), truncation))));
    return bits(observed);
  }

 private:
  static HWY_INLINE std::uint64_t bits(hn::Mask<Floats> mask) {
    alignas(8) std::array<std::uint8_t, 8> bytes{};
    hn::StoreMaskBits(Floats(), mask, bytes.data());
    return bytes[0];
  }

  const FrameView& frame_;
};

void update_block(const FrameView& frame, const BlockPlace& place, const BlockVoxels& voxels, BlockChange& change) {
  const Floats f;
  const RowUpdate update(frame);
  const auto& [along_x, along_y, along_z] = place.step;
  const auto row = [&](std::size_t axis, int x, int y, std::size_t first_z) {
    const float start =
        place.first[axis] + static_cast<float>(x) * along_x[axis] + static_cast<float>(y) * along_y[axis];
    return hn::Add(hn::Set(f, start), hn::Mul(hn::Iota(f, static_cast<float>(first_z)), hn::Set(f, along_z[axis])));
  };
  for (int x = 0; x < kBlockSide; ++x) {
    std::uint64_t observed = 0;
    std::uint64_t takes_colour = 0;
    for (int y = 0; y < kBlockSide; ++y) {
      for (std::size_t z = 0; z < kBlockSide; z += hn::Lanes(f)) {
        const std::size_t bit = static_cast<std::size_t>(kBlockSide * y) + z;
        const std::size_t voxel = static_cast<std::size_t>(kBlockSide * kBlockSide * x) + bit;
        std::uint64_t colour = 0;
        observed |= update.apply(row(0, x, y, z), row(1, x, y, z), row(2, x, y, z), voxels.tsdf + voxel,
                                 voxels.weight + voxel, change.added.data() + voxel, colour)
                    << bit;
        takes_colour |= colour << bit;
      }
    }
    change.observed[static_cast<std::size_t>(x)] = observed;
    change.takes_colour[static_cast<std::size_t>(x)] = takes_colour;
  }
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
      max_weight(static_cast<float>(config.max_weight)) {}

}  // namespace scanknit
#endif
