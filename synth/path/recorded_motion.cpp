#include "synth/path/recorded_motion.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "acquire/replay/text_numbers.h"
#include "core/check.h"
#include "core/files/read_file.h"

namespace scanknit {
Result<std::vector<PathPose>> read_recorded_path(const std::filesystem::path& file, const Limits& limits) {
  const auto text = read_text_file(file, limits.max_text_bytes);
  if (!text) return text.error();
  std::vector<PathPose> path;
  std::int64_t first_ns = 0;
  for (const TextLine& line : text_lines(*text)) {
    const auto refuse = [&](const std::string& why) {
      return Error{ErrorCode::kInput, why, fmt::format("{}:{}", file.string(), line.number)};
    };
    const auto time_ns = parse_seconds_ns(line.words[0]);
    if (!time_ns) return refuse("expected 'seconds tx ty tz qx qy qz qw'");
    const auto pose = parse_tum_pose(line);
    if (!pose) return refuse(pose.error().message);
    if (path.empty()) first_ns = *time_ns;
    const double time_s = (static_cast<double>(*time_ns) - static_cast<double>(first_ns)) * 1e-9;
    if (!path.empty() && time_s <= path.back().time_s) return refuse("expected a time after that of the line above");
    path.push_back({time_s, *pose});
  }
  if (path.size() < 2) return Error{ErrorCode::kInput, "expected a path of at least two poses", file.string()};
  return path;
}

Motion fly_again(std::vector<PathPose> path, const Pose& begin, double frames_per_second) {
  SCANKNIT_CHECK(path.size() >= 2 && frames_per_second > 0);
  const Pose T_here_there = begin * path.front().T_world_camera.inverse();
  return [path = std::move(path), T_here_there, frames_per_second](double frame) -> Pose {
    const double time_s = std::clamp(frame / frames_per_second, 0.0, path.back().time_s);
    const auto after = std::lower_bound(path.begin() + 1, path.end() - 1, time_s,
                                        [](const PathPose& pose, double time) { return pose.time_s < time; });
    const PathPose& from = *std::prev(after);
    const double share = std::clamp((time_s - from.time_s) / (after->time_s - from.time_s), 0.0, 1.0);
    return T_here_there * interpolate(from.T_world_camera, after->T_world_camera, share);
  };
}

}  // namespace scanknit
