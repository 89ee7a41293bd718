// Counting bits without a function call: std::popcount makes one where the processor is not known to have the
// instruction.
#pragma once

#include <cstdint>

namespace scanknit {

/// Number of bits that are set: sums of 2, 4, 8 neighbouring bits, then of all bytes in the highest one.
[[nodiscard]] constexpr unsigned count_bits(std::uint64_t bits) {
  bits -= (bits >> 1) & 0x5555555555555555u;
  bits = (bits & 0x3333333333333333u) + ((bits >> 2) & 0x3333333333333333u);
  bits = (bits + (bits >> 4)) & 0x0F0F0F0F0F0F0F0Fu;
  return static_cast<unsigned>((bits * 0x0101010101010101u) >> 56);
}

}  // namespace scanknit
