#include "acquire/ros2/ros2_entries.h"

#include <algorithm>
#include <array>
#include <string>
#include <utility>

#include "acquire/replay/frame_pairing.h"
#include "acquire/ros2/cdr_reader.h"

namespace scanknit {
namespace {

/// The time in its header; the time of recording where that is 0 or cannot be read.
std::int64_t time_of(BagMessages& bag, std::size_t message) {
  std::array<std::byte, 12> front{};  // CDR's head or ROS 1's number, seconds, nanoseconds
  const std::int64_t recorded_ns = bag.entry(message).log_ns;
  if (!bag.peek(message, front)) return recorded_ns;
  auto cdr = CdrReader::open({front, bag.encoding()});
  if (cdr && cdr->is_ros1()) (void)cdr->number<std::uint32_t>();
  const auto seconds = cdr ? cdr->number<std::int32_t>() : std::nullopt;
  const auto nanoseconds = cdr ? cdr->number<std::uint32_t>() : std::nullopt;
  if (!seconds || !nanoseconds || (*seconds == 0 && *nanoseconds == 0)) return recorded_ns;
  return std::int64_t{*seconds} * 1'000'000'000 + *nanoseconds;
}

std::vector<std::int64_t> times_of(BagMessages& bag, const PictureTopic& topic) {
  std::vector<std::int64_t> times_ns;
  for (const std::size_t message : topic.messages) times_ns.push_back(time_of(bag, message));
  return times_ns;
}

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
    if (is_in_tree_) return survey_.tree.pose_in_root(frame_, time_ns);
    return tracked_ != nullptr ? pose_at(*tracked_, time_ns) : std::nullopt;
  }

 private:
  const Ros2Survey& survey_;
  std::string frame_;
  bool is_in_tree_;
  const std::vector<TimedPose>* tracked_ = nullptr;
};

}  // namespace

void add_ros2_entries(BagMessages& bag, const Ros2Survey& survey, const PictureTopic& depth, const PictureTopic* colour,
                      const BagTopics& wanted, Recording& recording) {
  const DepthPoses poses(survey, depth.frame, wanted, recording);
  const auto depth_ns = times_of(bag, depth);
  const auto colour_ns = colour != nullptr ? times_of(bag, *colour) : std::vector<std::int64_t>();
  const auto partners = pair_by_time(depth_ns, colour_ns, reach_ns(colour_ns));
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
