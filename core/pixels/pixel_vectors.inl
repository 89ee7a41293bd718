// Vectors of floats that go along rows of pixels or voxels. Compiled once for each instruction set, as the file that
// includes it.
#if defined(SCANKNIT_CORE_PIXEL_VECTORS_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef SCANKNIT_CORE_PIXEL_VECTORS_INL
#undef SCANKNIT_CORE_PIXEL_VECTORS_INL
#else
#define SCANKNIT_CORE_PIXEL_VECTORS_INL
#endif

#include <hwy/highway.h>

#include <array>
#include <cstddef>
#include <cstdint>

#include "core/pixels/pixel_rows.h"

HWY_BEFORE_NAMESPACE();
namespace scanknit::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Floats = hn::CappedTag<float, kPixelGroup>;
using VF = hn::Vec<Floats>;
using MF = hn::Mask<Floats>;

HWY_INLINE VF set(float value) {
  return hn::Set(Floats(), value);
}

/// 0, 1, 2 ... Loaded: hn::Iota is a loop of stores on some targets.
HWY_INLINE VF lane_numbers() {
  alignas(64) static constexpr std::array<float, kPixelGroup> kNumbers{0, 1, 2,  3,  4,  5,  6,  7,
                                                                       8, 9, 10, 11, 12, 13, 14, 15};
  return hn::Load(Floats(), kNumbers.data());
}

/// Bit n: lane n.
HWY_INLINE std::uint16_t bits(MF mask) {
  alignas(8) std::array<std::uint8_t, 8> bytes{};
  hn::StoreMaskBits(Floats(), mask, bytes.data());
  return static_cast<std::uint16_t>(bytes[0] | bytes[1] << 8);
}

/// As FloatNoise::sigma_m.
HWY_INLINE VF sigma_of(const FloatNoise& noise, VF z) {
  const VF beyond = hn::Sub(z, set(noise.from_m));
  return hn::Add(set(noise.floor_m), hn::Mul(set(noise.growth_per_m), hn::Mul(beyond, beyond)));
}

/// Calls group(x) for runs of Lanes pixels that cover first to before last, kPixelGroup or more; the last ones may
/// overlap, for loops that give a pixel the same however often it is met.
template <typename Group>
HWY_INLINE void for_each_group(int first, int last, const Group& group) {
  for (int x = first; x < last; x += kPixelGroup) {
    const int begin = x < last - kPixelGroup ? x : last - kPixelGroup;
    for (int lane = 0; lane < kPixelGroup; lane += static_cast<int>(hn::Lanes(Floats()))) group(begin + lane);
  }
}

}  // namespace scanknit::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
