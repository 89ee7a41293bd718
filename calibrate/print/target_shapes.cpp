#include "calibrate/print/target_shapes.h"

#include "calibrate/board/calibrate_opencv.h"

namespace scanknit {
namespace {

/// A rectangle for each run of black cells in a row of the tag.
void add_tag(const TagCells& cells, const TagPlace& place, std::vector<BlackRectangle>& shapes) {
  const double cell_m = place.side_m / kTagCells;
  for (int row = 0; row < kTagCells; ++row) {
    for (int begin = 0; begin < kTagCells;) {
      int end = begin;
      while (end < kTagCells && cells.is_black(end, row)) ++end;
      if (end > begin) {
        shapes.push_back(
            {place.corner_m + cell_m * Eigen::Vector2d(begin, row), cell_m * Eigen::Vector2d(end - begin, 1)});
      }
      begin = end + 1;
    }
  }
}

void add_chessboard(const CalibrationTarget& target, std::vector<BlackRectangle>& shapes) {
  for (int row = 0; row < target.rows; ++row) {
    for (int column = row % 2; column < target.columns; column += 2) {
      shapes.push_back({target.size_m * Eigen::Vector2d(column, row), Eigen::Vector2d::Constant(target.size_m)});
    }
  }
}

void add_squares(const CalibrationTarget& target, std::vector<BlackRectangle>& shapes) {
  const double side_m = (1 - 2 * kSquareMargin) * kTagGap * target.size_m;
  const double pitch_m = (1 + kTagGap) * target.size_m;
  for (int row = 0; row <= target.rows; ++row) {
    for (int column = 0; column <= target.columns; ++column) {
      shapes.push_back({pitch_m * Eigen::Vector2d(column, row), Eigen::Vector2d::Constant(side_m)});
    }
  }
}

}  // namespace

Result<std::vector<BlackRectangle>> target_shapes(const CalibrationTarget& target) {
  const auto opencv = load_calibrate_opencv();
  if (!opencv) return opencv.error();
  std::vector<BlackRectangle> shapes;
  if (target.type == TargetType::kCharuco) {
    add_chessboard(target, shapes);
  } else {
    add_squares(target, shapes);
  }
  for (int tag = 0; tag < tag_count(target); ++tag) {
    add_tag((*opencv)->tag_cells(tag), tag_place(target, tag), shapes);
  }
  return shapes;
}

}  // namespace scanknit
