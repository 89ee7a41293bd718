// PlannedScan: a scan in parts, before any of them is fused: its frames, and what each part needs of them.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "acquire/frame_source.h"
#include "core/axes.h"
#include "core/frame.h"
#include "core/frame_timing.h"
#include "core/result.h"
#include "fusion/bricks/brick_parts.h"
#include "fusion/fusion_config.h"
#include "scan/scan_result.h"

namespace scanknit {

/// Where the poses of a plan come from.
enum class PoseOrigin : std::uint8_t {
  kRecording,  ///< frames have them each time that they are read
  kPlan,       ///< tracked, or from a file: the plan alone has them
};

/// What the report says of tracking.
struct TrackedPoses {
  std::optional<TrackingResult> tracking;
  std::optional<LoopResult> loops;
  FrameTiming timing;  ///< that was assumed
};

struct PlannedScan {
  FusionConfig fusion;           ///< in force
  std::vector<BrickPart> parts;  ///< of all that is fused
  /// The frames by their numbers: frame 1 is the first that is fused. In the order of the recording, but tracked frames
  /// that were found later come at the end.
  Trajectory trajectory;
  std::vector<std::uint32_t> checksums;  ///< of the frames: checksum_of()
  std::vector<std::uint32_t> samples;    ///< numbers of the frames that the mesh is compared with, ascending
  PoseOrigin poses = PoseOrigin::kRecording;
  FrameCounts counts;
  UpAxis world_up = UpAxis::kZ;
  TrackedPoses tracked;  ///< nothing in it unless poses were tracked

  /// In the order of the recording.
  [[nodiscard]] Trajectory recorded_order() const;
};

/// CRC-32 of all that fusing takes from a frame as its source gives it: pictures, cameras, masks, and its pose if that
/// is the recording's.
[[nodiscard]] std::uint32_t checksum_of(const Frame& frame, PoseOrigin poses);

/// The bytes of a plan, little-endian, for parse_planned(). Of `fusion`, only what decides the volume's bits.
[[nodiscard]] std::string bytes_of(const PlannedScan& planned);

/// What bytes_of() wrote; nothing if it is something else, or if `fusion`, which becomes its configuration, gives the
/// volume other bits.
[[nodiscard]] std::optional<PlannedScan> parse_planned(std::string_view bytes, const FusionConfig& fusion);

/// Of bytes_of(): a number that differs, most likely, between other frames, poses, settings or parts. The same on every
/// machine. Bricks carry it.
[[nodiscard]] std::uint64_t plan_id(std::string_view bytes);

}  // namespace scanknit
