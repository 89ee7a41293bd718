// The inner loop of DepthCorrection. It chooses the widest instructions of the processor at run time; each operation is
// rounded as IEEE 754 says, none are fused, so all give the same bits.
#pragma once

#include <span>

namespace scanknit {

/// What a divisor is held between.
struct DivisorBounds {
  float least, most;
};

/// z / (one_plus_scale + shift z), the divisor within bounds; 0 where there is no return. All of one length.
void correct_row(std::span<const float> one_plus_scale, std::span<const float> shift_per_m, DivisorBounds bounds,
                 std::span<float> z_m);

}  // namespace scanknit
