#include "acquire/ros2/frame_poses.h"

#include <algorithm>
#include <iterator>
#include <utility>

namespace scanknit {

FramePoses::FramePoses(const Ros2Survey& survey, std::string frame, const BagTopics& wanted)
    : survey_(survey), frame_(std::move(frame)), is_in_tree_(!wanted.poses && survey.tree.is_moving(frame_)) {
  if (wanted.poses) {
    tracked_ = &survey.tracked.at(*wanted.poses);
    source_ = *wanted.poses;
  } else if (is_in_tree_) {
    source_ = "tf: " + survey.tree.root_of(frame_) + " from " + frame_;
  } else if (!survey.tracked.empty()) {
    const auto most = std::max_element(survey.tracked.begin(), survey.tracked.end(),
                                       [](const auto& a, const auto& b) { return a.second.size() < b.second.size(); });
    tracked_ = &most->second;
    source_ = most->first;
    is_guessed_ = true;
  }
}

std::optional<Result<Pose>> FramePoses::at(std::int64_t time_ns) const {
  if (survey_.sampled_ns) return sampled_at(time_ns);
  if (is_in_tree_) return survey_.tree.pose_in_root(frame_, time_ns);
  return tracked_ != nullptr ? pose_at(*tracked_, time_ns) : std::nullopt;
}

/// Whether there is a pose, not which: one where poses were recorded within the reach of pose_at().
std::optional<Result<Pose>> FramePoses::sampled_at(std::int64_t time_ns) const {
  constexpr std::uint64_t kReach_ns = 100'000'000;
  const auto& times = *survey_.sampled_ns;
  const auto after = std::lower_bound(times.begin(), times.end(), time_ns);
  // Times from a file may be anything; unsigned numbers hold the difference of any two.
  const auto since = [](std::int64_t from_ns, std::int64_t to_ns) {
    return static_cast<std::uint64_t>(to_ns) - static_cast<std::uint64_t>(from_ns);
  };
  const bool has_after = after != times.end() && since(time_ns, *after) <= kReach_ns;
  const bool has_before = after != times.begin() && since(*std::prev(after), time_ns) <= kReach_ns;
  return are_known() && (has_after || has_before) ? std::optional(Result<Pose>(Pose::Identity())) : std::nullopt;
}

}  // namespace scanknit
