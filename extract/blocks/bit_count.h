// Counts bits without a function call: std::popcount makes one if the compiler's target does not have the instruction.
#pragma once

#include <cstdint>

namespace scanknit {

/// The number of set bits: sums 2, 4, 8 neighbouring bits, then all bytes into the highest one.
[[nodiscard]] constexpr unsigned count_bits(std::uint64_t bits) {
  bits -= (bits >> 1) & 0x5555555555555555u;
  bits = (bits & 0x3333333333333333u) + ((bits >> 2) & 0x3333333333333333u);
  bits = (bits + (bits >> 4)) & 0x0F0F0F0F0F0F0F0Fu;
  return static_cast<unsigned>((bits * 0x0101010101010101u) >> 56);
}

}  // namespace scanknit
