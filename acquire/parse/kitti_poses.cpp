#include "acquire/parse/kitti_poses.h"

#include <fmt/format.h>

#include <utility>

#include "acquire/replay/text_numbers.h"
#include "core/files/ascii_numbers.h"

namespace scanknit {

Result<Pose> kitti_pose(std::span<const std::string_view> words) {
  constexpr std::size_t kNumbers = 12;
  if (words.size() != kNumbers) {
    return Error{ErrorCode::kInput, fmt::format("expected 12 numbers, a 3x4 matrix; there are {}", words.size())};
  }
  std::vector<double> numbers;
  for (const std::string_view word : words) {
    const auto number = parse_double(word);
    if (!number) return Error{ErrorCode::kInput, "the matrix holds a word that is no number"};
    numbers.push_back(*number);
  }
  numbers.insert(numbers.end(), {0, 0, 0, 1});
  return pose_from_numbers(numbers);
}

std::vector<Result<Pose>> parse_kitti_poses(std::string_view text) {
  std::vector<Result<Pose>> poses;
  for (const TextLine& line : text_lines(text)) {
    auto pose = kitti_pose(line.words);
    if (!pose) pose = Error{ErrorCode::kInput, fmt::format("line {}: {}", line.number, pose.error().message)};
    poses.push_back(std::move(pose));
  }
  return poses;
}

}  // namespace scanknit
