#include "acquire/replay/text_numbers.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "core/files/ascii_numbers.h"

namespace scanknit {
namespace {

std::vector<std::string_view> words_of(std::string_view line) {
  std::vector<std::string_view> words;
  for (std::string_view word = take_word(line); !word.empty(); word = take_word(line)) words.push_back(word);
  return words;
}

}  // namespace

std::vector<TextLine> text_lines(std::string_view text) {
  std::vector<TextLine> lines;
  for (std::size_t number = 1; !text.empty(); ++number) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string_view line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    line = line.substr(0, line.find('#'));
    if (auto words = words_of(line); !words.empty()) lines.push_back({number, std::move(words)});
  }
  return lines;
}

std::optional<std::vector<double>> parse_numbers(std::string_view text) {
  std::vector<double> numbers;
  for (const TextLine& line : text_lines(text)) {
    for (const std::string_view word : line.words) {
      const auto number = parse_double(word);
      if (!number) return std::nullopt;
      numbers.push_back(*number);
    }
  }
  return numbers;
}

std::optional<std::int64_t> parse_seconds_ns(std::string_view word) {
  const auto seconds = parse_double(word);
  constexpr double kMaxSeconds = 9.0e9;  // the year 2255; 2^63 ns is 9.22e9 s
  if (!seconds || !(std::abs(*seconds) <= kMaxSeconds)) return std::nullopt;
  // Signs and exponents are rare and short: a double holds them. Plain digits are taken as they stand.
  if (word.find_first_not_of("0123456789.") != std::string_view::npos) return std::llround(*seconds * 1e9);
  const std::size_t dot = std::min(word.find('.'), word.size());
  std::int64_t time_ns = 0;
  for (const char c : word.substr(0, dot)) time_ns = 10 * time_ns + (c - '0');
  constexpr std::size_t kDecimals = 9;
  for (std::size_t i = dot + 1; i <= dot + kDecimals; ++i) {
    time_ns = 10 * time_ns + (i < word.size() ? word[i] - '0' : 0);
  }
  return time_ns;
}

Result<Pose> pose_from_numbers(const std::vector<double>& row_major) {
  if (row_major.size() != 16) {
    return Error{ErrorCode::kInput,
                 "the pose has " + std::to_string(row_major.size()) + " numbers, expected a 4x4 matrix"};
  }
  return pose_from_matrix(Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(row_major.data()));
}

Result<Pose> pose_from_quaternion(const Eigen::Vector3d& position, const Eigen::Vector4d& xyzw) {
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  matrix.topLeftCorner<3, 3>() = Eigen::Quaterniond(xyzw[3], xyzw[0], xyzw[1], xyzw[2]).toRotationMatrix();
  matrix.topRightCorner<3, 1>() = position;
  // A zero quaternion gives the identity matrix: it says nothing and is refused like any other that is not of length 1.
  if (position.allFinite() && xyzw.allFinite() && std::abs(xyzw.norm() - 1) > 0.01) {
    return Error{ErrorCode::kInput, "the pose is not rigid: its quaternion's length is not 1"};
  }
  return pose_from_matrix(matrix);
}

Result<Pose> parse_tum_pose(const TextLine& line) {
  Eigen::Matrix<double, 7, 1> values;
  if (line.words.size() < 8) return Error{ErrorCode::kInput, "expected 'seconds tx ty tz qx qy qz qw'"};
  for (int i = 0; i < 7; ++i) {
    const auto number = parse_double(line.words[static_cast<std::size_t>(i) + 1]);
    if (!number) return Error{ErrorCode::kInput, "expected 'seconds tx ty tz qx qy qz qw'"};
    values[i] = *number;
  }
  return pose_from_quaternion(values.head<3>(), values.tail<4>());
}

}  // namespace scanknit
