// CalibrationTarget: the board that is shown to a camera, and where its corners are.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/result.h"

namespace scanknit {

enum class TargetType {
  kAprilGrid,  ///< a grid of AprilTags (Olson 2011), a small square off each of their corners (as in Kalibr's boards)
  kCharuco,    ///< a chessboard with an AprilTag in each white square
};

/// All tags are of the family 36h11, numbered from 0 row by row from the top left. A board's frame is in metres: x
/// right, y down along the printed face, z into the paper, origin at the top left of what is black.
struct CalibrationTarget {
  TargetType type = TargetType::kAprilGrid;
  int columns = 6, rows = 4;  ///< kAprilGrid: of tags; kCharuco: of squares, black and white
  double size_m = 0.03;       ///< kAprilGrid: the side of a tag's black border; kCharuco: the side of a square

  friend bool operator==(const CalibrationTarget&, const CalibrationTarget&) = default;
};

/// Between two tags of an AprilGrid, as a share of a tag's side.
inline constexpr double kTagGap = 0.3;
/// The part of that gap which the square off the corners leaves free on each of its sides. Squares that touched the
/// tags would melt into one shape with them where a picture is blurred.
inline constexpr double kSquareMargin = 0.15;
/// The side of a ChArUco board's tags, as a share of a square's side.
inline constexpr double kCharucoTag = 0.75;
/// Cells of a tag along a side: six of code and a black border.
inline constexpr int kTagCells = 8;
/// Tags of the family 36h11.
inline constexpr int kTagsOfFamily = 587;

/// Errors (kConfig, without `where`): columns or rows below 2 (kCharuco: 3) or above 100, more tags than the family
/// has, a size that is not above 0 and at most 10 m.
[[nodiscard]] Result<void> validate(const CalibrationTarget& target);

// All below: of a valid target.

/// From the left edge of what is black to its right edge, and from top to bottom; metres.
[[nodiscard]] Eigen::Vector2d extent_m(const CalibrationTarget& target);

[[nodiscard]] int tag_count(const CalibrationTarget& target);

/// The top left corner and the side of a tag's black border, metres.
struct TagPlace {
  Eigen::Vector2d corner_m;
  double side_m;
};
[[nodiscard]] TagPlace tag_place(const CalibrationTarget& target, int tag);

/// The points that are measured in pictures, metres; their numbers are their places in this list. kAprilGrid: four for
/// each tag, clockwise from the top left, each half-way between the tag's corner and that of the square beside it.
/// kCharuco: the inner corners of the chessboard, row by row.
[[nodiscard]] std::vector<Eigen::Vector2d> target_corners(const CalibrationTarget& target);

/// The numbers of the corners of a tag, or of the white square that it is in.
[[nodiscard]] std::vector<int> corners_of_tag(const CalibrationTarget& target, int tag);

/// Within this distance of a corner the print is the same after half a turn about it; metres.
[[nodiscard]] double clear_radius_m(const CalibrationTarget& target);

}  // namespace scanknit
