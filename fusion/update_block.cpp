// Compiled once for each instruction set by Highway, which includes this file again through foreach_target.h.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fusion/update_block.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <algorithm>
#include <type_traits>

#include "fusion/update_block.h"

HWY_BEFORE_NAMESPACE();
namespace scanknit::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Floats = hn::CappedTag<float, 2 * kBlockSide>;
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
alignas(64) constexpr std::array<std::uint32_t, 2 * kBlockSide> kLaneNumbers{0, 1, 2,  3,  4,  5,  6,  7,
                                                                             8, 9, 10, 11, 12, 13, 14, 15};

HWY_INLINE std::uint64_t bits(MF mask) {
  alignas(8) std::array<std::uint8_t, 8> bytes{};
  hn::StoreMaskBits(Floats(), mask, bytes.data());
  return static_cast<std::uint64_t>(bytes[0]) | static_cast<std::uint64_t>(bytes[1]) << 8;
}

#if HWY_TARGET != HWY_SCALAR
/// part(from), part(from + 1) ... kParts of them in one vector, the first in its lowest lanes.
template <std::size_t kParts, typename Part>
HWY_INLINE auto joined(const Part& part, std::size_t from = 0) {
  if constexpr (kParts == 1) {
    return part(from);
  } else {
    const auto low = joined<kParts / 2>(part, from);
    const auto high = joined<kParts / 2>(part, from + kParts / 2);
    return hn::Combine(hn::Twice<hn::DFromV<decltype(low)>>(), high, low);
  }
}
#endif

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
    const auto& R = view_.R;
    const auto& t = view_.t;
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
    hn::Vec<Codes32> p00, p10, p01, p11;
    pairs_at(pixel, view_.pixels, p00, p10);
    pairs_at(pixel, view_.pixels + view_.width, p01, p11);

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
        return hn::ConvertTo(f, hn::BitCast(i, hn::And(hn::ShiftRight<kShift>(code), byte)));
      };
      const auto mix = [&](VF a, VF b, VF part) { return hn::Add(a, hn::Mul(hn::Sub(b, a), part)); };
      const auto now = mix(mix(channel(p00), channel(p10), share_x), mix(channel(p01), channel(p11), share_x), share_y);
      const auto mean = mix(channel(old), now, share);
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

  /// Each pixel and the one to its right: two gathers take three times as long.
  static HWY_INLINE void pairs_at(VI pixel, const ColourCode* pixels, hn::Vec<Codes32>& left, hn::Vec<Codes32>& right) {
    constexpr std::size_t kLanes = hn::MaxLanes(Codes32());
    alignas(64) std::array<std::int32_t, kLanes> numbers;
    hn::Store(pixel, Ints(), numbers.data());
#if HWY_TARGET == HWY_SCALAR
    left = hn::LoadU(Codes32(), pixels + numbers[0]);
    right = hn::LoadU(Codes32(), pixels + numbers[0] + 1);
#else
    const auto pair = [&](std::size_t lane) {
      return hn::LoadU(hn::CappedTag<ColourCode, 2>(), pixels + numbers[lane]);
    };
    const auto low = joined<kLanes / 2>(pair);
    const auto high = joined<kLanes / 2>(pair, kLanes / 2);
    left = hn::ConcatEven(Codes32(), high, low);
    right = hn::ConcatOdd(Codes32(), high, low);
#endif
  }

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

/// The voxels of one block, in vectors along z (of two rows where they are that long). Step by step for all vectors,
/// since each step waits long for its own results and the processor fills the time with the vectors that come next;
/// those that a step finds to be of no further interest are left out of the next.
class VoxelUpdate {
 public:
  HWY_INLINE VoxelUpdate(const FrameView& frame, const BlockPlace& place, const BlockVoxels& voxels)
      : frame_(frame), place_(place), voxels_(voxels), colours_(frame.colour) {}

