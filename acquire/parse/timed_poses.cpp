#include "acquire/parse/timed_poses.h"

#include <algorithm>
#include <limits>
#include <string>
#include <utility>

#include "acquire/replay/text_numbers.h"
#include "core/files/read_file.h"

namespace scanknit {

std::int64_t distance_ns(std::int64_t a, std::int64_t b) {
  std::int64_t difference = 0;
  if (__builtin_sub_overflow(std::max(a, b), std::min(a, b), &difference)) {
    return std::numeric_limits<std::int64_t>::max();
  }
  return difference;
}

void sort_by_time(std::vector<TimedPose>& poses) {
  std::stable_sort(poses.begin(), poses.end(),
                   [](const TimedPose& a, const TimedPose& b) { return a.time_ns < b.time_ns; });
}

Result<std::vector<TimedPose>> read_tum_poses(const std::filesystem::path& path, const Limits& limits) {
  const auto text = read_text_file(path, limits.max_text_bytes);
  if (!text) return text.error();
  std::vector<TimedPose> poses;
  for (const TextLine& line : text_lines(*text)) {
    const std::string where = path.string() + ":" + std::to_string(line.number);
    const auto time = parse_seconds_ns(line.words[0]);
    if (!time) return Error{ErrorCode::kInput, "expected 'seconds tx ty tz qx qy qz qw'", where};
    auto pose = parse_tum_pose(line);
    if (!pose) pose = Error{ErrorCode::kInput, pose.error().message, where};
    poses.push_back({*time, std::move(pose)});
  }
  sort_by_time(poses);
  return poses;
}

std::optional<Result<Pose>> pose_at(const std::vector<TimedPose>& poses, std::int64_t time_ns,
                                    std::int64_t max_gap_ns) {
  const auto after = std::lower_bound(poses.begin(), poses.end(), time_ns,
                                      [](const TimedPose& pose, std::int64_t time) { return pose.time_ns < time; });
  if (after != poses.end() && after->time_ns == time_ns) return after->pose;
  const bool has_after = after != poses.end();
  const bool has_before = after != poses.begin();
  if (!has_after && !has_before) return std::nullopt;
  if (!has_after || !has_before) {
    const TimedPose& end = has_after ? *after : *std::prev(after);
    if (distance_ns(end.time_ns, time_ns) > kMaxDifference_ns) return std::nullopt;
    return end.pose;
  }
  const TimedPose& before = *std::prev(after);
  const std::int64_t gap = distance_ns(before.time_ns, after->time_ns);
  const std::int64_t to_nearest = std::min(distance_ns(before.time_ns, time_ns), distance_ns(after->time_ns, time_ns));
  if (gap > max_gap_ns && to_nearest > kMaxDifference_ns) return std::nullopt;
  if (!before.pose) return before.pose;
  if (!after->pose) return after->pose;
  const double fraction = static_cast<double>(distance_ns(before.time_ns, time_ns)) / static_cast<double>(gap);
  return Result<Pose>(interpolate(*before.pose, *after->pose, fraction));
}

}  // namespace scanknit
