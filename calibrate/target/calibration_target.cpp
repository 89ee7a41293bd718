#include "calibrate/target/calibration_target.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace scanknit {
namespace {

/// The square of a ChArUco board that a tag is in: the white ones, row by row.
Eigen::Vector2i square_of_tag(const CalibrationTarget& target, int tag) {
  for (int row = 0; row < target.rows; ++row) {
    const int first = 1 - row % 2;  // squares at an even column + row are black
    const int white = (target.columns - first + 1) / 2;
    if (tag < white) return {first + 2 * tag, row};
    tag -= white;
  }
  return {0, 0};
}

double pitch_m(const CalibrationTarget& target) {
  return target.type == TargetType::kAprilGrid ? (1 + kTagGap) * target.size_m : target.size_m;
}

}  // namespace

Result<void> validate(const CalibrationTarget& target) {
  constexpr int kMostCells = 100;
  constexpr double kLargest_m = 10;
  const int fewest = target.type == TargetType::kAprilGrid ? 2 : 3;
  const auto refuse = [](std::string message) { return Error{ErrorCode::kConfig, std::move(message)}; };
  for (const auto& [name, count] : {std::pair("columns", target.columns), std::pair("rows", target.rows)}) {
    if (count >= fewest && count <= kMostCells) continue;
    return refuse(fmt::format("{}: {}, expected {} to {}", name, count, fewest, kMostCells));
  }
  if (tag_count(target) > kTagsOfFamily) {
    return refuse(fmt::format("columns x rows: {} tags, expected at most {}", tag_count(target), kTagsOfFamily));
  }
  if (!(target.size_m > 0 && target.size_m <= kLargest_m)) {
    return refuse(fmt::format("size: {} m, expected above 0, at most {} m", target.size_m, kLargest_m));
  }
  return {};
}

Eigen::Vector2d extent_m(const CalibrationTarget& target) {
  const Eigen::Vector2d cells(target.columns, target.rows);
  if (target.type == TargetType::kCharuco) return target.size_m * cells;
  const double outer_m = (1 - 2 * kSquareMargin) * kTagGap * target.size_m;
  return pitch_m(target) * cells + Eigen::Vector2d::Constant(outer_m);
}

int tag_count(const CalibrationTarget& target) {
  const int cells = target.columns * target.rows;
  return target.type == TargetType::kAprilGrid ? cells : cells / 2;
}

TagPlace tag_place(const CalibrationTarget& target, int tag) {
  if (target.type == TargetType::kCharuco) {
    const Eigen::Vector2d square = square_of_tag(target, tag).cast<double>();
    const double margin = (1 - kCharucoTag) / 2;
    return {target.size_m * (square + Eigen::Vector2d::Constant(margin)), kCharucoTag * target.size_m};
  }
  const Eigen::Vector2d cell(tag % target.columns, tag / target.columns);
  const double first_m = (1 - kSquareMargin) * kTagGap * target.size_m;  // what is black begins with a square
  return {pitch_m(target) * cell + Eigen::Vector2d::Constant(first_m), target.size_m};
}

std::vector<Eigen::Vector2d> target_corners(const CalibrationTarget& target) {
  std::vector<Eigen::Vector2d> corners;
  if (target.type == TargetType::kCharuco) {
    for (int row = 1; row < target.rows; ++row) {
      for (int column = 1; column < target.columns; ++column) {
        corners.push_back(target.size_m * Eigen::Vector2d(column, row));
      }
    }
    return corners;
  }
  const double beyond_m = kSquareMargin * kTagGap * target.size_m / 2;
  for (int tag = 0; tag < tag_count(target); ++tag) {
    const TagPlace place = tag_place(target, tag);
    const double low = -beyond_m;
    const double high = place.side_m + beyond_m;
    for (const Eigen::Vector2d& corner : {Eigen::Vector2d(low, low), Eigen::Vector2d(high, low),
                                          Eigen::Vector2d(high, high), Eigen::Vector2d(low, high)}) {
      corners.push_back(place.corner_m + corner);
    }
  }
  return corners;
}

std::vector<int> corners_of_tag(const CalibrationTarget& target, int tag) {
  if (target.type == TargetType::kAprilGrid) return {4 * tag, 4 * tag + 1, 4 * tag + 2, 4 * tag + 3};
  const Eigen::Vector2i square = square_of_tag(target, tag);
  constexpr std::array<std::array<int, 2>, 4> kAround = {{{0, 0}, {1, 0}, {1, 1}, {0, 1}}};
  std::vector<int> corners;
  for (const auto& [right, down] : kAround) {
    const int column = square.x() + right;
    const int row = square.y() + down;
    const bool is_inner = column > 0 && row > 0 && column < target.columns && row < target.rows;
    if (is_inner) corners.push_back((row - 1) * (target.columns - 1) + column - 1);
  }
  return corners;
}

// AprilGrid: a tag's border is one cell wide. ChArUco: as far as a tag stays away from its square's sides.
double clear_radius_m(const CalibrationTarget& target) {
  return target.size_m * (target.type == TargetType::kAprilGrid ? 1.0 / kTagCells : (1 - kCharucoTag) / 2);
}

}  // namespace scanknit