  HWY_INLINE void apply(BlockChange& change) {
    change = {};
    project();
    measure(change);
    move(change);
    if (frame_.colour.pixels != nullptr) paint();
  }

 private:
  using Numbers = std::array<float, kBlockVoxels>;

  /// Where vectors begin.
  class Vectors {
   public:
    HWY_INLINE void add_if(bool is_wanted, std::size_t first) {
      first_[count_] = static_cast<std::uint16_t>(first);
      count_ += is_wanted ? 1 : 0;
    }
    [[nodiscard]] const std::uint16_t* begin() const { return first_.data(); }
    [[nodiscard]] const std::uint16_t* end() const { return first_.data() + count_; }

   private:
    std::array<std::uint16_t, kBlockVoxels + 1> first_;
    std::size_t count_ = 0;
  };

  /// To homogeneous pixel coordinates and pixels.
  HWY_INLINE void project() {
    const Floats f;
    const Ints i;
    const auto least = set(-0.5f);
    for (std::size_t at = 0; at < kBlockVoxels; at += hn::Lanes(f)) {
      const auto along = [&](std::size_t axis) {
        const VoxelSteps& steps = frame_.steps[axis];
        const float start = place_.first[axis] + steps.slab[at / kSlabVoxels];
        return hn::Add(set(start), hn::LoadU(f, steps.in_slab.data() + at % kSlabVoxels));
      };
      const VF z = along(2);
      if (hn::AllFalse(f, hn::Le(z, set(place_.far_m)))) continue;
      const VF zu = along(0), zv = along(1);
      const auto per_z = hn::Div(set(1), z);
      const auto u = hn::Mul(zu, per_z);
      const auto v = hn::Mul(zv, per_z);
      const auto in_u = hn::And(hn::Ge(u, least), hn::Lt(u, set(static_cast<float>(frame_.width) - 0.5f)));
      const auto in_v = hn::And(hn::Ge(v, least), hn::Lt(v, set(static_cast<float>(frame_.height) - 0.5f)));
      const auto is_in = hn::And(hn::And(in_u, in_v), hn::Gt(z, hn::Zero(f)));
      const auto number = hn::Add(hn::Mul(rounded(v), hn::Set(i, frame_.width)), rounded(u));
      hn::StoreU(hn::IfThenElseZero(hn::RebindMask(i, is_in), number), i, pixel_.data() + at);
      hn::StoreU(zu, f, zu_.data() + at);
      hn::StoreU(zv, f, zv_.data() + at);
      hn::StoreU(z, f, z_.data() + at);
      hn::StoreU(hn::IfThenElseZero(is_in, per_z), f, per_z_.data() + at);
      in_picture_.add_if(!hn::AllFalse(f, is_in), at);
    }
  }

  /// To the nearest, for numbers from -0.5 to below 2^22: floats from 2^23 to 2^24 are integers.
  static HWY_INLINE VI rounded(VF number) {
    return hn::And(hn::BitCast(Ints(), hn::Add(number, set(0x1.8p23f))), hn::Set(Ints(), 0x3FFFFF));
  }

