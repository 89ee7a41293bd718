// Luma: brightness of an sRGB colour as tracking compares it.
#pragma once

namespace scanknit {

/// Rec. 601 luma of sRGB-encoded values; in the unit of its arguments.
[[nodiscard]] constexpr float luma(float r, float g, float b) {
  return 0.299f * r + 0.587f * g + 0.114f * b;
}

}  // namespace scanknit
