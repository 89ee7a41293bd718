// A board on a sheet of paper, with lines to measure.
#pragma once

#include <optional>

#include "calibrate/print/vector_page.h"
#include "calibrate/target/calibration_target.h"
#include "core/result.h"

namespace scanknit {

enum class Paper { kA4, kA3, kLetter };

/// The largest size_m, in whole millimetres, with which this type of board fits on the paper, upright or across;
/// nothing if it would be below one millimetre. The target's own size_m does not matter.
[[nodiscard]] std::optional<double> largest_size_m(const CalibrationTarget& target, Paper paper);

/// The board in the middle, a line of 100 mm below it and one at its left, and a text that says how to check the print.
/// The sheet lies across if the board is wider than high. Errors (kUsage): the board does not fit; the message has the
/// largest size that does. (kInternal): target_shapes()'s.
[[nodiscard]] Result<VectorPage> target_page(const CalibrationTarget& target, Paper paper);

}  // namespace scanknit
