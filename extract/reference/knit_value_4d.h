// The knit value of a 4-cube, for a volume that varies with time.
#pragma once

#include "extract/cell/knit_value.h"

namespace scanknit {

/// lower <= knit value <= upper.
struct KnitBounds {
  double lower = 0;
  double upper = 0;
};

/// Certified bounds (up to rounding) with upper - lower <= tolerance. `tolerance` > 0, in the unit of the values, and
/// at least 1e-12 times their range; the work grows as its square root falls.
///
/// Bottlenecks are monotone in the corner values, and a corner's value is linear in w. Over an interval of w the
/// elementwise maximum of the cubes at its two ends bounds every slice from above, the minimum from below. For a level
/// t and a slack, intervals are halved until what is joined at t + slack in the upper cube is joined at t - slack in
/// the lower one; then corners joined through all the lower cubes prove t - slack <= value, else value < t + slack.
[[nodiscard]] KnitBounds knit_bounds_4d(const std::array<double, 16>& corner_values, int corner_a, int corner_b,
                                        double tolerance);

/// knit_value<4> is within this times the range of the corner values of the truth.
inline constexpr double kKnit4dTolerance = 1e-6;

template <>
[[nodiscard]] double knit_value<4>(const std::array<double, 16>& corner_values, int corner_a, int corner_b);

}  // namespace scanknit
