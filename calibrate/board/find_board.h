// Finds a board's corners in a picture.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "calibrate/target/calibration_target.h"
#include "core/image.h"
#include "core/result.h"

namespace scanknit {

struct SeenCorner {
  int number = 0;  ///< its place in target_corners()
  Eigen::Vector2d pixel;
};

/// What a picture shows of the board.
enum class BoardSight {
  kSeen,
  kNothing,    ///< no tag
  kTooLittle,  ///< fewer than kFewestCorners corners
  kOther,      ///< tags that the target does not have, or not in this arrangement
  kMirrored,   ///< tags are found once the picture is mirrored
};

struct BoardSighting {
  BoardSight sight = BoardSight::kNothing;
  std::vector<SeenCorner> corners;  ///< by number; empty unless kSeen
  /// How steep the edges at the corners are: the change from pixel to pixel as a share of the contrast, up to 0.5. For
  /// each corner that of the less steep direction, since motion blurs one only.
  double sharpness = 0;
};

inline constexpr std::size_t kFewestCorners = 12;

/// `target` is valid. Tags that are covered or out of the picture are left out, and so are corners that cannot be
/// placed exactly. Error (kInternal): the module that finds tags is missing.
[[nodiscard]] Result<BoardSighting> find_board(const ColourImage& picture, const CalibrationTarget& target);

}  // namespace scanknit