  /// Distances to the pixels' planes, and what they weigh: as much as the pixel, times the larger of
  /// (1 - |distance| / truncation)^3 and the share of free space; behind the plane there is no such share.
  HWY_INLINE void measure(BlockChange& change) {
    const Floats f;
    const auto zero = hn::Zero(f);
    const auto one = set(1);
    for (const std::size_t at : in_picture_) {
      const VF z = load(z_, at);
      const auto is_in = hn::Gt(load(per_z_, at), zero);
      VF per_zu, per_zv, per_z, offset, far, truncation, per_truncation, pixel_weight;
      four_numbers<0>(at, per_zu, per_zv, per_z, offset);
      four_numbers<4>(at, far, truncation, per_truncation, pixel_weight);
      const auto is_seen = hn::And(is_in, hn::Le(z, far));
      const auto along_normal =
          hn::Add(hn::Add(hn::Mul(per_zu, load(zu_, at)), hn::Mul(per_zv, load(zv_, at))), hn::Mul(per_z, z));
      const auto distance = hn::Sub(along_normal, offset);
      const auto inside = hn::Max(zero, hn::Sub(one, hn::Mul(hn::Abs(distance), per_truncation)));
      const auto nearness = hn::Mul(hn::Mul(inside, inside), inside);
      const auto share = hn::IfThenElse(hn::Ge(distance, zero), hn::Max(nearness, set(kFreeSpaceShare)), nearness);
      VF weight = hn::IfThenElseZero(is_seen, hn::Mul(pixel_weight, share));
      const auto is_before = hn::And(is_seen, hn::Ge(distance, truncation));
      if (frame_.clear_m != nullptr && !hn::AllFalse(f, is_before)) weight = carving(at, is_before, z, weight);
      const auto is_observed = hn::Gt(weight, zero);
      const auto is_inner = hn::And(is_observed, hn::Lt(hn::Abs(distance), hn::Mul(set(kInnerBand), truncation)));
      hn::StoreU(weight, f, weight_.data() + at);
      hn::StoreU(hn::Min(distance, truncation), f, distance_.data() + at);
      hn::StoreU(hn::IfThenElseZero(is_inner, along_normal), f, along_normal_.data() + at);
      const std::uint64_t observed = bits(is_observed);
      change.observed[at / kSlabVoxels] |= observed << at % kSlabVoxels;
      observed_.add_if(observed != 0, at);
      coloured_.add_if(!hn::AllFalse(f, is_inner), at);
    }
  }

  /// The weight of voxels before the band. What stood there was nearer than what is seen now, and weighs much more:
  /// where the space is certainly clear it counts as a view of a surface at the voxel would. Space that is free by now
  /// is left to the other views, so that it does not grow heavy: something may yet come to stand there.
  HWY_INLINE VF carving(std::size_t at, MF is_before, VF z, VF weight) const {
    const Floats f;
    const auto has_matter = hn::And(is_before, hn::Lt(hn::LoadU(f, voxels_.tsdf + at), hn::Zero(f)));
    if (hn::AllFalse(f, has_matter)) return weight;
    alignas(64) std::array<float, hn::MaxLanes(Floats())> clear;
    for (std::size_t lane = 0; lane < hn::Lanes(f); ++lane) clear[lane] = frame_.clear_m[pixel_[at + lane]];
    const auto is_clear = hn::And(has_matter, hn::Lt(z, hn::Load(f, clear.data())));
    const auto beyond = hn::Sub(z, set(frame_.noise.from_m));
    const auto sigma =
        hn::Add(set(frame_.noise.floor_m), hn::Mul(set(frame_.noise.growth_per_m), hn::Mul(beyond, beyond)));
    const auto here = hn::Div(set(kFreeSpaceShare * frame_.best_variance), hn::Mul(sigma, sigma));
    return hn::IfThenElse(is_clear, hn::Max(weight, here), weight);
  }

  /// The weighted running mean.
  HWY_INLINE void move(BlockChange& change) const {
    const Floats f;
    const auto zero = hn::Zero(f);
    std::array<std::uint64_t, kBlockSide> free{};
    for (const std::size_t at : observed_) {
      float* const tsdf = voxels_.tsdf + at;
      WeightCode* const weights = voxels_.weight + at;
      const VF weight = load(weight_, at);
      const auto is_observed = hn::Gt(weight, zero);
      const auto old_weight = decoded(weights);
      const auto mean = hn::LoadU(f, tsdf);
      const auto sum = hn::Add(old_weight, weight);
      const auto step = hn::Mul(hn::Sub(load(distance_, at), mean), hn::Div(weight, sum));
      const auto moved = hn::IfThenElse(is_observed, hn::Add(mean, step), mean);
      hn::StoreU(moved, f, tsdf);
      store_encoded(hn::IfThenElse(is_observed, hn::Min(sum, set(frame_.max_weight)), old_weight), weights);
      free[at / kSlabVoxels] |= bits(hn::And(is_observed, hn::Ge(moved, set(frame_.band_m)))) << at % kSlabVoxels;
      change.has_matter |= !hn::AllFalse(f, hn::And(is_observed, hn::Lt(moved, zero)));
    }
    change.is_free = std::all_of(free.begin(), free.end(), [](std::uint64_t slab) { return slab == ~std::uint64_t{0}; });
  }

