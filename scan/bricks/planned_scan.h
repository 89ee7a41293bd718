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
#include "core/result.h"
#include "fusion/bricks/brick_parts.h"
#include "fusion/fusion_config.h"
#include "scan/scan_result.h"

namespace scanknit {

struct PlannedScan {
  FusionConfig fusion;                   ///< in force
  std::vector<BrickPart> parts;          ///< of all that is fused
  Trajectory trajectory;                 ///< the frames by their numbers: frame 1 is the first
  std::vector<std::uint32_t> checksums;  ///< of the frames: checksum_of()
  FrameCounts counts;
  UpAxis world_up = UpAxis::kZ;

  /// The frame with this number (from 1); nothing if `sequence` has none.
  [[nodiscard]] std::optional<std::uint32_t> number_of(std::uint64_t sequence) const;
};

/// CRC-32 of all that fusing takes from a frame as its source gives it: pictures, cameras, masks, pose.
[[nodiscard]] std::uint32_t checksum_of(const Frame& frame);

/// The bytes of a plan, little-endian, for parse_planned(). Of `fusion`, only what decides the volume's bits.
[[nodiscard]] std::string bytes_of(const PlannedScan& planned);

/// What bytes_of() wrote; nothing if it is something else, or if `fusion`, which becomes its configuration, gives the
/// volume other bits.
[[nodiscard]] std::optional<PlannedScan> parse_planned(std::string_view bytes, const FusionConfig& fusion);

/// Of bytes_of(): a number that differs, most likely, between other frames, poses, settings or parts. The same on every
/// machine. Bricks carry it.
[[nodiscard]] std::uint64_t plan_id(std::string_view bytes);

}  // namespace scanknit
