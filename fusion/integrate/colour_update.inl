// A frame's colours enter vectors of voxels. Compiled once for each instruction set, as the file that includes it.
#if defined(SCANKNIT_FUSION_COLOUR_UPDATE_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef SCANKNIT_FUSION_COLOUR_UPDATE_INL
#undef SCANKNIT_FUSION_COLOUR_UPDATE_INL
#else
#define SCANKNIT_FUSION_COLOUR_UPDATE_INL
#endif

#include <hwy/highway.h>

#include <cstddef>
#include <cstdint>

#include "core/pixels/pixel_vectors.inl"
#include "fusion/integrate/update_block.h"

HWY_BEFORE_NAMESPACE();
namespace scanknit::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Ints = hn::RebindToSigned<Floats>;
using Codes32 = hn::RebindToUnsigned<Floats>;
using VI = hn::Vec<Ints>;
using VC = hn::Vec<Codes32>;

#if HWY_TARGET != HWY_SCALAR
/// part(from), part(from + kStep) ... kParts of them in one vector, the first in its lowest lanes.
template <std::size_t kParts, std::size_t kStep, typename Part>
HWY_INLINE auto joined(const Part& part, std::size_t from) {
  if constexpr (kParts == 1) {
    return part(from);
  } else {
    const auto low = joined<kParts / 2, kStep>(part, from);
    const auto high = joined<kParts / 2, kStep>(part, from + kStep * kParts / 2);
    return hn::Combine(hn::Twice<hn::DFromV<decltype(low)>>(), high, low);
  }
}
#endif

/// Two numbers of 16 bits in each lane, multiplied one by one.
#if HWY_TARGET == HWY_SCALAR
template <int kShift>
HWY_INLINE VC halves_times(VC a, VC b) {
  const auto times = [](std::uint32_t x, std::uint32_t y) { return (x * y >> kShift) & 0xFFFF; };
  const std::uint32_t x = hn::GetLane(a), y = hn::GetLane(b);
  return hn::Set(Codes32(), times(x & 0xFFFF, y & 0xFFFF) | times(x >> 16, y >> 16) << 16);
}
HWY_INLINE VC low_times(VC a, VC b) {
  return halves_times<0>(a, b);
}
HWY_INLINE VC high_times(VC a, VC b) {
  return halves_times<16>(a, b);
}
#else
using Halves = hn::Repartition<std::uint16_t, Codes32>;
HWY_INLINE VC low_times(VC a, VC b) {
  return hn::BitCast(Codes32(), hn::Mul(hn::BitCast(Halves(), a), hn::BitCast(Halves(), b)));
}
HWY_INLINE VC high_times(VC a, VC b) {
  return hn::BitCast(Codes32(), hn::MulHigh(hn::BitCast(Halves(), a), hn::BitCast(Halves(), b)));
}
#endif
HWY_INLINE VC in_both_halves(VC number) {
  return hn::Or(number, hn::ShiftLeft<16>(number));
}
/// From a (`share` 0) to b (65536) in both halves. The same if they are the same.
HWY_INLINE VC mixed(VC a, VC b, VC share) {
  return hn::Add(hn::Sub(a, high_times(a, share)), high_times(b, share));
}

/// Added to a number from -0.5 to below 2^22 it leaves no fraction: floats from 2^23 to 2^24 are integers.
constexpr float kWhole = 0x1.8p23f;

/// To the nearest, for such numbers.
HWY_INLINE VI rounded(VF number) {
  return hn::And(hn::BitCast(Ints(), hn::Add(number, set(kWhole))), hn::Set(Ints(), 0x3FFFFF));
}

/// Voxels in camera coordinates.
struct Points {
  VF x, y, z;
};

/// A frame's colours. Channels are handled in pairs, red with blue and green with what is no channel, as 16-bit numbers
/// of 1/256 of a step.
class ColourUpdate {
 public:
  explicit ColourUpdate(const ColourView& view) : view_(view) {}

  /// Pixel coordinates in the frame's colours, in 1/256 pixel. Returns those of `takes` that are within the picture.
  HWY_INLINE MF aim(const Points& p, MF takes, VI& u_256, VI& v_256) const {
    const Floats f;
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
    const auto in_256ths = [&](VF at, int size) {  // not rounded up to the last pixel, which has no neighbour
      const auto number = rounded(hn::IfThenElseZero(seen, hn::Mul(at, set(256))));
      return hn::Min(number, hn::Set(Ints(), 256 * (size - 1) - 1));
    };
    u_256 = in_256ths(u, view_.width);
    v_256 = in_256ths(v, view_.height);
    return seen;
  }

  [[nodiscard]] HWY_INLINE VI pixel(VI u_256, VI v_256) const {
    return hn::Add(hn::Mul(hn::ShiftRight<8>(v_256), hn::Set(Ints(), view_.width)), hn::ShiftRight<8>(u_256));
  }