  HWY_INLINE void paint() const {
    const Floats f;
    for (const std::size_t at : coloured_) {
      const VF z = load(z_, at);
      const VF x = hn::Mul(hn::Sub(load(zu_, at), hn::Mul(set(frame_.cx), z)), set(frame_.per_fx));
      const VF y = hn::Mul(hn::Sub(load(zv_, at), hn::Mul(set(frame_.cy), z)), set(frame_.per_fy));
      const VF along_normal = load(along_normal_, at);
      const auto takes = hn::Ne(along_normal, hn::Zero(f));
      const auto per_range = hn::Mul(load(per_z_, at), set(kBestColourRange));
      const auto squared = hn::Add(hn::Add(hn::Mul(x, x), hn::Mul(y, y)), hn::Mul(z, z));
      const auto cosine_squared = hn::Div(hn::Mul(along_normal, along_normal), squared);
      const auto goodness = hn::Min(hn::Mul(cosine_squared, hn::Mul(per_range, per_range)), set(1));
      colours_.apply({x, y, z}, takes, goodness, static_cast<std::uint32_t>(at), voxels_.colour + at);
    }
  }

  static HWY_INLINE VF load(const Numbers& numbers, std::size_t at) { return hn::LoadU(Floats(), numbers.data() + at); }

  /// Numbers kFirst to kFirst + 3 of the planes that a vector of voxels projects to. Loaded one by one and transposed:
  /// a gather for each number takes several times as long.
  template <std::size_t kFirst>
  HWY_INLINE void four_numbers(std::size_t at, VF& a, VF& b, VF& c, VF& d) const {
    const Floats f;
    const auto numbers_of = [&](std::size_t lane) { return frame_.planes[pixel_[at + lane]].numbers.data() + kFirst; };
#if HWY_TARGET == HWY_SCALAR
    const float* numbers = numbers_of(0);
    a = hn::LoadU(f, numbers);
    b = hn::LoadU(f, numbers + 1);
    c = hn::LoadU(f, numbers + 2);
    d = hn::LoadU(f, numbers + 3);
#else
    const hn::RepartitionToWide<Floats> wide;
    // Four numbers of each fourth pixel from n on.
    const auto quarter = [&](std::size_t n) {
      return joined<hn::MaxLanes(Floats()) / 4>([&](std::size_t k) {
        return hn::LoadU(hn::CappedTag<float, 4>(), numbers_of(n + 4 * k));
      });
    };
    const VF p0 = quarter(0), p1 = quarter(1), p2 = quarter(2), p3 = quarter(3);
    const auto ab01 = hn::BitCast(wide, hn::InterleaveLower(f, p0, p1));
    const auto ab23 = hn::BitCast(wide, hn::InterleaveLower(f, p2, p3));
    const auto cd01 = hn::BitCast(wide, hn::InterleaveUpper(f, p0, p1));
    const auto cd23 = hn::BitCast(wide, hn::InterleaveUpper(f, p2, p3));
    a = hn::BitCast(f, hn::InterleaveLower(wide, ab01, ab23));
    b = hn::BitCast(f, hn::InterleaveUpper(wide, ab01, ab23));
    c = hn::BitCast(f, hn::InterleaveLower(wide, cd01, cd23));
    d = hn::BitCast(f, hn::InterleaveUpper(wide, cd01, cd23));
#endif
  }

