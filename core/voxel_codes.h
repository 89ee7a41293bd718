// The codes of weight and colour that a voxel of a live volume has in addition to its signed distance: six bytes.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "core/image.h"

namespace scanknit {

/// A weight in 16 bits, as (code / 1024)^2, with fine steps for small weights. Code 0 is only for weight 0. Linear
/// codes would suit only one distance: weights of views from 0.5 m and from 3 m differ by a factor of 100.
using WeightCode = std::uint16_t;
inline constexpr float kWeightCodeUnit = 1.0f / 1024.0f;
inline constexpr float kMaxCodedWeight = 65535.0f * 65535.0f / (1024.0f * 1024.0f);  ///< 4095.9

[[nodiscard]] inline float decode_weight(WeightCode code) {
  const float root = static_cast<float>(code) * kWeightCodeUnit;
  return root * root;
}

/// The nearest code; at least 1 for weight > 0; weights above kMaxCodedWeight get the highest code.
[[nodiscard]] inline WeightCode encode_weight(float weight) {
  if (!(weight > 0)) return 0;
  const float code = std::sqrt(weight) / kWeightCodeUnit;
  return static_cast<WeightCode>(std::lrint(std::clamp(code, 1.0f, 65535.0f)));
}

/// sRGB in the low three bytes, red lowest. The highest byte is the quality of the view that it comes from, 1 to 255;
/// 0: no colour was seen. It is a type of its own so that unused leaves take no memory: OpenVDB would otherwise
/// allocate their voxels.
struct ColourCode {
  constexpr ColourCode() = default;
  constexpr ColourCode(std::uint32_t bits_) : bits(bits_) {}  // implicit: OpenVDB compares and adds voxels as numbers
  constexpr operator std::uint32_t() const { return bits; }

  std::uint32_t bits = 0;
};

[[nodiscard]] constexpr bool has_colour(ColourCode code) {
  return code >> 24 != 0;
}

[[nodiscard]] constexpr Rgb8 decode_colour(ColourCode code) {
  return {static_cast<std::uint8_t>(code & 0xFFu), static_cast<std::uint8_t>(code >> 8 & 0xFFu),
          static_cast<std::uint8_t>(code >> 16 & 0xFFu)};
}

[[nodiscard]] constexpr ColourCode encode_colour(const Rgb8& colour, std::uint8_t quality) {
  return colour.r | static_cast<std::uint32_t>(colour.g) << 8 | static_cast<std::uint32_t>(colour.b) << 16 |
         static_cast<std::uint32_t>(quality) << 24;
}

}  // namespace scanknit
