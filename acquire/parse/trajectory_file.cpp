#include "acquire/parse/trajectory_file.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <string>
#include <string_view>
#include <utility>

#include "acquire/parse/json_numbers.h"
#include "acquire/parse/kitti_poses.h"
#include "acquire/parse/transforms_json.h"
#include "core/files/read_file.h"

namespace scanknit {
namespace {

constexpr double kNsPerSecond = 1e9;
constexpr double kMostStamp_s = 9e9;  // nanoseconds of it fit 64 bits

Error no_trajectory_json(const std::filesystem::path& path) {
  return {ErrorCode::kInput,
          "not a trajectory: expected {\"poses\": [{\"stamp\": ..., \"T_world_camera\": four rows}]}", path.string()};
}

Result<std::vector<TimedPose>> read_json_poses(const std::filesystem::path& path, const Limits& limits) {
  const auto json = read_json_object(path, limits);
  if (!json) return json.error();
  const auto list = json->find("poses");
  if (list == json->end() || !list->is_array()) return no_trajectory_json(path);
  std::vector<TimedPose> poses;
  for (const auto& entry : *list) {
    const auto stamp = entry.is_object() ? json_number(entry, "stamp") : std::nullopt;
    if (!stamp || !(std::abs(*stamp) < kMostStamp_s) || !entry.contains("T_world_camera")) {
      return no_trajectory_json(path);
    }
    const auto matrix = matrix_of(entry["T_world_camera"]);
    if (!matrix) return no_trajectory_json(path);
    auto pose = pose_from_matrix(*matrix);
    if (!pose) pose = Error{ErrorCode::kInput, pose.error().message, path.string()};
    poses.push_back({std::llround(*stamp * kNsPerSecond), std::move(pose)});
  }
  sort_by_time(poses);
  return poses;
}

}  // namespace

Result<TrajectoryFile> TrajectoryFile::read(const std::filesystem::path& path, const Limits& limits) {
  TrajectoryFile file;
  if (path.extension() == ".kitti") {
    const auto text = read_text_file(path, limits.max_text_bytes);
    if (!text) return text.error();
    file.by_place_ = parse_kitti_poses(*text);
  } else {
    auto poses = path.extension() == ".json" ? read_json_poses(path, limits) : read_tum_poses(path, limits);
    if (!poses) return poses.error();
    file.by_time_ = *std::move(poses);
    for (std::size_t i = 0; i < file.by_time_.size(); ++i) {
      file.by_number_.emplace(static_cast<double>(file.by_time_[i].time_ns) / kNsPerSecond, i);
    }
  }
  if (file.by_place_.empty() && file.by_time_.empty()) {
    return Error{ErrorCode::kInput, "has no poses; expected the TUM format, KITTI's (.kitti) or JSON (.json)",
                 path.string()};
  }
  return file;
}

std::optional<Result<Pose>> TrajectoryFile::pose_of(const Frame& frame, std::size_t place) const {
  constexpr std::int64_t kSame_ns = 1000;  // a stamp is a double: 240 ns at the time of day
  if (!by_place_.empty()) return place < by_place_.size() ? std::optional(by_place_[place]) : std::nullopt;
  if (!frame.has_clock) {
    const auto found = by_number_.find(static_cast<double>(frame.sequence));
    return found == by_number_.end() ? std::nullopt : std::optional(by_time_[found->second].pose);
  }
  const auto after = std::lower_bound(by_time_.begin(), by_time_.end(), frame.timestamp_ns,
                                      [](const TimedPose& pose, std::int64_t time) { return pose.time_ns < time; });
  const TimedPose* nearest = nullptr;
  for (auto at = after == by_time_.begin() ? after : std::prev(after); at != by_time_.end(); ++at) {
    if (distance_ns(at->time_ns, frame.timestamp_ns) <= kSame_ns) nearest = &*at;
    if (nearest != nullptr || at->time_ns > frame.timestamp_ns) break;
  }
  return nearest != nullptr ? std::optional(nearest->pose) : pose_at(by_time_, frame.timestamp_ns);
}

std::optional<std::size_t> TrajectoryFile::count_by_place() const {
  return by_place_.empty() ? std::nullopt : std::optional(by_place_.size());
}

}  // namespace scanknit