  static HWY_INLINE VF decoded(const WeightCode* codes) {
    const auto code = hn::PromoteTo(Ints(), hn::LoadU(Codes16(), codes));
    const auto root = hn::Mul(hn::ConvertTo(Floats(), code), set(kWeightCodeUnit));
    return hn::Mul(root, root);
  }

  /// As encode_weight.
  static HWY_INLINE void store_encoded(VF weight, WeightCode* codes) {
    const auto code = hn::Mul(hn::Sqrt(weight), set(1 / kWeightCodeUnit));
    const auto least = hn::IfThenElseZero(hn::Gt(weight, hn::Zero(Floats())), set(1));
    hn::StoreU(hn::DemoteTo(Codes16(), rounded(hn::Min(hn::Max(code, least), set(65535)))), Codes16(), codes);
  }

  const FrameView& frame_;
  const BlockPlace& place_;
  const BlockVoxels& voxels_;
  ColourUpdate colours_;
  Vectors in_picture_, observed_, coloured_;
  alignas(64) Numbers zu_, zv_, z_;  ///< z times the pixel coordinates (u, v), and z
  alignas(64) Numbers per_z_;        ///< 0 outside the picture
  alignas(64) Numbers weight_, distance_;
  alignas(64) Numbers along_normal_;  ///< 0 where no colour is taken
  alignas(64) std::array<std::int32_t, kBlockVoxels> pixel_;
};

void update_block(const FrameView& frame, const BlockPlace& place, const BlockVoxels& voxels, BlockChange& change) {
  VoxelUpdate(frame, place, voxels).apply(change);
}

}  // namespace scanknit::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace scanknit {

HWY_EXPORT(update_block);

void update_block(const FrameView& frame, const BlockPlace& place, const BlockVoxels& voxels, BlockChange& change) {
  HWY_DYNAMIC_DISPATCH(update_block)(frame, place, voxels, change);
}

FrameView::FrameView(const Image<PixelPlane>& pixels, const CameraIntrinsics& camera, const Pose& T_camera_world,
                     const FusionConfig& config)
    : planes(pixels.pixels().data()),
      width(camera.width),
      height(camera.height),
      fx(static_cast<float>(camera.fx)),
      fy(static_cast<float>(camera.fy)),
      cx(static_cast<float>(camera.cx)),
      cy(static_cast<float>(camera.cy)),
      per_fx(static_cast<float>(1 / camera.fx)),
      per_fy(static_cast<float>(1 / camera.fy)),
      band_m(static_cast<float>(config.truncation_voxels * config.voxel_size_m)),
      max_weight(std::min(static_cast<float>(config.max_weight), kMaxCodedWeight)),
      noise(config.noise),
      best_variance(noise.sigma_m(noise.from_m) * noise.sigma_m(noise.from_m)) {
  Eigen::Matrix3d K;
  K << camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1;
  index_to_pixels_ = K * T_camera_world.linear() * config.voxel_size_m;
  origin_in_pixels_ = K * T_camera_world.translation();
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    VoxelSteps& along = steps[static_cast<std::size_t>(axis)];
    const Eigen::RowVector3d step = index_to_pixels_.row(axis);
    for (std::size_t n = 0; n < kBlockSide; ++n) along.slab[n] = static_cast<float>(step.x() * static_cast<double>(n));
    for (std::size_t n = 0; n < kSlabVoxels; ++n) {
      along.in_slab[n] = static_cast<float>(step.y() * static_cast<double>(n / kBlockSide) +
                                            step.z() * static_cast<double>(n % kBlockSide));
    }
  }
}

BlockPlace FrameView::place(const Eigen::Vector3d& first, float far_m) const {
  const Eigen::Vector3f p = (index_to_pixels_ * first + origin_in_pixels_).cast<float>();
  return {{p.x(), p.y(), p.z()}, far_m};
}

}  // namespace scanknit
#endif