  /// `pixels`: numbers of as many pixels as there are lanes. `goodness`: (cos(incidence) / z)^2 against the best that
  /// can be. `noise`: any number, another for every voxel.
  HWY_INLINE VC mean(const std::int32_t* pixels, VI u_256, VI v_256, VF goodness, std::uint32_t noise, VC old) const {
    const Codes32 c;
    VC p00, p10, p01, p11;
    pairs_at(pixels, view_.pixels, p00, p10);
    pairs_at(pixels, view_.pixels + view_.width, p01, p11);
    const auto fraction = [&](VI at_256) { return hn::And(hn::BitCast(c, at_256), hn::Set(c, 0xFF)); };
    const auto right = in_both_halves(fraction(u_256));
    const auto left = hn::Sub(hn::Set(c, 0x01000100), right);
    const auto down = in_both_halves(hn::ShiftLeft<8>(fraction(v_256)));
    const auto best = hn::ShiftRight<24>(old);
    const auto share = in_both_halves(share_of(goodness, best));
    const auto dither = dither_of(noise);
    const auto channels = [&](auto channel) {
      const auto above = hn::Add(low_times(channel(p00), left), low_times(channel(p10), right));
      const auto below = hn::Add(low_times(channel(p01), left), low_times(channel(p11), right));
      const auto now = mixed(above, below, down);
      return hn::Add(mixed(hn::ShiftLeft<8>(channel(old)), now, share), dither);
    };
    const auto both = hn::Set(c, 0x00FF00FF);
    const auto red_blue = channels([&](VC code) { return hn::And(code, both); });
    const auto green = channels([&](VC code) { return hn::And(hn::ShiftRight<8>(code), hn::Set(c, 0xFF)); });
    const auto quality = hn::BitCast(c, rounded(hn::Mul(hn::Sqrt(goodness), set(255))));
    const auto rgb = hn::Or(hn::And(hn::ShiftRight<8>(red_blue), both), hn::And(green, hn::Set(c, 0xFF00)));
    return hn::Or(rgb, hn::ShiftLeft<24>(hn::Max(hn::Max(quality, best), hn::Set(c, 1))));
  }

 private:
  /// Of a new view in the mean, in 1/65536 and a little less than all of it.
  static HWY_INLINE VC share_of(VF goodness, VC best_code) {
    const auto best = hn::Mul(hn::ConvertTo(Floats(), hn::BitCast(Ints(), best_code)), set(1.0f / 255));
    const auto good = hn::Mul(goodness, goodness);
    const auto best_squared = hn::Mul(best, best);
    const auto others = hn::Mul(set(kColourViews - 1), hn::Mul(best_squared, best_squared));
    constexpr float kLeast = 1e-30f;  // something to divide by
    const auto share = hn::Div(good, hn::Max(hn::Add(good, others), set(kLeast)));
    return hn::BitCast(Codes32(), rounded(hn::Min(hn::Mul(share, set(65536)), set(65535))));
  }

  /// Each pixel and the one to its right: two gathers take three times as long.
  static HWY_INLINE void pairs_at(const std::int32_t* numbers, const std::uint32_t* pixels, VC& left, VC& right) {
#if HWY_TARGET == HWY_SCALAR
    left = hn::LoadU(Codes32(), pixels + numbers[0]);
    right = hn::LoadU(Codes32(), pixels + numbers[0] + 1);
#else
    constexpr std::size_t kLanes = hn::MaxLanes(Codes32());
    const auto pair = [&](std::size_t lane) {
      return hn::LoadU(hn::CappedTag<std::uint32_t, 2>(), pixels + numbers[lane]);
    };
    const auto low = joined<kLanes / 2, 1>(pair, 0);
    const auto high = joined<kLanes / 2, 1>(pair, kLanes / 2);
    left = hn::ConcatEven(Codes32(), high, low);
    right = hn::ConcatOdd(Codes32(), high, low);
#endif
  }

  /// From 0 to below 1 as if at random, in both halves, in 1/256: 1 (for what rounding took) to 255.
  HWY_INLINE VC dither_of(std::uint32_t noise) const {
    const Codes32 c;
    const auto number = hn::Add(hn::BitCast(c, hn::ConvertTo(Ints(), lane_numbers())), hn::Set(c, noise + view_.seed));
    const auto random = hn::Mul(
        hn::Xor(hn::Mul(number, hn::Set(c, 0x9E3779B1u)), hn::ShiftRight<15>(hn::Mul(number, hn::Set(c, 0x85EBCA77u)))),
        hn::Set(c, 0xC2B2AE3Du));
    return in_both_halves(hn::Or(hn::ShiftRight<24>(random), hn::Set(c, 1)));
  }

  const ColourView& view_;
};

}  // namespace scanknit::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
