#include "acquire/ros2/ros2_entries.h"

#include <algorithm>
#include <string>
#include <utility>

#include "acquire/replay/frame_pairing.h"

namespace scanknit {
namespace {

/// Half of the usual time from one picture to the next.
std::int64_t reach_ns(std::vector<std::int64_t> times_ns) {
  std::sort(times_ns.begin(), times_ns.end());
  std::vector<double> steps_s;
  for (std::size_t i = 1; i < times_ns.size(); ++i) {
    steps_s.push_back((static_cast<double>(times_ns[i]) - static_cast<double>(times_ns[i - 1])) * 1e-9);
  }
  StreamProfile profile;
  if (!steps_s.empty()) {
    const auto middle = steps_s.begin() + static_cast<std::ptrdiff_t>(steps_s.size() / 2);
    std::nth_element(steps_s.begin(), middle, steps_s.end());
    if (*middle > 0) profile.frames_per_second = 1 / *middle;
  }
  return pairing_reach_ns(profile);
}

/// Where the depth camera was; sets whence that is known.
class DepthPoses {
 public:
  DepthPoses(const Ros2Survey& survey, const std::string& depth_frame, const BagTopics& wanted, Recording& recording)
      : survey_(survey), frame_(depth_frame), is_in_tree_(!wanted.poses && survey.tree.is_moving(depth_frame)) {
    if (wanted.poses) {
      tracked_ = &survey.tracked.at(*wanted.poses);
      recording.topics["poses"] = *wanted.poses;
    } else if (is_in_tree_) {
      recording.topics["poses"] = "tf: " + survey.tree.root_of(frame_) + " from " + frame_;
    } else if (!survey.tracked.empty()) {
      const auto most =
          std::max_element(survey.tracked.begin(), survey.tracked.end(),
                           [](const auto& a, const auto& b) { return a.second.size() < b.second.size(); });
      tracked_ = &most->second;
      recording.topics["poses"] = most->first;
      recording.warnings.push_back("tf does not lead from '" + frame_ + "' to a world: the poses of " + most->first +
                                   " are taken for the depth camera's");
    }
    // ROS has z up in all worlds (REP 103).
    if (is_in_tree_ || tracked_ != nullptr) recording.world_up = UpAxis::kZ;
  }

  [[nodiscard]] std::optional<Result<Pose>> at(std::int64_t time_ns) const {
    if (survey_.sampled_ns) return sampled_at(time_ns);
    if (is_in_tree_) return survey_.tree.pose_in_root(frame_, time_ns);
    return tracked_ != nullptr ? pose_at(*tracked_, time_ns) : std::nullopt;
  }

 private:
  /// Whether there is a pose, not which: one where poses were recorded within the reach of pose_at().
  [[nodiscard]] std::optional<Result<Pose>> sampled_at(std::int64_t time_ns) const {
    constexpr std::uint64_t kReach_ns = 100'000'000;
    const auto& times = *survey_.sampled_ns;
    const auto after = std::lower_bound(times.begin(), times.end(), time_ns);
    // Times from a file may be anything; unsigned numbers hold the difference of any two.
    const auto since = [](std::int64_t from_ns, std::int64_t to_ns) {
      return static_cast<std::uint64_t>(to_ns) - static_cast<std::uint64_t>(from_ns);
    };
    const bool has_after = after != times.end() && since(time_ns, *after) <= kReach_ns;
    const bool has_before = after != times.begin() && since(*std::prev(after), time_ns) <= kReach_ns;
    const bool has_poses = is_in_tree_ || tracked_ != nullptr;
    return has_poses && (has_after || has_before) ? std::optional(Result<Pose>(Pose::Identity())) : std::nullopt;
  }

  const Ros2Survey& survey_;
  std::string frame_;
  bool is_in_tree_;
  const std::vector<TimedPose>* tracked_ = nullptr;
};

}  // namespace

void add_ros2_entries(const Ros2Survey& survey, const PictureTopic& depth, const PictureTopic* colour,
                      const BagTopics& wanted, Recording& recording) {
  const DepthPoses poses(survey, depth.frame, wanted, recording);
  const auto& depth_ns = depth.times_ns;
  const auto colour_ns = colour != nullptr ? colour->times_ns : std::vector<std::int64_t>();
  const auto partners = pair_by_time(depth_ns, colour_ns, reach_ns(colour_ns));
  recording.entries.reserve(depth_ns.size());
  for (std::size_t i = 0; i < depth_ns.size(); ++i) {
    FrameEntry entry{.sequence = i, .timestamp_ns = depth_ns[i]};
    entry.depth = recording.folder;
    entry.depth_index = i;
    if (partners[i]) {
      entry.colour = recording.folder;
      entry.colour_index = *partners[i];
    }
    entry.T_world_camera = poses.at(depth_ns[i]);
    recording.entries.push_back(std::move(entry));
  }
}

}  // namespace scanknit
