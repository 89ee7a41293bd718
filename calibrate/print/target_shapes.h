// What is black on a board.
#pragma once

#include <vector>

#include "calibrate/target/calibration_target.h"
#include "core/result.h"

namespace scanknit {

struct BlackRectangle {
  Eigen::Vector2d corner_m;  ///< top left, in the board's frame
  Eigen::Vector2d size_m;
};

/// The rectangles of a valid target; they may touch, but do not overlap. Error (kInternal): the module with the tags'
/// codes is missing.
[[nodiscard]] Result<std::vector<BlackRectangle>> target_shapes(const CalibrationTarget& target);

}  // namespace scanknit
