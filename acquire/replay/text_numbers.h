// Parses text files: lines without comments, words, numbers, times.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "core/pose.h"
#include "core/result.h"

namespace scanknit {

struct TextLine {
  std::size_t number = 0;               ///< from 1
  std::vector<std::string_view> words;  ///< at least one
};

/// The lines without blank ones and without comments ('#' to the end of the line). Blanks, tabs and carriage returns
/// separate words. The views point into `text`.
[[nodiscard]] std::vector<TextLine> text_lines(std::string_view text);

/// Every word of `text` as a number; nothing if a word is no number.
[[nodiscard]] std::optional<std::vector<double>> parse_numbers(std::string_view text);

/// Decimal seconds as nanoseconds, without the rounding of a double; nothing when it is no number or out of range.
[[nodiscard]] std::optional<std::int64_t> parse_seconds_ns(std::string_view word);

/// A pose from sixteen numbers, row by row; see pose_from_matrix.
[[nodiscard]] Result<Pose> pose_from_numbers(const std::vector<double>& row_major);

/// Errors (kInput): the quaternion (x, y, z, w) has not the length 1; see pose_from_matrix.
[[nodiscard]] Result<Pose> pose_from_quaternion(const Eigen::Vector3d& position, const Eigen::Vector4d& xyzw);

/// A pose of the TUM format, "seconds tx ty tz qx qy qz qw": all but the seconds. Errors: kInput where the line is
/// short, a word is no number, or the pose is not rigid.
[[nodiscard]] Result<Pose> parse_tum_pose(const TextLine& line);

}  // namespace scanknit
