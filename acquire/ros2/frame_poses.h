// FramePoses: where a frame of reference of a bag of ROS was.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "acquire/acquire_config.h"
#include "acquire/parse/timed_poses.h"
#include "acquire/ros2/ros2_survey.h"
#include "core/axes.h"

namespace scanknit {

/// ROS has z up in all worlds (REP 103).
inline constexpr UpAxis kRosUp = UpAxis::kZ;

/// Said of a bag whose survey is a sample.
inline constexpr const char* kSampleWarning =
    "a large bag, described by a sample of its messages: the duration is that of recording, and a frame counts as one "
    "with a pose where poses were recorded within 0.1 s";

/// The poses of the topic that is wanted; else tf's and Odometry's where the frame moves in them; else those of the
/// topic of PoseStamped with most messages.
class FramePoses {
 public:
  /// `survey` must outlive it. `wanted.poses`, if given, must be a topic of survey.tracked.
  FramePoses(const Ros2Survey& survey, std::string frame, const BagTopics& wanted);

  [[nodiscard]] bool are_known() const { return is_in_tree_ || tracked_ != nullptr; }
  [[nodiscard]] const std::string& frame() const { return frame_; }
  /// "tf: map from lidar", or the topic. Empty where none are known.
  [[nodiscard]] const std::string& source() const { return source_; }
  /// The topic was not chosen by the user, and may tell of another frame.
  [[nodiscard]] bool is_of_another_frame() const { return is_guessed_; }

  /// T_world_frame; an Error where the recorded one is invalid; nothing where there is none then. Of a survey that is a
  /// sample any pose, where there is one.
  [[nodiscard]] std::optional<Result<Pose>> at(std::int64_t time_ns) const;

 private:
  [[nodiscard]] std::optional<Result<Pose>> sampled_at(std::int64_t time_ns) const;

  const Ros2Survey& survey_;
  std::string frame_, source_;
  bool is_in_tree_;
  bool is_guessed_ = false;
  const std::vector<TimedPose>* tracked_ = nullptr;
};

}  // namespace scanknit
