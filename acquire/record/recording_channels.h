// The names of a recording's channels, the content of their messages, and the schemas with which other programs can
// read them.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "acquire/mcap/mcap_format.h"
#include "acquire/raw_frame.h"
#include "core/result.h"

namespace scanknit {

inline constexpr const char* kDepthTopic = "scanknit.depth.dz1";
inline constexpr const char* kColourTopic = "scanknit.colour";
inline constexpr const char* kCalibrationTopic = "scanknit.calibration";
inline constexpr const char* kLossesTopic = "scanknit.losses";
inline constexpr const char* kPoseTopic = "scanknit.pose";

/// The channels' ids in our files. Readers use the topics.
enum class RecordingChannel : std::uint16_t { kDepth = 1, kColour = 2, kCalibration = 3, kLosses = 4, kPose = 5 };

[[nodiscard]] std::vector<McapSchema> recording_schemas();
[[nodiscard]] std::vector<McapChannel> recording_channels();

/// JSON.
[[nodiscard]] std::string calibration_text(const RawCalibration& calibration);
[[nodiscard]] std::string losses_text(const LossCounters& losses);
/// The pose of the depth picture with this sequence number.
[[nodiscard]] std::string pose_text(std::uint64_t sequence, const Pose& T_world_camera);

/// Errors (kInput, without `where`): not what calibration_text writes, or a value out of range (cameras without finite
/// focal lengths, a motion that is not rigid, a depth unit that is not between 1e-7 and 1 m).
[[nodiscard]] Result<RawCalibration> parse_calibration(std::span<const std::byte> json);
[[nodiscard]] Result<LossCounters> parse_losses(std::span<const std::byte> json);

struct RecordedPose {
  std::uint64_t sequence = 0;
  Result<Pose> T_world_camera;
};
[[nodiscard]] std::optional<RecordedPose> parse_pose(std::span<const std::byte> json);

}  // namespace scanknit
