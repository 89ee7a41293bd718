// Signs of samples, eight at a time.
#pragma once

#include <cstddef>
#include <cstdint>

namespace scanknit {

/// The smallest float not below `isovalue`: for a float v, v >= isovalue iff v >= this.
[[nodiscard]] float float_isovalue(double isovalue);

/// For each group of eight samples one byte, sample i in bit i: `high` where it is finite and >= isovalue, `missing`
/// where it is not finite. `samples` holds 8 * groups floats, `high` and `missing` one byte for each group. Chooses the
/// widest instructions of the processor at run time; comparisons are exact, so all give the same bits.
void sign_bytes(const float* samples, std::size_t groups, float isovalue, std::uint8_t* high, std::uint8_t* missing);

}  // namespace scanknit
