#include <algorithm>
#include <array>
#include <cmath>

#include "acquire/range/range_files.h"
#include "core/checked_math.h"
#include "core/files/ascii_numbers.h"

namespace scanknit {
namespace {

constexpr std::size_t kLeastPointBytes = 6;  // "0 0 0\n"

/// Lines of numbers, counted for messages.
class PtxLines {
 public:
  explicit PtxLines(std::string_view text) : text_(text) {}

  [[nodiscard]] std::size_t remaining() const { return text_.size(); }

  /// The next line that holds anything; empty at the end.
  [[nodiscard]] std::string_view next() {
    while (!text_.empty()) {
      ++number_;
      std::string_view line = take_line(text_);
      std::string_view rest = line;
      if (!take_word(rest).empty()) return line;
    }
    return {};
  }
  [[nodiscard]] Error error(const std::string& what) const {
    return {ErrorCode::kInput, "PTX line " + std::to_string(number_) + ": " + what};
  }

  template <std::size_t N>
  [[nodiscard]] Result<std::array<double, N>> numbers() {
    std::string_view line = next();
    std::array<double, N> values{};
    for (double& value : values) {
      const auto number = parse_double(take_word(line));
      if (!number || !std::isfinite(*number))
        return error(std::to_string(N) + " finite numbers were expected; is the file whole?");
      value = *number;
    }
    return values;
  }

 private:
  std::string_view text_;
  std::size_t number_ = 0;
};

Result<int> count_line(PtxLines& lines, std::string_view first, const Limits& limits, const char* what) {
  std::string_view words = first.empty() ? lines.next() : first;
  const auto count = parse_integer(take_word(words));
  if (!count || *count < 1 || *count > limits.max_image_pixels) {
    return lines.error(std::string("the number of ") + what + " was expected, a whole number above 0");
  }
  return static_cast<int>(*count);
}

/// The 4x4 matrix is written for row vectors: its last row is the translation.
Result<Pose> read_pose(PtxLines& lines) {
  Eigen::Matrix4d transposed;
  for (int row = 0; row < 4; ++row) {
    const auto values = lines.numbers<4>();
    if (!values) return values.error();
    transposed.row(row) << (*values)[0], (*values)[1], (*values)[2], (*values)[3];
  }
  auto pose = pose_from_matrix(transposed.transpose());
  if (!pose) return lines.error(pose.error().message);
  return pose;
}

/// One "x y z [intensity [r g b]]".
struct PtxPoint {
  Eigen::Vector3d position;
  std::optional<double> intensity;
  std::optional<Rgb8> colour;
};

Result<PtxPoint> read_point(PtxLines& lines) {
  std::string_view line = lines.next();
  std::array<double, 7> v{};
  std::size_t count = 0;
  for (std::string_view word = take_word(line); !word.empty() && count < v.size(); word = take_word(line)) {
    const auto number = parse_double(word);
    if (!number) return lines.error("a number was expected, not '" + std::string(word) + "'");
    v[count++] = *number;
  }
  if (count != 3 && count != 4 && count != 7) {
    return lines.error("a point x y z [intensity [r g b]] was expected; is the file whole?");
  }
  PtxPoint point{{v[0], v[1], v[2]}, {}, {}};
  if (!point.position.allFinite()) return point;
  if (!std::all_of(v.begin(), v.end(), [](double value) { return std::isfinite(value); }))
    return lines.error("an intensity or a colour is not finite");
  const auto byte = [](double value) { return static_cast<std::uint8_t>(std::clamp(value, 0.0, 255.0)); };
  if (count >= 4) point.intensity = v[3];
  if (count == 7) point.colour = Rgb8{byte(v[4]), byte(v[5]), byte(v[6])};
  return point;
}

Rgb8 colour_of(const PtxPoint& point) {
  if (point.colour) return *point.colour;
  const auto grey = static_cast<std::uint8_t>(std::clamp(*point.intensity * 255, 0.0, 255.0));
  return {grey, grey, grey};
}

Result<RangeScan> read_scan(PtxLines& lines, std::string_view first, const Limits& limits) {
  const auto columns = count_line(lines, first, limits, "columns");
  if (!columns) return columns.error();
  const auto rows = count_line(lines, {}, limits, "rows");
  if (!rows) return rows.error();
  const auto cells = checked_mul(std::int64_t{*columns}, std::int64_t{*rows});
  if (!cells || *cells > limits.max_image_pixels) {
    return lines.error("more points than the limit of " + std::to_string(limits.max_image_pixels));
  }
  for (int i = 0; i < 4; ++i) {  // the registered position and axes say the same as the matrix
    if (const auto values = lines.numbers<3>(); !values) return values.error();
  }
  const auto pose = read_pose(lines);
  if (!pose) return pose.error();
  if (static_cast<std::size_t>(*cells) > lines.remaining() / kLeastPointBytes + 1) {
    return lines.error("truncated: " + std::to_string(lines.remaining()) + " bytes cannot hold " +
                       std::to_string(*cells) + " points");
  }
  RangeScan scan;
  scan.points_m = Image<Eigen::Vector3f>(*columns, *rows, kNoReturn);
  scan.sight = {.kind = SightLines::Kind::kSphere, .pole = 2};
  scan.T_world_scan = *pose;
  for (int x = 0; x < *columns; ++x) {
    for (int y = *rows - 1; y >= 0; --y) {
      const auto point = read_point(lines);
      if (!point) return point.error();
      const Eigen::Vector3f position = point->position.cast<float>();
      if (position.isZero(0) || !position.allFinite()) continue;
      scan.points_m.at(x, y) = position;
      if (!point->intensity) continue;
      if (scan.colours.empty()) scan.colours = Image<Rgb8>(*columns, *rows);
      scan.colours.at(x, y) = colour_of(*point);
    }
  }
  return scan;
}

}  // namespace

Result<std::vector<RangeScan>> parse_ptx(std::string_view bytes, const Limits& limits) {
  PtxLines lines(bytes);
  std::vector<RangeScan> scans;
  for (std::string_view first = lines.next(); !first.empty(); first = lines.next()) {
    if (scans.size() >= limits.max_scans)
      return lines.error("more scans than the limit of " + std::to_string(limits.max_scans));
    auto scan = read_scan(lines, first, limits);
    if (!scan) return scan.error();
    scans.push_back(*std::move(scan));
  }
  if (scans.empty()) return Error{ErrorCode::kInput, "PTX: empty; the numbers of columns and rows were expected"};
  return scans;
}

}  // namespace scanknit
