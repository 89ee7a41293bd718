// Compiled once for each instruction set by Highway, which includes this file again through foreach_target.h.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "extract/blocks/sign_bytes.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <limits>

#include "extract/blocks/sign_bytes.h"

HWY_BEFORE_NAMESPACE();
namespace scanknit::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

void sign_bytes(const float* samples, std::size_t groups, float isovalue, std::uint8_t* high, std::uint8_t* missing) {
  const hn::CappedTag<float, 8> lanes;
  const auto limit = hn::Set(lanes, isovalue);
  const auto largest = hn::Set(lanes, std::numeric_limits<float>::max());
  for (std::size_t group = 0; group < groups; ++group) {
    const float* const eight = samples + 8 * group;
    const auto classify = [&](std::size_t first, std::uint8_t* high_bits, std::uint8_t* missing_bits) {
      const auto value = hn::LoadU(lanes, eight + first);
      const auto finite = hn::Le(hn::Abs(value), largest);  // false for NaN as well
      hn::StoreMaskBits(lanes, hn::And(finite, hn::Ge(value, limit)), high_bits);
      hn::StoreMaskBits(lanes, hn::Not(finite), missing_bits);
    };
    if constexpr (hn::MaxLanes(lanes) == 8) {
      classify(0, high + group, missing + group);
      continue;
    }
    unsigned is_high = 0;
    unsigned is_missing = 0;
    for (std::size_t i = 0; i < 8; i += hn::Lanes(lanes)) {
      std::uint8_t high_bits[8] = {};
      std::uint8_t missing_bits[8] = {};
      classify(i, high_bits, missing_bits);
      is_high |= unsigned{high_bits[0]} << i;
      is_missing |= unsigned{missing_bits[0]} << i;
    }
    high[group] = static_cast<std::uint8_t>(is_high);
    missing[group] = static_cast<std::uint8_t>(is_missing);
  }
}

}  // namespace scanknit::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include <cmath>

namespace scanknit {

HWY_EXPORT(sign_bytes);

void sign_bytes(const float* samples, std::size_t groups, float isovalue, std::uint8_t* high, std::uint8_t* missing) {
  HWY_DYNAMIC_DISPATCH(sign_bytes)(samples, groups, isovalue, high, missing);
}

float float_isovalue(double isovalue) {
  if (isovalue > static_cast<double>(std::numeric_limits<float>::max())) return std::numeric_limits<float>::infinity();
  if (isovalue < static_cast<double>(std::numeric_limits<float>::lowest())) return std::numeric_limits<float>::lowest();
  const auto nearest = static_cast<float>(isovalue);
  return static_cast<double>(nearest) >= isovalue ? nearest
                                                  : std::nextafter(nearest, std::numeric_limits<float>::infinity());
}

}  // namespace scanknit
#endif
