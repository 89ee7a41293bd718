// sRGB encoding: IEC 61966-2-1:1999, section 5.2 (decoding) and 5.3 (encoding).
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace scanknit {

/// Encoded byte to linear light in [0, 1].
[[nodiscard]] inline double linear_from_srgb(std::uint8_t encoded) {
  const double c = encoded / 255.0;
  return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
}

/// Linear light to the nearest encoded byte; values outside [0, 1] are clamped, NaN is 0.
[[nodiscard]] inline std::uint8_t srgb_from_linear(double linear) {
  const double c = linear > 0 ? std::min(linear, 1.0) : 0.0;
  const double encoded = c <= 0.0031308 ? 12.92 * c : 1.055 * std::pow(c, 1 / 2.4) - 0.055;
  return static_cast<std::uint8_t>(std::lround(255 * encoded));
}

}  // namespace scanknit
