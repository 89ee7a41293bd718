// Compiled once for each instruction set by Highway, which includes this file again through foreach_target.h.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fusion/integrate/update_block.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <algorithm>

#include "fusion/integrate/colour_update.inl"
#include "fusion/integrate/update_block.h"

HWY_BEFORE_NAMESPACE();
namespace scanknit::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Codes16 = hn::Rebind<WeightCode, Floats>;

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
    if (frame_.colour.pixels == nullptr) return;
    aim();
    change.has_colour = coloured_.begin() != coloured_.end();
    paint();
  }

 private:
  using Numbers = std::array<float, kBlockVoxels>;
  using Integers = std::array<std::int32_t, kBlockVoxels>;

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
      hn::StoreU(u, f, u_.data() + at);
      hn::StoreU(v, f, v_.data() + at);
      hn::StoreU(z, f, z_.data() + at);
      hn::StoreU(hn::IfThenElseZero(is_in, per_z), f, per_z_.data() + at);
      in_picture_.add_if(!hn::AllFalse(f, is_in), at);
    }
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
      VC z_word, slope_word, turn_word, weight_word;
      four_words(at, z_word, slope_word, turn_word, weight_word);
      const auto z_there = hn::BitCast(f, z_word);
      const auto truncation =
          hn::Max(set(frame_.band_m), hn::Mul(set(frame_.truncation_sigmas), sigma_of(frame_.noise, z_there)));
      const auto is_seen = hn::And(hn::And(is_in, hn::Gt(z_there, zero)), hn::Le(z, hn::Add(z_there, truncation)));
      if (hn::AllFalse(f, is_seen)) continue;
      const VF u = load(u_, at), v = load(v_, at);
      const auto slope = hn::BitCast(f, slope_word);
      const auto beside =
          hn::Add(hn::Mul(upper_half(turn_word), off_pixel(u)), hn::Mul(lower_half(turn_word), off_pixel(v)));
      const auto distance = hn::Add(hn::Mul(slope, hn::Sub(z, z_there)), hn::Mul(beside, z));
      const auto along_normal = hn::Add(distance, hn::Mul(slope, z_there));
      const auto per_truncation = upper_half(weight_word);
      const auto pixel_weight = lower_half(weight_word);
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
      inner_.add_if(!hn::AllFalse(f, is_inner), at);
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
    const auto sigma = sigma_of(frame_.noise, z);
    const auto here = hn::Div(set(kFreeSpaceShare * frame_.best_variance), hn::Mul(sigma, sigma));
    return hn::IfThenElse(is_clear, hn::Max(weight, here), weight);
  }

  /// The weighted running mean.
  HWY_INLINE void move(BlockChange& change) const {
    const Floats f;
    const auto zero = hn::Zero(f);
    std::array<std::uint64_t, kBlockEdgeVoxels> free{};
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
      const auto is_free = hn::And(is_observed, hn::Ge(moved, set(frame_.band_m)));
      free[at / kSlabVoxels] |= std::uint64_t{bits(is_free)} << at % kSlabVoxels;
      change.has_matter |= !hn::AllFalse(f, hn::And(is_observed, hn::Lt(moved, zero)));
    }
    change.is_free =
        std::all_of(free.begin(), free.end(), [](std::uint64_t slab) { return slab == ~std::uint64_t{0}; });
  }

  /// Finds the colours' pixels.
  HWY_INLINE void aim() {
    const Floats f;
    const Ints i;
    for (const std::size_t at : inner_) {
      const VF z = load(z_, at);
      const VF x = hn::Mul(hn::Mul(hn::Sub(load(u_, at), set(frame_.cx)), set(frame_.per_fx)), z);
      const VF y = hn::Mul(hn::Mul(hn::Sub(load(v_, at), set(frame_.cy)), set(frame_.per_fy)), z);
      const VF along_normal = load(along_normal_, at);
      VI u_256, v_256;
      const auto seen = colours_.aim({x, y, z}, hn::Ne(along_normal, hn::Zero(f)), u_256, v_256);
      const auto per_range = hn::Mul(load(per_z_, at), set(kBestColourRange));
      const auto squared = hn::Add(hn::Add(hn::Mul(x, x), hn::Mul(y, y)), hn::Mul(z, z));
      const auto cosine_squared = hn::Div(hn::Mul(along_normal, along_normal), squared);
      const auto goodness = hn::Min(hn::Mul(cosine_squared, hn::Mul(per_range, per_range)), set(1));
      hn::StoreU(hn::IfThenElseZero(seen, goodness), f, goodness_.data() + at);
      hn::StoreU(u_256, i, u_256_.data() + at);
      hn::StoreU(v_256, i, v_256_.data() + at);
      hn::StoreU(colours_.pixel(u_256, v_256), i, pixel_.data() + at);
      coloured_.add_if(!hn::AllFalse(f, seen), at);
      __builtin_prefetch(voxels_.colour + at, /*for writing*/ 1);
    }
  }

  HWY_INLINE void paint() const {
    const Codes32 c;
    for (const std::size_t at : coloured_) {
      std::uint32_t* const codes = &voxels_.colour[at].bits;
      const VC old = hn::LoadU(c, codes);
      const VF goodness = load(goodness_, at);
      const VC mean = colours_.mean(pixel_.data() + at, load(u_256_, at), load(v_256_, at), goodness,
                                    static_cast<std::uint32_t>(at), old);
      const auto takes = hn::RebindMask(c, hn::Gt(goodness, hn::Zero(Floats())));
      hn::StoreU(hn::IfThenElse(takes, mean, old), c, codes);
    }
  }

  static HWY_INLINE VF load(const Numbers& numbers, std::size_t at) { return hn::LoadU(Floats(), numbers.data() + at); }
  static HWY_INLINE VI load(const Integers& numbers, std::size_t at) { return hn::LoadU(Ints(), numbers.data() + at); }

  /// The words of the planes that a vector of voxels projects to. Loaded one plane after the other and transposed: a
  /// gather for each word takes several times as long.
  HWY_INLINE void four_words(std::size_t at, VC& a, VC& b, VC& c, VC& d) const {
    const std::int32_t* const pixels = pixel_.data() + at;
    const auto words_of = [&](std::size_t lane) {
      return reinterpret_cast<const std::uint32_t*>(frame_.planes + pixels[lane]);
    };
    const Codes32 words;
#if HWY_TARGET == HWY_SCALAR
    a = hn::LoadU(words, words_of(0));
    b = hn::LoadU(words, words_of(0) + 1);
    c = hn::LoadU(words, words_of(0) + 2);
    d = hn::LoadU(words, words_of(0) + 3);
#else
    const hn::RepartitionToWide<Codes32> wide;
    const auto four = [&](std::size_t lane) { return hn::LoadU(hn::CappedTag<std::uint32_t, 4>(), words_of(lane)); };
    // Each fourth plane from the first on, each fourth from the second on, ...
    constexpr std::size_t kParts = hn::MaxLanes(words) / 4;
    const VC p0 = joined<kParts, 4>(four, 0), p1 = joined<kParts, 4>(four, 1), p2 = joined<kParts, 4>(four, 2),
             p3 = joined<kParts, 4>(four, 3);
    const auto ab01 = hn::BitCast(wide, hn::InterleaveLower(words, p0, p1));
    const auto ab23 = hn::BitCast(wide, hn::InterleaveLower(words, p2, p3));
    const auto cd01 = hn::BitCast(wide, hn::InterleaveUpper(words, p0, p1));
    const auto cd23 = hn::BitCast(wide, hn::InterleaveUpper(words, p2, p3));
    a = hn::BitCast(words, hn::InterleaveLower(wide, ab01, ab23));
    b = hn::BitCast(words, hn::InterleaveUpper(wide, ab01, ab23));
    c = hn::BitCast(words, hn::InterleaveLower(wide, cd01, cd23));
    d = hn::BitCast(words, hn::InterleaveUpper(wide, cd01, cd23));
#endif
  }

  static HWY_INLINE VF upper_half(VC word) {
    return hn::BitCast(Floats(), hn::And(word, hn::Set(Codes32(), 0xFFFF0000)));
  }
  static HWY_INLINE VF lower_half(VC word) {
    return hn::BitCast(Floats(), hn::ShiftLeft<16>(word));
  }

  /// From the middle of the pixel that rounded() gives.
  static HWY_INLINE VF off_pixel(VF at) {
    return hn::Sub(at, hn::Sub(hn::Add(at, set(kWhole)), set(kWhole)));
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
  Vectors in_picture_, observed_, inner_, coloured_;
  alignas(64) Numbers u_, v_, z_;  ///< pixel coordinates, and z
  alignas(64) Numbers per_z_;      ///< 0 outside the picture
  alignas(64) Numbers weight_, distance_;
  alignas(64) Numbers along_normal_;  ///< 0 where no colour is taken
  alignas(64) Integers pixel_;        ///< of depth, then of colour
  alignas(64) Numbers goodness_;      ///< 0 where no colour is taken
  alignas(64) Integers u_256_, v_256_;
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
      cx(static_cast<float>(camera.cx)),
      cy(static_cast<float>(camera.cy)),
      per_fx(static_cast<float>(1 / camera.fx)),
      per_fy(static_cast<float>(1 / camera.fy)),
      band_m(static_cast<float>(config.truncation_voxels * config.voxel_size_m)),
      truncation_sigmas(static_cast<float>(config.truncation_sigmas)),
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
    for (std::size_t n = 0; n < kBlockEdgeVoxels; ++n)
      along.slab[n] = static_cast<float>(step.x() * static_cast<double>(n));
    for (std::size_t n = 0; n < kSlabVoxels; ++n) {
      along.in_slab[n] = static_cast<float>(step.y() * static_cast<double>(n / kBlockEdgeVoxels) +
                                            step.z() * static_cast<double>(n % kBlockEdgeVoxels));
    }
  }
}

BlockPlace FrameView::place(const Eigen::Vector3d& first, float far_m) const {
  const Eigen::Vector3f p = (index_to_pixels_ * first + origin_in_pixels_).cast<float>();
  return {{p.x(), p.y(), p.z()}, far_m};
}

}  // namespace scanknit
#endif
